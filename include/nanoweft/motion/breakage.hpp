/// What follows a broken bond, for the pair forces (model.md 7).
///
/// Neighbours along a fibre, closer than -pair_exclude places, do not interact: their distance is
/// the bonds' business and lies deep inside the repulsion. When a bond between them breaks they
/// must become an ordinary pair, yet switching the pair force on at once would add its energy out
/// of nothing (two ends 1.3 T apart repel with hundreds of eV). So each such pair starts to
/// interact when it first has been out of the force's reach, where its energy is zero: no energy
/// jumps in.
///
/// Two bit masks a segment hold this (State::gap); both ends of a pair keep their own copy and come
/// to the same bits from the same positions.
#pragma once

#include <vector>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// Longest -pair_exclude with breakage: a mask has 64 bits.
inline constexpr int mostExcludeWithBreakage = 64;
/// Pairs are checked every so many steps: a number that no schedule of rebuilds changes.
inline constexpr int gapCheckInterval = 10;

/// Tells all ranks which bonds have broken, and lets the pairs interact that a break separates.
class Breaks {
 public:
  /// `exclude`: closer neighbours along a fibre do not interact; 0 without pair forces.
  explicit Breaks(int exclude) : exclude_(exclude) {}

  /// To be called with the rows of the first segments of bonds that this rank has found broken.
  void note(const std::vector<std::int64_t>& rows) {
    rows_.insert(rows_.end(), rows.begin(), rows.end());
  }
  /// Has this rank noted some that the others do not know?
  bool waiting() const { return !rows_.empty(); }
  /// Tells all ranks of the noted bonds: marks the pairs that they separate (State::gap), and sets
  /// previousBroken. Collective.
  void spread(State& state);
  /// Lets the separated pairs interact that are out of reach now. Returns true when there were some
  /// on this rank; the lists must then be made anew before these pairs come into reach again.
  bool release(State& state, const ForceField& forces, const Domain& domain) const;

 private:
  int exclude_;
  std::vector<std::int64_t> rows_;
};

/// As Breaks::spread, for the broken bonds of a state that has just been read. Collective.
void spreadOldBreaks(State& state, int exclude);

}  // namespace nanoweft
