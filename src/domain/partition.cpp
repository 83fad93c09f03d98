#include "nanoweft/domain/partition.hpp"

namespace nanoweft {

std::vector<int> RectilinearPartitioner::assign(const State& state, const CellGrid& grid,
                                                const std::vector<double>&, bool) {
  std::vector<int> destination(static_cast<std::size_t>(state.owned()));
  for (int i = 0; i < state.owned(); ++i)
    destination[static_cast<std::size_t>(i)] = grid.owner(grid.cellOf(state.pose + 8 * i));
  return destination;
}

}  // namespace nanoweft
