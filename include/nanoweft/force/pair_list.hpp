/// The list of segment pairs within reach plus a skin, and the threads' shares of it.
///
/// A list costs more than several steps, so it has a wide skin; from it, at little cost, a shorter
/// one with a thinner skin is drawn now and then, and that is what most steps go through.
///
/// Each thread owns a run of segments and sums all forces on them: a pair between two threads (or
/// with a ghost) stands in both lists and is resolved twice, so nobody writes to another's segment.
#pragma once

#include <vector>

#include "nanoweft/domain/cell_grid.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// A thread's run of owned segments.
struct Share {
  std::int32_t begin = 0, end = 0;
};

/// Cuts the owned segments into one run a thread, with about equal numbers of neighbours.
std::vector<Share> shareSegments(const State& state, const CellGrid& grid, const CellIndex& cells,
                                 int threads);

class PairList {
 public:
  /// Lists all pairs whose centres are within `range`, but for neighbours along a fibre closer than
  /// `exclude` places that have never been apart (State::gap).
  void build(const State& state, const CellGrid& grid, const CellIndex& cells,
             const std::vector<Share>& shares, double range, int exclude);

  /// A thread's pairs without ghosts, then those with.
  template <class Pairs>
  struct Parts {
    Pairs inner, outer;
  };
  const std::vector<Parts<PairRuns>>& threads() const { return threads_; }
  /// Those of them that a step has to look at.
  std::vector<Parts<DrawnPairs>>& drawn() { return drawn_; }
  std::int64_t size() const;
  /// Adds to each owned segment half of a pair for each that it is in, as it would be if all
  /// segments were owned.
  void count(std::vector<double>& pairs) const;

 private:
  std::vector<Parts<PairRuns>> threads_;
  std::vector<Parts<DrawnPairs>> drawn_;
  std::vector<Share> shares_;
};

/// Places from segment i on to segment j of the same fibre the shorter way (negative: back), or
/// nothing when they belong to different fibres. Around a closed fibre the shorter way counts.
inline bool sameFibre(const State& s, int i, int j) {
  return s.row[i] - s.chain[2 * i] == s.row[j] - s.chain[2 * j];
}
inline int placesOn(const State& s, int i, int j) {
  int places = s.chain[2 * j] - s.chain[2 * i];
  if (s.bond[i] & fibreClosed) {
    const int length = s.chain[2 * i + 1];
    if (2 * places > length) places -= length;
    if (2 * places < -length) places += length;
  }
  return places;
}

}  // namespace nanoweft
