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

namespace nanoweft {

/// What a bond sees of its segments i and j.
template <class V>
struct BondGeometry {
  Vec3<V> separation;  ///< x_j - x_i by the minimum image
  Quat<V> qi, qj;
};

/// The four parts of a bond's energy, each zero at rest.
template <class V>
struct BondEnergy {
  V stretch{}, shear{}, bending{}, torsion{};

  V total() const { return stretch + shear + bending + torsion; }
};

template <class V>
struct BondForce {
  Vec3<V> force;             ///< on i; on j it is the negative
  Vec3<V> torqueI, torqueJ;  ///< about the segments' centres, space axes
  V length{};                ///< r
};

/// The law: its rest length and stiffnesses in internal units, and what they do. `C` is double, or
/// a SIMD vector where each lane's bond has its own.
template <class C>
struct EvmBondOf {
  C length{};   ///< T: rest length
  C stretch{};  ///< B1 = E S/T                   (eV/A^2)
  C shear{};    ///< B2 = 12 E J/T                (eV)
  C bending{};  ///< B3 = -2 E J/T - G Jp/(2T)    (eV)
  C torsion{};  ///< B4 = G Jp/T                  (eV)

  template <class V>
  NW_INLINE BondForce<V> force(const BondGeometry<V>& bond) const {
    const auto& [separation, qi, qj] = bond;
    BondForce<V> result;
    const V r = norm(separation);
    const V inverse = 1.0 / r;
    const Vec3<V> d = inverse * separation;
    const Vec3<V> ni1 = axis1(qi), nj1 = -axis1(qj);
    const Vec3<V> w = nj1 - ni1;
    const V stretching = stretch * (r - length);
    const V shearing = (0.5 * shear) * inverse;
    const V along = dot(w, d);
    result.force = stretching * d + shearing * (w - along * d);
    // B2/2 n x d of both ends, and the couple that bends and twists them against each other.
    const V half = 0.5 * shear;
    const V bend = bending;
    const V twisting = 0.5 * torsion;
    const Vec3<V> couple = twisting * (cross(axis2(qi), axis2(qj)) + cross(axis3(qi), axis3(qj))) -
                           bend * cross(ni1, nj1);
    result.torqueI = half * cross(ni1, d) + couple;
    result.torqueJ = -(half * cross(nj1, d)) - couple;
    result.length = r;
    return result;
  }

  template <class V>
  NW_INLINE BondEnergy<V> energy(const BondGeometry<V>& bond) const {
    const auto& [separation, qi, qj] = bond;
    const V r = norm(separation);
    const V longer = r - length;
    const Vec3<V> d = (1.0 / r) * separation;
    const Vec3<V> ei = axis1(qi), ej = axis1(qj);
    const Vec3<V> slant = (ei - d) + (ej - d);
    const Vec3<V> d1 = ei - ej, d2 = axis2(qi) - axis2(qj), d3 = axis3(qi) - axis3(qj);
    BondEnergy<V> parts;
    parts.stretch = (0.5 * stretch) * longer * longer;
    parts.shear = (0.125 * shear) * dot(slant, slant);
    parts.bending = (0.5 * (0.25 * shear + bending + 0.5 * torsion)) * dot(d1, d1);
    parts.torsion = (0.25 * torsion) * (dot(d2, d2) + dot(d3, d3) - dot(d1, d1));
    return parts;
  }
};
using EvmBond = EvmBondOf<double>;

}  // namespace nanoweft
