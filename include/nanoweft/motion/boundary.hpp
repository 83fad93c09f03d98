/// Boundary conditions, which act on named groups of segments: prescribed motion, forces and
/// torques, and the ready-made pair of grips of the tension test.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/motion/tension.hpp"
#include "nanoweft/state/state.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// One boundary condition. Velocity, spin, force and torque grow linearly during `ramp`.
///
/// With a spin the group turns as a whole about an axis through its centre, which moves with
/// `velocity`.
struct Boundary {
  std::string name;
  int bit = 0;                                  ///< its members carry this bit of State::group
  std::optional<std::array<double, 6>> region;  ///< lower, upper corner; else the user's `bit`
  std::array<bool, 3> fix{};                    ///< components of the velocity that are prescribed
  bool fixRotation = false;
  Vec3d velocity, force, torque;  ///< force and torque are per segment
  std::optional<double> spin;     ///< angular velocity about `axis`
  Vec3d axis;                     ///< a unit vector
  std::optional<Vec3d> centre;    ///< at the start
  double ramp = 0;
  double start = 0;                      ///< time when it began
  std::optional<StrainProgram> program;  ///< of a grip: its rate is the factor, instead of the ramp

  double factor(double time) const {
    if (program) return program->rate(time);
    return ramp > 0 && time < start + ramp ? (time - start) / ramp : 1.0;
  }
  /// The factor for a step of 2h that begins at `time`, in which a held velocity does not change.
  double stepFactor(double time, double h) const {
    if (program && h > 0)
      return (program->strain(time + 2.0 * h) - program->strain(time)) / (2.0 * h);
    // The mean over the step, which is the middle's unless the ramp ends in it.
    const double left = start + ramp - time;
    if (ramp > 0 && h > 0 && left > 0 && left < 2.0 * h)
      return 1.0 - left * left / (4.0 * ramp * h);
    return factor(time + h);
  }
  /// Where the centre is; there must be one.
  Vec3d centreAt(double time) const;
  bool moves() const { return norm(velocity) > 0 || spin.value_or(0.0) != 0; }
  bool loads() const { return norm(force) > 0 || norm(torque) > 0; }
  bool constrains() const { return fix[0] || fix[1] || fix[2] || fixRotation; }
};

class Boundaries {
 public:
  /// `restDistance` of two fibres that touch: default of the sheet's thickness.
  Boundaries(Options& options, const UnitSystem& units, const Kinds& kinds, double restDistance);

  /// Finds the members of the groups and starts the clocks. `record`: of the file that the state
  /// comes from. A restart goes on as it says; a new stage goes on with its tension test alone.
  /// Throws InputError for a group without members, for a record without what a restart needs, and
  /// for options that contradict the test that goes on, and where two hold a segment in different
  /// ways.
  void attach(State& state, const RunRecord& record, bool restart);
  /// Writes down what `attach` needs; `time` is the present.
  void save(RunRecord& record, double time) const;

  bool any() const { return !boundaries_.empty(); }
  /// Has some load not grown to what it shall be?
  bool loadsGrow(double time) const {
    for (const Boundary& b : boundaries_)
      if (b.loads() && b.factor(time) < 1.0) return true;
    return false;
  }
  const std::vector<Boundary>& list() const { return boundaries_; }
  const std::optional<Tension>& tension() const { return tension_; }
  /// Does the tension test of an earlier stage go on?
  bool tensionGoesOn() const { return goesOn_; }
  /// Is the work of each to be booked (-group_monitor)?
  bool booksWork() const { return booksWork_; }
  /// Bits of the groups that something acts on.
  std::int32_t mask() const { return mask_; }
  /// Bits of the groups, grips included, that are held in component c: of the velocity for c < 3,
  /// else of the rotation. Loads do nothing there.
  std::int32_t holders(std::size_t c) const;
  /// Says for people which loads do nothing on some of their segments, as others hold those.
  /// Collective.
  std::vector<std::string> lostLoads(const State& state) const;

 private:
  void readNamed(Options& options, const UnitSystem& units);
  void readOneNamed(Options& options, const std::string& name);
  void giveBits();
  void attachNamed(State& state, const RunRecord& record, bool restart);
  void addGrips();
  void countMembers(const State& state);
  void refuseConflicts(const State& state) const;

  std::vector<Boundary> boundaries_;
  std::optional<Tension> tension_;
  bool goesOn_ = false, booksWork_ = false;
  std::int32_t mask_ = 0;
};

}  // namespace nanoweft
