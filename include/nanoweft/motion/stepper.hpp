/// The interface of steppers, the algorithms that take a run from one step to the next (velocity
/// Verlet, FIRE). A new one is one file and one line in stepper.cpp's table.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/motion/system.hpp"
#include "nanoweft/motion/thermostat.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// What the motion of a step did on this rank.
struct DriftReport {
  bool stale = false;      ///< a segment moved so far that a drawn pair may be missing
  bool staleSoon = false;  ///< one has, or will have after another step; where the lists foresee
  bool unstable = false;   ///< a segment moved too far in one step, or is not a number
};

class Stepper {
 public:
  virtual ~Stepper() = default;

  /// The present time step.
  virtual double dt() const = 0;
  /// The longest step that it will make.
  virtual double longest() const { return dt(); }

  /// First half of a step: moves all segments and advances State::time and step. The forces must
  /// be evaluated next, with ForceRequest::complete false.
  virtual DriftReport move(System& system) = 0;
  /// Second half of a step, with the forces at the new positions. `seen`: some observer looks at
  /// this step's end. If none does, the stepper may leave this half to the next `move`; until then
  /// velocities are half a step old and State::force lacks the pair forces.
  virtual void finish(System& system, bool seen) = 0;

  /// Does its step follow the stable limit? Only then `limit` may be called, after which no step is
  /// longer than `dt`.
  virtual bool adapts() const { return false; }
  virtual void limit(double /*dt*/) {}
  /// Steps may be as long as this from now on.
  virtual void setLongest(double /*dt*/) {}

  /// Writes down what a restart needs, and takes it up. Throws InputError for what is missing.
  virtual void save(RunRecord& /*record*/) const {}
  virtual void restore(const RunRecord& /*record*/) {}
};

/// What a stepper is made from.
struct StepperSettings {
  double dt;                  ///< the step, or the longest where it adapts
  double localDamping = 0.0;  ///< c of F -> F - c|F| sign(v)
  std::optional<Thermostat> thermostat{};
  std::optional<double> farthest{};  ///< that FIRE moves a point in a step
};

/// A value of -relax_method.
struct StepperKind {
  std::string name, title;  ///< as an option's value, and for people
  bool minimises;           ///< it seeks equilibrium with its own damping; its time is not physical
  std::unique_ptr<Stepper> (*make)(const Kinds& kinds, const StepperSettings& settings);
};

/// The first is the default.
const std::vector<StepperKind>& stepperKinds();

}  // namespace nanoweft
