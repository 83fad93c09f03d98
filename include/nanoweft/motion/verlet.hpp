/// Velocity Verlet with exact rotation, damping and constraints (model.md 5 and 6).
///
/// A step is: half kick, drift, [forces], half kick. Damping acts in each half kick on the force
/// and velocity of that moment, so a state is complete with positions and velocities.
///
/// Energy accounts are kept by half kick: with dv the change of the velocity and the mean velocity
/// in between, force times mean velocity times dt/2 is exactly the work that the kick does. So
/// kinetic + potential + damped + broken - external drifts with Verlet's own error alone.
#pragma once

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/boundary.hpp"

namespace nanoweft {

/// Energy taken out by damping and brought in by boundaries since the start, on this rank.
struct EnergyAccounts {
  ExactSum damped, external, broken;
};

/// What a drift noticed on this rank.
struct DriftReport {
  bool stale = false;     ///< a segment left its half of the skin
  bool unstable = false;  ///< a segment moved too far in one step, or is not a number
};

class Verlet {
 public:
  /// `localDamping`: c of F -> F - c|F| sign(v).
  Verlet(double dt, double localDamping) : dt_(dt), damping_(localDamping) {}

  double dt() const { return dt_; }

  /// The half kick that is owed, the first half kick, and the drift by dt, in one pass over memory.
  /// Advances State::time and step. Leaves State::force and torque zero.
  DriftReport kickAndDrift(State& state, ForceField& forces, const Boundaries& boundaries,
                           EnergyAccounts& accounts);
  /// Second half kick, with the forces at the new time, which it completes.
  void kick(State& state, ForceField& forces, const Boundaries& boundaries,
            EnergyAccounts& accounts) const;
  /// Leaves the second half kick to the next step, since nobody looks at this step's end. Until
  /// then forces lack the pairs and velocities are half a step old.
  void oweKick() { owed_ = true; }

 private:
  double dt_, damping_;
  bool owed_ = false;
};

}  // namespace nanoweft
