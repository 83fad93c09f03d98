/// Partitioners: they decide which rank owns which segment.
#pragma once

#include <vector>

#include "nanoweft/domain/cell_grid.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class Partitioner {
 public:
  virtual ~Partitioner() = default;
  /// The rank that shall own each owned segment. `work`: of each owned segment, in any unit;
  /// `again`: the shares have become unequal. Collective.
  virtual std::vector<int> assign(const State& state, const CellGrid& grid,
                                  const std::vector<double>& work, bool again) = 0;
};

/// Every segment belongs to the rank whose DMDA part holds its cell. The grid itself is cut anew
/// when the shares are unequal.
class RectilinearPartitioner final : public Partitioner {
 public:
  std::vector<int> assign(const State& state, const CellGrid& grid, const std::vector<double>&,
                          bool) override;
};

/// METIS divides the graph of chain pieces. A piece is a run of consecutive segments, weighted by
/// its work; edges join pieces that are bonded or close. Segments stay on their ranks until the
/// shares are unequal.
///
/// The graph of pieces is gathered on rank 0: about 300 bytes a piece in a dense fabric, so 1e8
/// segments in pieces of 32 need 1 GB there.
class MetisPartitioner final : public Partitioner {
 public:
  explicit MetisPartitioner(int piece) : piece_(piece) {}
  std::vector<int> assign(const State& state, const CellGrid& grid, const std::vector<double>& work,
                          bool again) override;

 private:
  int piece_;
  bool divided_ = false;
};

}  // namespace nanoweft
