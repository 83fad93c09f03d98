/// Distributes the segments at every rebuild: lays the cell grid, gives each segment to a rank,
/// sorts a rank's segments in memory, and gets the ghosts.
#pragma once

#include <memory>

#include "nanoweft/domain/halo.hpp"
#include "nanoweft/domain/partition.hpp"

namespace nanoweft {

/// How segments are shared among ranks.
struct PartitionSettings {
  enum Kind { rectilinear, metis, automatic } kind = automatic;
  double tolerance =
      1.05;        ///< shares are made anew when a rank's work exceeds the mean by this factor
  int piece = 32;  ///< segments in a piece of fibre that METIS keeps together
};

class Domain {
 public:
  Domain(State& state, const PartitionSettings& settings);

  /// Gives every segment to its rank, sorts the owned ones by cell and chain, and builds the halo.
  /// `range`: reach of the pair list, 0 without one; `cell`: smallest edge of a cell, at least the
  /// range; `known`: the work of each owned segment, null before it has been measured (on all ranks
  /// alike). Bond partners are found however long the bond, unless it is broken.
  void rebuild(State& state, double range, double cell, const std::vector<double>* known);

  /// Takes note of the work of this rank after a rebuild: `own` that of its share, `resolved` all
  /// that it does, with the pairs that another rank resolves too. Collective.
  void noteWork(const State& state, double own, double resolved);

  Halo& halo() { return halo_; }
  const CellGrid& grid() const { return *grid_; }
  /// Local index of a row, owned or ghost, or -1.
  int localIndex(std::int64_t row) const { return local_.at(row); }
  /// Local index of the other segment of a tie of segment i, which mostly lies next to i in memory.
  int partner(const State& state, int i, const Tie& tie) const {
    const int guess = tie.first ? i + 1 : i - 1;
    return guess >= 0 && guess < state.local() && state.row[guess] == tie.row ? guess
                                                                              : local_.at(tie.row);
  }
  /// Largest work of a rank over the mean.
  double imbalance() const { return imbalance_; }
  bool unequal() const { return imbalance_ > settings_.tolerance; }
  /// Did METIS make more work for the busiest rank than straight cuts, to which the next rebuild
  /// returns?
  bool revoked() const { return failed_ && metis_; }
  /// Ghosts of all ranks, and bonds between segments of two ranks. Collective.
  struct Census {
    std::int64_t ghosts, cutBonds;
  };
  Census census(const State& state) const;
  /// "rectilinear" or "metis".
  const char* partition() const { return metis_ ? "metis" : "rectilinear"; }

 private:
  bool turnToMetis(const State& state);
  void judgeMetis();
  void layGrid(const State& state, double range, const std::vector<double>& work, bool anew);
  bool findPartners(const State& state);

  PartitionSettings settings_;
  std::unique_ptr<Partitioner> partitioner_;
  bool metis_ = false, fresh_ = false;     ///< fresh: the shares were made from measured work
  bool onTrial_ = false, failed_ = false;  ///< METIS, where it is one of two choices
  double most_ = 0, straight_ = 0;  ///< most that a rank does now, and did with straight cuts
  double imbalance_ = 1.0, reached_ = 1.0;  ///< reached: imbalance when the shares were new
  std::unique_ptr<CellGrid> grid_;
  IndexMap local_;
  Halo halo_;
};

/// Throws InputError when a periodic direction is thinner than `least`, where the minimum image
/// would not be unique: less than twice what reaches farthest. `what` names that in the message,
/// `length` its unit.
void requireWideBox(const Box& box, double least, const char* what, const char* length);
/// Throws InputError where a segment has a coordinate beyond `most`. Collective.
void requireNear(const State& state, double most, const char* length);

}  // namespace nanoweft
