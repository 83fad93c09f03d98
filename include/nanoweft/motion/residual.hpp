/// The residual of a segment: the force and torque of bonds, pairs and loads on it, less components
/// that a boundary holds. It is zero in equilibrium.
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

/// Residual of the owned segment i, with State::force and torque as they were last evaluated.
inline Residual residualOf(const State& state, const Boundaries& boundaries, int i) {
  const double* f = state.force + 3 * i;
  const double* t = state.torque + 3 * i;
  Residual residual{{f[0], f[1], f[2]}, {t[0], t[1], t[2]}};
  if (state.group[i] & boundaries.mask()) applyBoundaries(residual, state, boundaries, i);
  return residual;
}

/// The largest force, or torque over segment length, on any segment. Collective.
double largestResidual(const State& state, const ForceField& forces, const Boundaries& boundaries);

}  // namespace nanoweft
