/// The tension test (model.md 8 and 16): two grips that move apart, or together, along an axis.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/motion/strain_program.hpp"
#include "nanoweft/state/state.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// Bits of State::group that mark the segments held by the grips of a tension test.
inline constexpr int leftGripBit = 28, rightGripBit = 29;

struct Tension {
  int axis = 0;
  double rate = 0, ramp = 0;  ///< the rate's sign says which way; not used with a program
  std::optional<StrainProgram> program;
  double grip = 0;
  std::optional<std::array<double, 2>> ends;  ///< of the piece; empty: its outermost segments
  double maxStrain = 0;                       ///< where the test ends; not used with a program
  double width = 0;                           ///< of the fabric at the start; 0: measured
  double thickness = 0;                       ///< for the stress; 0: not known
  double gage = 0;                            ///< distance between the grips at the start
  /// Distance of the innermost segments held in fibres that both grips hold, of the kind where it
  /// is largest; 0: not measured.
  double between = 0;
  double start = 0;       ///< time of the start of this stage
  double before = 0;      ///< strain at that time, reached in earlier stages
  bool fresh = false;     ///< a test of its own, whatever the state has gone through
  bool lateral = false;   ///< the lateral strain is wanted
  const char* unit = "";  ///< of lengths, for messages
  double spread = 0;      ///< spreadAcross at the start, where that is wanted

  /// Direction of the width: y in a test along x, else x.
  int across() const { return axis == 0 ? 1 : 0; }
  /// Engineering strain at `time`: what was before, and the integral of the ramped velocity.
  double strain(double time) const;
  /// Has the test come to its end?
  bool over(double time) const;
  /// Time until then.
  double timeLeft(double time) const;
  /// The highest rate, with its sign, that the ramp leaves time for; without a program.
  double peakRate() const;
  /// Does it make the piece shorter than it was at the start of the test, and never longer?
  bool presses() const;

  /// What the options say; empty where they are not given.
  struct Asked {
    std::optional<int> axis;
    std::optional<double> grip, width, thickness;
    std::optional<std::array<double, 2>> ends;
  } asked;

  /// Throws InputError for a box that is periodic where the test needs ends.
  void requireEnds(const Box& box) const;
  /// A test of its own: measures the piece and marks what its grips hold. Throws InputError for a
  /// piece that cannot be gripped. Collective.
  void measure(State& state);
  /// Takes up the test of a checkpoint. Throws InputError when something is missing.
  void restore(const RunRecord& record);
  /// Takes up the test of an earlier stage, which `time` ends. Throws InputError for options that
  /// contradict it as well.
  void goOn(const RunRecord& record, double time);
  /// Writes down what `restore` and `goOn` need; `time` is the present.
  void save(RunRecord& record, double time) const;

 private:
  void takeUp(const RunRecord& record);
  void measureSpread(const State& state);
};

/// Root mean square distance, across the pull, of the segments that no grip holds from their mean.
/// Collective.
double spreadAcross(const State& state, const Tension& tension);

/// How many fibres have a segment in the left grip alone, in the right one alone, in both.
struct HeldFibres {
  std::int64_t left = 0, right = 0, both = 0;
};
/// Collective; known to rank 0.
HeldFibres heldFibres(const State& state);

/// Empty when the options ask for none. `restDistance` of two fibres of the first kind that touch:
/// default of the sheet's thickness, which several kinds do not have.
std::optional<Tension> readTension(Options& options, const UnitSystem& units, const Kinds& kinds,
                                   double restDistance);

}  // namespace nanoweft
