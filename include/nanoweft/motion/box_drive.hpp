/// The periodic box as a testing machine (model.md 21): each periodic direction is held, strained
/// at a rate or by a program, or driven by a servo to a stress. So is one shear: the images across
/// one axis slide along another. The segments' centres go with the box, their velocities against it
/// (v -> v/lambda, v_x -> v_x - gamma v_y), so that its work is the stress times the change of
/// strain. In a step centres go before the segments drift and velocities go after it, which equals
/// half of both before and half after, so it is of second order.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/box_servo.hpp"
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
  /// segments' centres along. Books the work in `external` on rank 0.
  void strain(State& state, ForceField& forces, double time, double dt, ExactSum& external);
  /// Takes the velocities along, once the segments have drifted.
  void strainVelocities(State& state) const;
  /// Takes note of the stress (that of `boxStress`), which sets the rates of driven directions.
  /// `dt`: of the steps.
  void note(const State& state, const ForceField& forces, const std::array<double, 9>& stress,
            double dt, ExactSum& external);

  /// Strain of each direction since the start.
  std::array<double, 3> strains(const Box& box) const;
  /// "xy", "xz" or "yz" when the images across the second axis slide along the first; else null.
  const char* shears() const;
  /// Size of the work that the box has done so far, whichever way: what is booked of it is as
  /// right as the stress is smooth from measurement to measurement.
  double turnedOver() const { return turnedOver_; }
  /// Are segments carried along this axis, as the box is strained along it or slides along it?
  bool carries(int axis) const;
  /// Strain of shear since the start.
  double shear() const { return shear_ - shearStart_; }
  /// Is a direction on its way still, to the strain where it stops or to its stress? Free ones are
  /// where they shall be.
  bool underWay(const Box& box, double time) const;
  /// The name of a direction that is strained at a rate for ever; null: there is none.
  const char* endless() const;
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
    BoxServo servo;

    /// `least`: smallest strain.
    void read(Options& options, const UnitSystem& units, const std::string& name, double least);
    /// The box's length after a step; `grown`: how far the ramp is.
    double nextLength(double length, double start, double time, double dt, double grown) const;
    /// The strain of shear after a step.
    double nextShear(double strain, double time, double dt, double grown) const;
    std::string text(const char* time) const;
    /// Has it yet to come to its strain, at the present `strain`?
    bool strains(double strain, double time) const;
  };

  void attachShear(const Box& box, const RunRecord& record, bool restart);
  bool servoed() const;
  void attachServos(const RunRecord& record);
  void saveServos(RunRecord& record) const;
  /// Volume when the stress was last measured.
  double measuredVolume(const Box& box) const;
  /// Strain along the three axes, and by shear; both return the work.
  double stretch(State& state, ForceField& forces, double time, double dt, double grown);
  double slide(State& state, ForceField& forces, double time, double dt, double grown);

  double unit_;  ///< GPa in internal units
  const char* time_;
  bool active_ = false;
  static constexpr std::size_t none = 6;
  std::array<Axis, 6> axes_;    ///< x, y, z, xy, xz, yz
  std::size_t sheared_ = none;  ///< place of the one shear that is not held
  long interval_ = 20;
  double ramp_ = 0, thickness_ = 0;
  BoxServo::Law servo_;
  std::array<double, 3> start_{};            ///< lengths of the box at the start
  std::array<double, 3> stress_{};           ///< when last measured, GPa
  std::array<double, 3> since_{};            ///< logarithmic strain since then
  double shear_ = 0, shearStart_ = 0;        ///< slide over the length across, of a straight box 0
  double shearStress_ = 0, shearSince_ = 0;  ///< as stress_ and since_
  std::array<double, 3> factor_{1, 1, 1};    ///< by which this step stretches the box
  double slid_ = 0;                          ///< shear of this step
  double turnedOver_ = 0;
};

}  // namespace nanoweft
