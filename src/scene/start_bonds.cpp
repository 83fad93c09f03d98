#include "nanoweft/scene/start_bonds.hpp"

#include <algorithm>
#include <vector>

namespace nanoweft {

StartBonds::StartBonds(const State& state) : state_(state) {
  // Each rank's first segment and the last one that begins a fibre, either with a mark in front.
  std::array<double, 18> mine{};
  if (state.owned() > 0) {
    mine[0] = 1;
    std::copy_n(state.pose, 8, &mine[1]);
  }
  for (int i = state.owned() - 1; i >= 0; --i)
    if (state.chain[2 * i] == 0) {
      mine[9] = 1;
      std::copy_n(state.pose + 8 * i, 8, &mine[10]);
      break;
    }
  std::vector<std::array<double, 18>> all(static_cast<std::size_t>(state.ranks()));
  MPI_Allgather(mine.data(), 18, MPI_DOUBLE, all.data(), 18, MPI_DOUBLE, state.comm());
  for (std::size_t r = 0; r < static_cast<std::size_t>(state.rank()); ++r)
    if (all[r][9] > 0) std::copy_n(&all[r][10], 8, start_.begin());
  for (std::size_t r = all.size(); r-- > static_cast<std::size_t>(state.rank()) + 1;)
    if (all[r][0] > 0) std::copy_n(&all[r][1], 8, after_.begin());
}

}  // namespace nanoweft
