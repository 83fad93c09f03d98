/// Loads positions or orientations of `laneCount` segments from their poses, a segment a lane.
#pragma once

#include <cstdint>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/base/vec.hpp"

namespace nanoweft {

NW_INLINE Vec3<Lanes> gatherPositions(const double* pose, const std::int32_t* index) {
  const auto c = loadRows<3>(pose, [&](std::size_t lane) { return std::int64_t{8} * index[lane]; });
  return {c[0], c[1], c[2]};
}

NW_INLINE Quat<Lanes> gatherOrientations(const double* pose, const std::int32_t* index) {
  const auto c =
      loadRows<4>(pose + 4, [&](std::size_t lane) { return std::int64_t{8} * index[lane]; });
  return {c[0], c[1], c[2], c[3]};
}

}  // namespace nanoweft
