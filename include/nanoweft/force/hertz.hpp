/// The Hertz pair law (model.md 4.2, 9), repulsion without adhesion: u(r) = K (2 rf - r)^(5/2)
/// where fibres overlap, else zero. u is the energy of two segments of length 2 rf, w = u/(2 rf)^2
/// per length squared.
///
/// Two fibres crossed at a right angle with an overlap d repel each other by the force
/// 2 pi r w(r) = pi K d^(5/2)/rf (d << rf). Hertz's theory gives (4/3) E* sqrt(rf) d^(3/2) for
/// bodies of that shape, 1/E* = 2 (1 - nu^2)/E with the modulus E across the axis.
/// `hertzStiffness` makes both equal at an overlap of rf/10, the deepest that a fibre should see;
/// shallower contacts are softer than Hertz's.
#pragma once

#include <cmath>
#include <numbers>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/force/pair_table.hpp"

namespace nanoweft {

/// Overlap over rf for which -hertz_stiffness follows from the modulus.
inline constexpr double hertzOverlap = 0.1;

/// What a contact sees of one fibre: radius, and modulus and Poisson's ratio across the axis.
struct ContactSide {
  double radius, young, poisson;

  double compliance() const { return (1.0 - poisson * poisson) / young; }
};

/// K of two fibres. Of unequal ones, w = u/(4 ra rb), Hertz's force is that of R = sqrt(ra rb), and
/// the overlap is a tenth of the smaller radius.
inline double hertzStiffness(const ContactSide& a, const ContactSide& b) {
  // Written so that equal fibres get the plain formula's bits.
  const bool equal = a.compliance() == b.compliance();
  const double reduced = equal ? a.young / (2.0 * (1.0 - a.poisson * a.poisson))
                               : 1.0 / (a.compliance() + b.compliance());
  const double mean = a.radius == b.radius ? a.radius : std::sqrt(a.radius * b.radius),
               thinner = a.radius < b.radius ? a.radius : b.radius;
  const double unequal = 2.0 * a.radius * b.radius / ((a.radius + b.radius) * thinner);
  return 4.0 / (3.0 * std::numbers::pi) * reduced * std::sqrt(mean) * unequal / hertzOverlap;
}

class Hertz {
 public:
  using Kernel = Hertz;
  static constexpr bool couples = false;  ///< coupled points would round distances near zero more

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
