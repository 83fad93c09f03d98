/// Hertzian repulsion without adhesion: u(r) = K (2 rf - r)^(5/2) where fibres overlap, else zero
/// (physics.md 4.2; Hertz's contact of spheres, with K = (4/15) E* sqrt(R/2) for spheres of radius
/// R).
#pragma once

#include <cmath>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/force/pair_table.hpp"

namespace nanoweft {

class Hertz {
 public:
  using Kernel = Hertz;
  static constexpr bool couples = false;  ///< distances near zero would be less exact

  Hertz(double stiffness, double radius) : stiffness_(stiffness), contact_(2.0 * radius) {}

  double cutoff() const { return contact_; }
  double closestSensible() const { return 0.0; }
  double largestForce() const { return 2.5 * stiffness_ * contact_ * std::sqrt(contact_); }
  double contactStiffness() const { return 3.75 * stiffness_ * std::sqrt(contact_); }

  template <class V>
  NW_INLINE V slope(const V& r2) const {
    return (*this)(r2).slope;
  }
  template <class V>
  NW_INLINE PairValue<V> operator()(const V& r2) const {
    using std::sqrt;
    const V r = sqrt(r2);
    const V overlap = select(r < V(contact_), V(contact_ - r), V(0.0));
    const V root = sqrt(overlap);
    const V du = (-2.5 * stiffness_) * overlap * root;
    const V floor = V(1e-12 * contact_);
    return {stiffness_ * overlap * overlap * root, du / select(r > floor, r, floor)};
  }

 private:
  double stiffness_, contact_;
};

}  // namespace nanoweft
