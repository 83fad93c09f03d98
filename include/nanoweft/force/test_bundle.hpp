/// The bundle by which errors of a pair law are judged: 61 fibres in hexagonal packing.
#pragma once

#include <array>
#include <cstdlib>
#include <vector>

namespace nanoweft {

/// Rings of fibres around the one in the middle.
inline constexpr int bundleRings = 4;

/// Places across the fibres, in spacings along two axes at 60 degrees.
inline std::vector<std::array<int, 2>> bundlePlaces() {
  std::vector<std::array<int, 2>> places;
  for (int a = -bundleRings; a <= bundleRings; ++a)
    for (int b = -bundleRings; b <= bundleRings; ++b)
      if (std::abs(a + b) <= bundleRings) places.push_back({a, b});
  return places;
}

}  // namespace nanoweft
