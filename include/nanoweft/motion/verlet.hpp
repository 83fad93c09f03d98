/// Velocity Verlet with exact rotation, damping, constraints and a thermostat (model.md 5, 6, 17).
///
/// A step is: half kick, drift, [forces], half kick. Damping acts in each half kick on the force
/// and velocity of that moment, so positions and velocities are all that a restart needs.
///
/// A held segment has the prescribed velocity at the end of a step and, for the drift, the one that
/// takes it there: on a circle about the axis of a spin, the chord of the step.
///
/// Each half kick books its work: the force times the mean of the velocities before and after the
/// kick times dt/2 is exactly the kinetic energy that it adds. So kinetic + potential + damped +
/// broken - external drifts with Verlet's own error alone.
///
/// A thermostat acts before the first half kick and after the second one (OBABO) and books its
/// heat.
#pragma once

#include <optional>

#include "nanoweft/motion/stepper.hpp"

namespace nanoweft {

class Verlet : public Stepper {
 public:
  /// `localDamping`: c of F -> F - c|F| sign(v).
  Verlet(double dt, double localDamping, std::optional<Thermostat> thermostat = std::nullopt)
      : dt_(dt), damping_(localDamping), thermostat_(thermostat) {}

  double dt() const override { return dt_; }
  void setStep(double dt) { dt_ = dt; }

  /// First makes the second half kick of the last step, if `finish` has left it: both half kicks
  /// and the drift then take one pass through memory.
  DriftReport move(System& system) override;
  void finish(System& system, bool seen) override;

 private:
  double dt_, damping_;
  std::optional<Thermostat> thermostat_;
  bool owed_ = false;  ///< the second half kick of the last step has not been made
};

}  // namespace nanoweft
