/// The pair list (Verlet list): all pairs of segments within reach plus a skin, a list for each
/// thread.
///
/// A list costs as much as several steps, so its skin is wide and it serves for long. Steps do not
/// go through the list itself, but through the pairs drawn from it with a thinner skin
/// (pair_draw.hpp).
///
/// Each thread owns a range of segments, and lists all pairs with one of them. A pair of two
/// threads' or two ranks' segments therefore stands in two lists. One of the two threads resolves
/// it for both (of one rank: shared_pairs.hpp; of two: Halo::addGhostsBegin), or each for its own
/// segment.
#pragma once

#include <array>
#include <vector>

#include "nanoweft/domain/cell_grid.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/shared_pairs.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

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
  /// `sharing`: may a pair of two threads' or ranks' segments be resolved by one of them for both?
  explicit PairList(bool sharing) : sharing_(sharing) {}
  /// Are pairs of two ranks' segments resolved by one of them for both? The same on all ranks.
  bool ranksShare() const { return ranksShare_; }

  /// Lists all pairs whose centres are within `range`. Left out are pairs of one fibre less than
  /// `exclude` places apart, unless they have been apart since a bond between them broke
  /// (State::gap).
  void build(const State& state, const KindCells& where, const std::vector<Share>& shares,
             double range, int exclude);
  /// Lists all pairs of a segment of `firsts`, which comes first in the pair, with one of another
  /// kind whose centres are within `range`, the range of the others' lattice.
  void buildMixed(const State& state, const std::vector<int>& firsts, const KindCells& others,
                  const std::vector<Share>& shares, double range);

  /// A thread's pairs. With sharing, those with another thread's segment, across, stand apart from
  /// the inner ones. Pairs with a ghost are left or taken: if ranks share, the ghost's rank
  /// resolves those that are left; else all are taken.
  struct Parts {
    PairRuns inner, across, left, taken;

    std::array<const PairRuns*, 4> all() const { return {&inner, &across, &left, &taken}; }
  };
  const std::vector<Parts>& threads() const { return threads_; }
  /// The pairs that steps resolve, drawn from `threads`.
  struct Drawn {
    DrawnPairs inner, taken;
    SharedPairs shared;  ///< of those across
  };
  std::vector<Drawn>& drawn() { return drawn_; }
  /// How many pairs are resolved, if all are near enough.
  std::int64_t size() const;
  /// Adds half of `weight` to work[i] for each listed pair that the owned segment i is in.
  void count(double weight, std::vector<double>& work) const;

 private:
  struct Found;
  void start(const State& state, const std::vector<Share>& shares);
  /// Keeps what a thread has found.
  void keep(const Found& found, const State& state, std::size_t thread);

  bool sharing_, ranksShare_ = false;
  std::vector<Parts> threads_;
  std::vector<Drawn> drawn_;
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
