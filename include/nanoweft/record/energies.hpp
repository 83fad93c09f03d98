/// The energies of a moment and the accounts of the run so far.
#pragma once

#include <vector>

#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/system.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

struct Energies {
  double stretch = 0, shear = 0, bending = 0, torsion = 0, pair = 0, kinetic = 0, rotational = 0;
  double walls = 0;                             ///< contacts with walls, and motion of driven walls
  double damped = 0, external = 0, broken = 0;  ///< accumulated since the start
  double friction = 0;                          ///< likewise; no part of `damped`
  double heat = 0;                              ///< likewise, brought in by a thermostat
  std::int64_t brokenBonds = 0;  ///< and links; their energies are among those of bonds, too

  double elastic() const { return stretch + shear + bending + torsion; }
  double total() const { return elastic() + pair + walls + kinetic + rotational; }
  /// Constant but for the integrator's own error.
  double balance() const { return total() + damped + friction + broken - external - heat; }
};

/// Sums over all ranks; `outcome` must come from an evaluation with energies. Collective.
Energies sumEnergies(const State& state, const ForceField& forces, const ForceOutcome& outcome,
                     const EnergyAccounts& accounts);

}  // namespace nanoweft
