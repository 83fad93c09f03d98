/// The periodic box as a testing machine (model.md 21): each periodic direction is held, strained
/// at a rate or by a program, or driven by a servo to a stress. The segments' centres go with the
/// box, their velocities against it (v -> v/lambda), so that its work is the stress times the
/// change of strain.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/strain_program.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

class BoxDrive {
 public:
  /// Reads -deform_... .
  BoxDrive(Options& options, const UnitSystem& units);

  explicit operator bool() const { return active_; }
  /// What happens to it, for people.
  std::string text() const;
  /// Steps from one measurement of the stress to the next.
  long interval() const { return interval_; }

  /// Throws InputError for directions that are not periodic.
  void attach(const Box& box, const RunRecord& record, bool restart);
  void save(RunRecord& record) const;

  /// Strains the box by what belongs to a step of `dt` that begins at `time`, and takes the
  /// segments along. Books the work in `external` on rank 0.
  void strain(State& state, ForceField& forces, double time, double dt, ExactSum& external);
  /// Takes note of the stress (xx, yy, zz, GPa), which sets the rates of driven directions.
  void note(const State& state, const ForceField& forces, const std::array<double, 6>& stress,
            ExactSum& external);

  /// Strain of each direction since the start.
  std::array<double, 3> strains(const Box& box) const;
  /// Volume to which the stress refers.
  double volume(const Box& box) const;

 private:
  enum Mode { held, rate, program, stress };
  struct Axis {
    Mode mode = held;
    double rate = 0;    ///< of the engineering strain
    double target = 0;  ///< stress, GPa
    double until = 0;   ///< strain at which it stops; 0: it does not
    std::optional<StrainProgram> legs;

    void read(Options& options, const UnitSystem& units, const std::string& name);
    /// The box's length after a step; `grown`: how far the ramp is.
    double nextLength(double length, double start, double time, double dt, double grown) const;
  };

  double unit_;  ///< GPa in internal units
  const char* time_;
  bool active_ = false;
  std::array<Axis, 3> axes_;
  long interval_ = 20;
  double ramp_ = 0, thickness_ = 0, modulus_ = 0, relaxes_ = 0, most_ = 0;
  std::array<double, 3> start_{};   ///< lengths of the box at the start
  std::array<double, 3> stress_{};  ///< when last measured, GPa
  std::array<double, 3> since_{};   ///< logarithmic strain since then
};

}  // namespace nanoweft
