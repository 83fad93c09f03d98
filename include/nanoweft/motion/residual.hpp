/// The residual of a segment: the force and torque of bonds, pairs, friction and loads on it, less
/// components that a boundary holds. It is zero in equilibrium.
#pragma once

#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

struct Residual {
  double force[3], torque[3];
};

/// Adds the loads at State::time and sets the components that a boundary holds to zero.
void applyBoundaries(Residual& residual, const State& state, const Boundaries& boundaries, int i);

/// Residual of the owned segment i, with State::force, torque and viscous as they were last
/// evaluated.
inline Residual residualOf(const State& state, const Boundaries& boundaries, int i) {
  const double* f = state.force + 3 * i;
  const double* t = state.torque + 3 * i;
  Residual residual{{f[0], f[1], f[2]}, {t[0], t[1], t[2]}};
  if (const double* held = state.viscous ? state.viscous + 6 * i : nullptr)
    for (int c = 0; c < 3; ++c) residual.force[c] += held[c], residual.torque[c] += held[3 + c];
  if (state.group[i] & boundaries.mask()) applyBoundaries(residual, state, boundaries, i);
  return residual;
}

/// The largest force, or torque over segment length, on any segment. Collective.
double largestResidual(const State& state, const ForceField& forces, const Boundaries& boundaries);

}  // namespace nanoweft
