/// Van der Waals adhesion between fibres with a linear repulsion at contact (physics.md 4.1; Table
/// 2 and eq. (5) of the paper, with the splice settled):
///
///     v(r) = 4 eps (A / D^alpha - B / D^beta),  D = r/rf - 2
///     u(r) = v(r)                                          r >  rs
///     u(r) = v(rs) + v'(rs) (r - rs) + k (r - rs)^2        r <= rs
///
/// `smooth`: rs is where v'' = 2k, so the stiffness is continuous too; `kink`: rs is the minimum of
/// v. A C2 switch takes the energy to zero between -pair_switch and -pair_cutoff.
#pragma once

#include <cmath>
#include <limits>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/force/switch.hpp"

namespace nanoweft {

/// Energy of a point pair and u'(r)/r, from which the force follows.
template <class V>
struct PairValue {
  V energy, slope;
};

/// D^-9.5 and D^-4 by multiplications and one square root: the paper's exponents.
struct PaperExponents {
  double alpha = 9.5, beta = 4.0;
  template <class V>
  NW_INLINE void powers(const V& d, const V& inverse, V& a, V& b) const {
    using std::sqrt;
    const V i2 = inverse * inverse;
    b = i2 * i2;
    a = b * b * i2 * sqrt(d);  // the root does not have to wait for the division
  }
};

/// Any exponents, by pow.
struct GeneralExponents {
  double alpha = 9.5, beta = 4.0;
  void powers(double, double inverse, double& a, double& b) const {
    a = std::pow(inverse, alpha);
    b = std::pow(inverse, beta);
  }
  template <class V>
  NW_INLINE void powers(const V&, const V& inverse, V& a, V& b) const {
    for (std::size_t k = 0; k < V::size(); ++k) {
      a[k] = std::pow(static_cast<double>(inverse[k]), alpha);
      b[k] = std::pow(static_cast<double>(inverse[k]), beta);
    }
  }
};

struct VdwParameters {
  double epsilon = 0.07124;  ///< eV
  double a = 0.0223, b = 1.31;
  double alpha = 9.5, beta = 4.0;
  double stiffness = 200.0;                   ///< k, eV/A^2
  double radius = 6.78;                       ///< rf, A
  double switchFrom = 40.68, cutoff = 54.24;  ///< A
  bool smooth = true;                         ///< else the kink splice
};

template <class Exponents>
class Vdw {
 public:
  explicit Vdw(const VdwParameters& p)
      : exponents_{p.alpha, p.beta},
        inverseRadius_(1.0 / p.radius),
        scale_(4.0 * p.epsilon),
        a_(p.a),
        b_(p.b),
        stiffness_(p.stiffness),
        cutoff_{p.switchFrom, p.cutoff} {
    spliceD_ = minimumD();
    if (p.smooth) {
      // v'' falls from infinity to zero at the inflection, beyond the minimum: bisect for 2k.
      double low = 1e-3 * spliceD_;
      double high = std::pow(p.alpha * (p.alpha + 1) * p.a / (p.beta * (p.beta + 1) * p.b),
                             1.0 / (p.alpha - p.beta));
      for (int k = 0; k < 200 && low < high; ++k) {
        const double middle = 0.5 * (low + high);
        (curvature(middle) > 2.0 * p.stiffness ? low : high) = middle;
      }
      spliceD_ = 0.5 * (low + high);
    }
    splice_ = (spliceD_ + 2.0) * p.radius;
    double u, du;
    raw(spliceD_, 1.0 / spliceD_, u, du);
    spliceEnergy_ = u;
    spliceSlope_ = p.smooth ? du : 0.0;
  }

  double cutoff() const { return cutoff_.to; }
  /// Where the potential without its switch is lowest.
  double restDistance() const { return (minimumD() + 2.0) / inverseRadius_; }
  double spliceDistance() const { return splice_; }
  /// Below this distance the walls of two fibres interpenetrate (D <= 0).
  double closestSensible() const { return 2.0 / inverseRadius_; }
  /// Bound of |u'|.
  double largestForce() const { return std::abs(spliceSlope_) + 2.0 * stiffness_ * splice_; }
  /// Bound of u'' in repulsive contact.
  double contactStiffness() const { return 2.0 * stiffness_; }

  template <class V>
  NW_INLINE PairValue<V> operator()(const V& r2) const {
    using std::sqrt;
    const V r = sqrt(r2);
    // Lanes below the splice take the linear branch; D is held there to stay finite.
    V d = r * inverseRadius_ - 2.0;
    const auto contact = !(r > V(splice_));
    d = select(contact, V(spliceD_), d);
    // At zero distance the direction is undefined and the force, slope times distance, vanishes.
    const V floor = V(1e-12 * splice_);
    const V length = select(r > floor, r, floor);
    const V both = 1.0 / (d * length);  // one division for 1/d and 1/r
    V u, du;
    raw(d, V(both * length), u, du);
    if (anyOf(contact)) {
      const V s = r - splice_;
      u = select(contact, V(spliceEnergy_ + s * (spliceSlope_ + stiffness_ * s)), u);
      du = select(contact, V(spliceSlope_ + (2.0 * stiffness_) * s), du);
    }
    cutoff_.apply(r, u, du);
    return {u, du * (both * d)};
  }

 private:
  /// v and v' from D and 1/D.
  template <class V>
  NW_INLINE void raw(const V& d, const V& inverse, V& u, V& du) const {
    V pa, pb;
    exponents_.powers(d, inverse, pa, pb);
    u = scale_ * (a_ * pa - b_ * pb);
    du = (scale_ * inverseRadius_) * inverse *
         ((exponents_.beta * b_) * pb - (exponents_.alpha * a_) * pa);
  }
  double minimumD() const {
    return std::pow(exponents_.alpha * a_ / (exponents_.beta * b_),
                    1.0 / (exponents_.alpha - exponents_.beta));
  }
  double curvature(double d) const {
    const double al = exponents_.alpha, be = exponents_.beta;
    return scale_ * inverseRadius_ * inverseRadius_ *
           (al * (al + 1) * a_ * std::pow(d, -al - 2) - be * (be + 1) * b_ * std::pow(d, -be - 2));
  }

  Exponents exponents_;
  double inverseRadius_, scale_, a_, b_, stiffness_;
  Switch cutoff_;
  double spliceD_ = 0, splice_ = 0, spliceEnergy_ = 0, spliceSlope_ = 0;
};

}  // namespace nanoweft
