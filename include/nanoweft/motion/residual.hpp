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
  Residual residual;
  for (int c = 0; c < 3; ++c) {
    residual.force[c] = state.force[3 * i + c] + state.viscousOn(i, c);
    residual.torque[c] = state.torque[3 * i + c] + state.viscousOn(i, 3 + c);
  }
  if (state.group[i] & boundaries.mask()) applyBoundaries(residual, state, boundaries, i);
  return residual;
}

/// Does a load grow still, or a wall move that will stop? Then no state is the last one.
bool stillDriven(const State& state, const ForceField& forces, const Boundaries& boundaries);

/// The largest force, or torque over segment length, on any segment. Collective.
double largestResidual(const State& state, const ForceField& forces, const Boundaries& boundaries);

}  // namespace nanoweft
