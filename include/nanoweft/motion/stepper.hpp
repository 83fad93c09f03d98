/// How a run goes from one step to the next. A stepper is one file and one line in stepper.cpp's
/// table.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nanoweft/motion/system.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// What the motion of a step did on this rank.
struct DriftReport {
  bool stale = false;     ///< a segment left its half of the skin
  bool unstable = false;  ///< a segment moved too far in one step, or is not a number
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
  /// Second half, with the forces at the new places. Unless the step's end is `seen`, it may be
  /// left to the next `move`: until then velocities are half a step old and forces lack the pairs.
  virtual void finish(System& system, bool seen) = 0;

  /// Does its step follow the stable limit? Only then `limit` may be called: no step will be
  /// longer than this from now on.
  virtual bool adapts() const { return false; }
  virtual void limit(double /*dt*/) {}
  /// Steps may be as long as this from now on.
  virtual void setLongest(double /*dt*/) {}

  /// Writes down what a restart needs, and takes it up. Throws InputError for what is missing.
  virtual void save(RunRecord& /*record*/) const {}
  virtual void restore(const RunRecord& /*record*/) {}
};

/// A value of -relax_method.
struct StepperKind {
  std::string name, title;  ///< as an option's value, and for people
  bool minimises;  ///< it looks for rest: it brings its own damping, and its time is not physical
  /// `dt`: the step, or the longest where it adapts; `localDamping`: c of F -> F - c|F| sign(v).
  std::unique_ptr<Stepper> (*make)(const Fibre& fibre, double dt, double localDamping);
};

/// The first is the default.
const std::vector<StepperKind>& stepperKinds();

}  // namespace nanoweft
