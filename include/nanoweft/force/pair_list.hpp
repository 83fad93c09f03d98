/// The pair list (Verlet list): all pairs of segments within reach plus a skin, a list for each
/// thread.
///
/// A list costs as much as several steps, so its skin is wide and it serves for long. Steps do not
/// go through the list itself, but through the pairs drawn from it with a thinner skin
/// (pair_draw.hpp).
///
/// Each thread owns a range of segments and alone sums the forces on them. A pair of two threads'
/// segments therefore stands in both threads' lists and is resolved twice. So is a pair of two
/// ranks' segments, with a ghost on either rank.
#pragma once

#include <vector>

#include "nanoweft/domain/cell_grid.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// The owned segments of one thread: begin <= i < end.
struct Share {
  std::int32_t begin = 0, end = 0;
};

/// Cuts the owned segments into one range a thread, with about equal numbers of neighbours.
std::vector<Share> shareSegments(const State& state, const CellGrid& grid, const CellIndex& cells,
                                 int threads);

/// Segments of one kind by their cells.
struct KindCells {
  const CellLattice& lattice;
  const CellIndex& cells;
};

class PairList {
 public:
  /// Lists all pairs whose centres are within `range`. Left out are pairs of one fibre less than
  /// `exclude` places apart, unless they have been apart since a bond between them broke
  /// (State::gap).
  void build(const State& state, const KindCells& where, const std::vector<Share>& shares,
             double range, int exclude);
  /// Lists all pairs of a segment of `firsts`, which comes first in the pair, with one of another
  /// kind whose centres are within `range`, the range of the others' lattice.
  void buildMixed(const State& state, const std::vector<int>& firsts, const KindCells& others,
                  const std::vector<Share>& shares, double range);

  /// A thread's pairs in two parts: inner pairs without a ghost, outer pairs with one.
  template <class Pairs>
  struct Parts {
    Pairs inner, outer;
  };
  const std::vector<Parts<PairRuns>>& threads() const { return threads_; }
  /// The pairs that steps resolve, drawn from `threads`.
  std::vector<Parts<DrawnPairs>>& drawn() { return drawn_; }
  std::int64_t size() const;
  /// Adds half of `weight` to work[i] for each listed pair that the owned segment i is in.
  void count(double weight, std::vector<double>& work) const;

 private:
  void start(const std::vector<Share>& shares);

  std::vector<Parts<PairRuns>> threads_;
  std::vector<Parts<DrawnPairs>> drawn_;
  std::vector<Share> shares_;
};

inline bool sameFibre(const State& s, int i, int j) {
  return s.row[i] - s.chain[2 * i] == s.row[j] - s.chain[2 * j];
}
/// Places from segment i to segment j of the same fibre along its chain, negative backwards; in a
/// closed fibre by the shorter way.
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
