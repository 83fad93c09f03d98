/// The van der Waals pair law: adhesion as a function of the gap between surfaces, with a linear
/// repulsion at contact (model.md 4.1; Table 2 and eq. (5) of the paper, which leaves open where
/// the two are spliced):
///
///     v(r) = 4 eps (A / D^alpha - B / D^beta),  D = (r - 2 rf)/lambda
///     u(r) = v(r)                                          r >  rs
///     u(r) = v(rs) + v'(rs) (r - rs) + k (r - rs)^2        r <= rs
///
/// `smooth`: rs is where v'' = 2k, so the stiffness is continuous too; `kink`: rs is the minimum of
/// v. A C2 switch takes the energy to zero between -pair_switch and -pair_cutoff. u is the energy
/// of two segments of length 2 lambda; VdwParameters::of converts it to segments of any length.
#pragma once

#include <cmath>

#include "nanoweft/base/both.hpp"
#include "nanoweft/force/pair_table.hpp"
#include "nanoweft/force/switch.hpp"

namespace nanoweft {

struct VdwParameters {
  double epsilon = 0.07124;  ///< eV
  double a = 0.0223, b = 1.31;
  double alpha = 9.5, beta = 4.0;
  double stiffness = 200.0;                   ///< k, eV/A^2
  double length = 6.78;                       ///< lambda, A
  double radius = 6.78;                       ///< rf, A; the mean of two kinds'
  double switchFrom = 40.68, cutoff = 54.24;  ///< A
  bool smooth = true;                         ///< else the kink splice

  /// The parameters for two segments of such lengths; `factor` multiplies the energy.
  VdwParameters of(Both<double> segments, double factor = 1.0) const {
    VdwParameters p = *this;
    const double lengths = (segments.i / (2.0 * length)) * (segments.j / (2.0 * length));
    p.epsilon *= factor * lengths;
    p.stiffness *= factor * lengths;
    return p;
  }
};

/// Factor of the energy per length squared for unequal radii (model.md 9): bodies much larger than
/// their gap attract like sqrt(ra rb) when crossed, like sqrt(ra rb/(ra + rb)) when parallel.
inline double unequalRadii(double ra, double rb) {
  return ra == rb ? 1.0 : 2.0 * std::sqrt(ra * rb) / (ra + rb);
}

class Vdw {
 public:
  explicit Vdw(const VdwParameters& p)
      : p_(p), switch_{p.switchFrom, p.cutoff}, contact_(2.0 * p.radius / p.length) {
    splice_ = restDistance();
    if (p.smooth) {
      // v'' falls from infinity to zero at the inflection, beyond the minimum: bisect for 2k.
      double low = (contact_ + 1e-3 * distance(splice_)) * p.length;
      double high =
          (contact_ + std::pow(p.alpha * (p.alpha + 1) * p.a / (p.beta * (p.beta + 1) * p.b),
                               1.0 / (p.alpha - p.beta))) *
          p.length;
      for (int k = 0; k < 200 && low < high; ++k) {
        const double middle = 0.5 * (low + high);
        (curvature(middle) > 2.0 * p.stiffness ? low : high) = middle;
      }
      splice_ = 0.5 * (low + high);
    }
    spliceEnergy_ = attraction(splice_);
    spliceSlope_ = p.smooth ? attractionSlope(splice_) : 0.0;
  }

  double cutoff() const { return p_.cutoff; }
  /// Where the potential without its switch is lowest.
  double restDistance() const {
    return (contact_ + std::pow(p_.alpha * p_.a / (p_.beta * p_.b), 1.0 / (p_.alpha - p_.beta))) *
           p_.length;
  }
  double spliceDistance() const { return splice_; }
  /// The least k of the smooth splice: with a softer one the repulsion would begin beyond the
  /// minimum of v, and replace it.
  double leastStiffness() const { return 0.5 * curvature(restDistance()); }
  /// Below this distance the walls of two fibres interpenetrate (D <= 0).
  double closestSensible() const { return 2.0 * p_.radius; }
  /// Bound of |u'|.
  double largestForce() const { return std::abs(spliceSlope_) + 2.0 * p_.stiffness * splice_; }
  /// Bound of u'' in repulsive contact.
  double contactStiffness() const { return 2.0 * p_.stiffness; }

  PairValue<double> operator()(double r2) const {
    const double r = std::sqrt(r2);
    double u, du;
    if (r > splice_) {
      u = attraction(r);
      du = attractionSlope(r);
      switch_.apply(r, u, du);
    } else {
      const double s = r - splice_;
      u = spliceEnergy_ + s * (spliceSlope_ + p_.stiffness * s);
      du = spliceSlope_ + 2.0 * p_.stiffness * s;
    }
    return {u, du / r};
  }

  /// The law as the kernels use it.
  PairTable table() const {
    return PairTable({splice_, p_.switchFrom, p_.cutoff},
                     [this](double r) { return (*this)(r * r).slope; });
  }

 private:
  double distance(double r) const { return r / p_.length - contact_; }
  double attraction(double r) const {
    const double d = distance(r);
    return 4.0 * p_.epsilon * (p_.a * std::pow(d, -p_.alpha) - p_.b * std::pow(d, -p_.beta));
  }
  double attractionSlope(double r) const {
    const double d = distance(r);
    return 4.0 * p_.epsilon / (p_.length * d) *
           (p_.beta * p_.b * std::pow(d, -p_.beta) - p_.alpha * p_.a * std::pow(d, -p_.alpha));
  }
  double curvature(double r) const {
    const double d = distance(r), al = p_.alpha, be = p_.beta, width = p_.length * d;
    return 4.0 * p_.epsilon / (width * width) *
           (al * (al + 1) * p_.a * std::pow(d, -al) - be * (be + 1) * p_.b * std::pow(d, -be));
  }

  VdwParameters p_;
  Switch switch_;
  double contact_;  ///< 2 rf in units of lambda
  double splice_ = 0, spliceEnergy_ = 0, spliceSlope_ = 0;
};

}  // namespace nanoweft
