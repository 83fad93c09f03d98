/// What bonds are at rest: their rest rotations (model.md 10) and rest lengths. A bond at rest
/// turns segment i by q0 into its successor j. Each end takes half of it: with h = q0^(1/2), the
/// bond's law sees the frames
///
///     Q_i = q_i h,   Q_j = q_j h^-1,
///
/// which are equal at rest, with the chord along their first axis. Both are fixed to the segments,
/// so forces and torques are those of the law.
#pragma once

#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// h of the bond from segment i to its successor.
inline Quatd restHalfOf(const State& state, const Kinds& kinds, int i) {
  if (const double* h = state.restHalf) return {h[4 * i], h[4 * i + 1], h[4 * i + 2], h[4 * i + 3]};
  return kinds.restHalf(state.kind(i));
}

/// Turns the frames of a bond into those that are equal at rest.
template <class V>
NW_INLINE void turnToRest(const Quat<V>& half, BondGeometry<V>& bond) {
  bond.qi = bond.qi * half;
  bond.qj = bond.qj * Quat<V>{half.w, -half.x, -half.y, -half.z};
}

/// Gives the bond from segment i to its successor a rest rotation; the state must have the fields.
inline void setRest(State& state, int i, const Vec3d& turn) {
  double* rest = state.rest + 3 * i;
  rest[0] = turn.x, rest[1] = turn.y, rest[2] = turn.z;
  const Quatd h = rotation(0.5 * turn);
  double* half = state.restHalf + 4 * i;
  half[0] = h.w, half[1] = h.x, half[2] = h.y, half[3] = h.z;
}

/// The law of the bond from segment i to its successor, with the rest length that it has come to.
inline EvmBond bondLaw(const State& s, const Kinds& kinds, int i) {
  EvmBond law = kinds[s.kind(i)].bond;
  if (s.extension) law.length += s.extension[i];
  return law;
}
/// Energy of the bond from segment i to its successor, for frames that are equal at rest.
inline BondEnergy<double> bondEnergy(const State& s, const Kinds& kinds, int i,
                                     const BondGeometry<double>& geometry) {
  auto energy = bondLaw(s, kinds, i).energy(geometry);
  if (const Fibre& fibre = kinds[s.kind(i)]; fibre.kinks()) fibre.kink.add(geometry, energy);
  return energy;
}

}  // namespace nanoweft
