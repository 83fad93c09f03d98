/// The simulation box: open or periodic in each direction.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/base/vec.hpp"

namespace nanoweft {

inline double roundToNearest(double x) {
  return std::nearbyint(x);
}
template <class T, class Abi>
stdx::simd<T, Abi> roundToNearest(const stdx::simd<T, Abi>& x) {
  return nearbyint(x);
}

struct Box {
  std::array<double, 3> lower{}, upper{};
  std::array<bool, 3> periodic{};

  double length(int d) const { return upper[d] - lower[d]; }

  /// Brings a position into the box in the periodic directions and counts the wraps. A position
  /// that is inside keeps its bits, so wrapping at any time gives the same trajectory.
  void wrap(double* x, std::int32_t* image) const {
    for (int d = 0; d < 3; ++d) {
      if (!periodic[d] || (x[d] >= lower[d] && x[d] < upper[d])) continue;
      const double turns = std::floor((x[d] - lower[d]) / length(d));
      x[d] -= turns * length(d);
      image[d] += static_cast<std::int32_t>(turns);
      // A tiny negative offset rounds up to the upper face, which is the lower face.
      if (x[d] >= upper[d]) {
        x[d] = lower[d];
        ++image[d];
      } else if (x[d] < lower[d]) {
        x[d] = lower[d];
      }
    }
  }
};

/// Minimum-image differences. The difference is reduced, never the positions, so it is exactly
/// antisymmetric. In open directions both factors are zero and nothing changes.
class MinimumImage {
 public:
  explicit MinimumImage(const Box& box) {
    for (int d = 0; d < 3; ++d) {
      period_[d] = box.periodic[d] ? box.length(d) : 0.0;
      inverse_[d] = box.periodic[d] ? 1.0 / box.length(d) : 0.0;
      any_ = any_ || box.periodic[d];
    }
  }

  template <class V>
  Vec3<V> operator()(Vec3<V> d) const {
    if (!any_) return d;
    d.x -= period_[0] * roundToNearest(V(d.x * inverse_[0]));
    d.y -= period_[1] * roundToNearest(V(d.y * inverse_[1]));
    d.z -= period_[2] * roundToNearest(V(d.z * inverse_[2]));
    return d;
  }

 private:
  double period_[3], inverse_[3];
  bool any_ = false;
};

}  // namespace nanoweft
