/// Distributes the segments: cell grid, ownership, order in memory, ghosts.
#pragma once

#include <memory>

#include "nanoweft/domain/halo.hpp"
#include "nanoweft/domain/partition.hpp"

namespace nanoweft {

class Domain {
 public:
  /// `tolerance`: largest owned count over the mean before the grid is cut anew.
  Domain(State& state, std::unique_ptr<Partitioner> partitioner, double tolerance);

  /// Gives every segment to its rank, sorts the owned ones by cell and chain, and builds the halo.
  /// `range`: reach of the pair list, 0 without one; `cell`: smallest edge of a cell, at least the
  /// range. Bond partners are found however long the bond.
  void rebuild(State& state, double range, double cell);

  Halo& halo() { return halo_; }
  const CellGrid& grid() const { return *grid_; }
  /// Local index of a row, owned or ghost, or -1.
  int localIndex(std::int64_t row) const { return local_.at(row); }
  /// Largest number of owned segments over the mean.
  double imbalance() const { return imbalance_; }

 private:
  void layGrid(const State& state, double range);
  bool findPartners(const State& state);

  std::unique_ptr<Partitioner> partitioner_;
  double tolerance_, imbalance_ = 1.0;
  std::unique_ptr<CellGrid> grid_;
  IndexMap local_;
  Halo halo_;
};

/// Throws InputError when a periodic direction is thinner than two list ranges, where the minimum
/// image would not be unique.
void requireWideBox(const Box& box, double range, const char* length);

}  // namespace nanoweft
