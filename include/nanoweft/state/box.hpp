/// The simulation box: open or periodic in each direction, straight or tilted.
#pragma once

#include <algorithm>
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

/// Of a box whose images slide: the period across axis `across` (> `along`) also leads by `way`
/// along axis `along`. Both are periodic. `way` 0: the box is straight.
struct Tilt {
  int along = 0, across = 1;
  double way = 0;

  explicit operator bool() const { return way != 0; }
  /// Of this pair of axes among xy, xz, yz.
  int place() const { return along + across - 1; }
  static Tilt ofPair(int place, double way) { return {place / 2, 1 + (place + 1) / 2, way}; }
  bool operator==(const Tilt&) const = default;
};

struct Box {
  std::array<double, 3> lower{}, upper{};
  std::array<bool, 3> periodic{};
  Tilt tilt{};

  double length(int d) const { return upper[d] - lower[d]; }

  /// Brings a position into the box in the periodic directions and counts the wraps. A position
  /// that is inside keeps its bits, so wrapping at any time gives the same trajectory. Positions in
  /// a tilted box, too, lie between the corners: the images slide, not the box.
  void wrap(double* x, std::int32_t* image) const {
    // A turn across the tilt moves the point along it, so that axis comes first.
    for (int d = 2; d >= 0; --d) {
      if (!periodic[d] || (x[d] >= lower[d] && x[d] < upper[d])) continue;
      const double turns = std::floor((x[d] - lower[d]) / length(d));
      x[d] -= turns * length(d);
      image[d] += static_cast<std::int32_t>(turns);
      if (d == tilt.across) x[tilt.along] -= turns * tilt.way;
      // A tiny negative offset rounds up to the upper face, which is the lower face.
      if (x[d] >= upper[d]) {
        x[d] = lower[d];
        ++image[d];
        if (d == tilt.across) x[tilt.along] -= tilt.way;
      } else if (x[d] < lower[d]) {
        x[d] = lower[d];
      }
    }
  }

  /// The position without wraps, continuous in time.
  Vec3d unwrapped(const double* x, const std::int32_t* image) const {
    double at[3];
    for (int d = 0; d < 3; ++d) at[d] = x[d] + image[d] * length(d);
    at[tilt.along] += image[tilt.across] * tilt.way;
    return {at[0], at[1], at[2]};
  }
};

/// Minimum-image differences. The difference is reduced, never the positions, so it is exactly
/// antisymmetric. In open directions both factors are zero and nothing changes. In a tilted box,
/// too, two points closer than half the lengths of the box find each other.
class MinimumImage {
 public:
  explicit MinimumImage(const Box& box) {
    for (int d = 0; d < 3; ++d) {
      period_[d] = box.periodic[d] ? box.length(d) : 0.0;
      inverse_[d] = box.periodic[d] ? 1.0 / box.length(d) : 0.0;
      any_ = any_ || box.periodic[d];
    }
    tilted_ = static_cast<bool>(box.tilt);
    if (tilted_) slide_[box.tilt.place()] = box.tilt.way;
  }

  template <class V>
  Vec3<V> operator()(Vec3<V> d) const {
    if (!any_) return d;
    if (tilted_) {
      const V z = roundToNearest(V(d.z * inverse_[2]));
      d.x -= slide_[0] * roundToNearest(V(d.y * inverse_[1])) + slide_[1] * z;
      d.y -= slide_[2] * z;
    }
    d.x -= period_[0] * roundToNearest(V(d.x * inverse_[0]));
    d.y -= period_[1] * roundToNearest(V(d.y * inverse_[1]));
    d.z -= period_[2] * roundToNearest(V(d.z * inverse_[2]));
    return d;
  }

  /// How near the vector `d` between nearest images is to the next image: its largest component
  /// over half of the box, in periodic directions; 1 means that another image is as near.
  double shareOfHalf(const Vec3d& d) const {
    return 2.0 * std::max({std::abs(d.x) * inverse_[0], std::abs(d.y) * inverse_[1],
                           std::abs(d.z) * inverse_[2]});
  }

 private:
  double period_[3], inverse_[3];
  double slide_[3] = {};  ///< of images: along x across y, along x across z, along y across z
  bool any_ = false, tilted_ = false;
};

}  // namespace nanoweft
