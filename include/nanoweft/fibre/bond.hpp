/// The enhanced-vector-model (EVM) bond between a segment i and its successor j (model.md 3;
/// Kuzkin and Krivtsov; eq. (2) of the paper with the sign of its last term corrected).
///
/// With d = (x_j - x_i)/r and frames n_i1 = e1_i, n_j1 = -e1_j, n_k2 = e2_k, n_k3 = e3_k:
///
///     U = B1/2 (r-T)^2 + B2/2 (n_j1 - n_i1).d + B3 n_i1.n_j1 - B4/2 (n_i2.n_j2 + n_i3.n_j3)
///         + (B2 + B3 + B4)
///
/// The parts are written as sums of squares of small differences, equal to model.md's forms, so
/// that they keep their relative precision near rest:
///
///     shear   = B2/8 |e1_i + e1_j - 2d|^2
///     bending = (B2/4 + B3 + B4/2) |e1_i - e1_j|^2 / 2
///     torsion = B4/4 (|e2_i - e2_j|^2 + |e3_i - e3_j|^2 - |e1_i - e1_j|^2)
#pragma once

#include "nanoweft/base/vec.hpp"
#include "nanoweft/fibre/material.hpp"

namespace nanoweft {

template <class V>
struct BondEnergy {
  V stretch{}, shear{}, bending{}, torsion{};
};

template <class V>
struct BondForce {
  Vec3<V> force;             ///< on i; on j it is the negative
  Vec3<V> torqueI, torqueJ;  ///< about the segments' centres, space axes
  V length{};                ///< r
};

/// Force and torques of a bond; `separation` is x_j - x_i by the minimum image.
template <class V>
NW_INLINE BondForce<V> bondForce(const BondParameters& b, const Vec3<V>& separation,
                                 const Quat<V>& qi, const Quat<V>& qj) {
  BondForce<V> result;
  const V r = norm(separation);
  const V inverse = 1.0 / r;
  const Vec3<V> d = inverse * separation;
  const Vec3<V> ni1 = axis1(qi), nj1 = -axis1(qj);
  const Vec3<V> w = nj1 - ni1;
  const V stretching = b.stretch * (r - b.length);
  const V shearing = (0.5 * b.shear) * inverse;
  const V along = dot(w, d);
  result.force = stretching * d + shearing * (w - along * d);
  // B2/2 n x d of both ends, and the couple that bends and twists them against each other.
  const V half = 0.5 * b.shear;
  const V bending = b.bending;
  const V twisting = 0.5 * b.torsion;
  const Vec3<V> couple = twisting * (cross(axis2(qi), axis2(qj)) + cross(axis3(qi), axis3(qj))) -
                         bending * cross(ni1, nj1);
  result.torqueI = half * cross(ni1, d) + couple;
  result.torqueJ = -(half * cross(nj1, d)) - couple;
  result.length = r;
  return result;
}

/// The four parts of a bond's energy, each zero at rest.
template <class V>
NW_INLINE BondEnergy<V> bondEnergy(const BondParameters& b, const Vec3<V>& separation,
                                   const Quat<V>& qi, const Quat<V>& qj) {
  const V r = norm(separation);
  const V stretch = r - b.length;
  const Vec3<V> d = (1.0 / r) * separation;
  const Vec3<V> ei = axis1(qi), ej = axis1(qj);
  const Vec3<V> slant = (ei - d) + (ej - d);
  const Vec3<V> d1 = ei - ej, d2 = axis2(qi) - axis2(qj), d3 = axis3(qi) - axis3(qj);
  BondEnergy<V> energy;
  energy.stretch = (0.5 * b.stretch) * stretch * stretch;
  energy.shear = (0.125 * b.shear) * dot(slant, slant);
  energy.bending = (0.5 * (0.25 * b.shear + b.bending + 0.5 * b.torsion)) * dot(d1, d1);
  energy.torsion = (0.25 * b.torsion) * (dot(d2, d2) + dot(d3, d3) - dot(d1, d1));
  return energy;
}

}  // namespace nanoweft
