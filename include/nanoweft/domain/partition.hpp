/// Who owns which segment. A partitioner is one object with one method.
#pragma once

#include <vector>

#include "nanoweft/domain/cell_grid.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class Partitioner {
 public:
  virtual ~Partitioner() = default;
  /// The rank that shall own each owned segment. Collective.
  virtual std::vector<int> assign(const State& state, const CellGrid& grid) const = 0;
};

/// Every segment belongs to the rank whose DMDA part holds its cell.
class RectilinearPartitioner final : public Partitioner {
 public:
  std::vector<int> assign(const State& state, const CellGrid& grid) const override {
    std::vector<int> destination(static_cast<std::size_t>(state.owned()));
    for (int i = 0; i < state.owned(); ++i)
      destination[static_cast<std::size_t>(i)] = grid.owner(grid.cellOf(state.pose + 8 * i));
    return destination;
  }
};

}  // namespace nanoweft
