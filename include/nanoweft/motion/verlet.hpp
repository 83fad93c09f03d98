/// Velocity Verlet with exact rotation, damping and constraints (model.md 5 and 6).
///
/// A step is: half kick, drift, [forces], half kick. Damping acts in each half kick on the force
/// and velocity of that moment, so a state is complete with positions and velocities.
///
/// Energy accounts are kept by half kick: with dv the change of the velocity and the mean velocity
/// in between, force times mean velocity times dt/2 is exactly the work that the kick does. So
/// kinetic + potential + damped + broken - external drifts with Verlet's own error alone.
#pragma once

#include "nanoweft/motion/stepper.hpp"

namespace nanoweft {

class Verlet : public Stepper {
 public:
  /// `localDamping`: c of F -> F - c|F| sign(v).
  Verlet(double dt, double localDamping) : dt_(dt), damping_(localDamping) {}

  double dt() const override { return dt_; }
  void setStep(double dt) { dt_ = dt; }

  /// Both half kicks around a step's end and the drift go through memory once, as far as nobody
  /// looks in between.
  DriftReport move(System& system) override;
  void finish(System& system, bool seen) override;

 private:
  double dt_, damping_;
  bool owed_ = false;  ///< the second half kick of the last step has not been made
};

}  // namespace nanoweft
