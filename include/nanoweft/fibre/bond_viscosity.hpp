/// Internal viscosity of a fibre (model.md 13): each stiffness of a bond has a dashpot beside it,
/// as in a Kelvin-Voigt solid, with c = stiffness times retardation time.
///
/// With r the length and d the direction of the bond, v = v_j - v_i, w = w_j - w_i the difference
/// and m = (w_i + w_j)/2 the mean of the angular velocities, e the mean of both first axes, the
/// rates of strain are
///
///     stretching  v.d
///     shearing    g = m x d - (v - (v.d) d)/r
///     twisting    w.e
///     bending     w - (w.e) e
///
/// all zero in rigid motion. The forces are minus the derivatives of half the sum of c times the
/// squares of these rates. They take energy out at twice that, and they have no net force or
/// moment.
#pragma once

#include "nanoweft/fibre/bond.hpp"

namespace nanoweft {

/// Velocities and angular velocities of two segments i and j, space axes.
struct TwoVelocities {
  Vec3d vi, vj, wi, wj;
};

struct BondViscosity {
  double stretch = 0;  ///< B1 times its retardation time, and so on
  double shear = 0, bending = 0, torsion = 0;

  explicit operator bool() const { return stretch > 0 || shear > 0 || bending > 0 || torsion > 0; }

  BondForce<double> force(const BondGeometry<double>& bond, const TwoVelocities& u) const {
    const double r = norm(bond.separation), inverse = 1.0 / r;
    const Vec3d d = inverse * bond.separation, v = u.vj - u.vi;
    const double longer = dot(v, d);
    const Vec3d slip = cross(0.5 * (u.wi + u.wj), d) - inverse * (v - longer * d);
    const Vec3d sum = axis1(bond.qi) + axis1(bond.qj), e = (1.0 / norm(sum)) * sum;
    const Vec3d w = u.wj - u.wi;
    const double twist = dot(w, e);
    const Vec3d couple = (torsion * twist) * e + bending * (w - twist * e);
    const Vec3d half = (0.5 * shear) * cross(d, slip);
    return {(stretch * longer) * d - (shear * inverse) * slip, couple - half, -couple - half, r};
  }
};

}  // namespace nanoweft
