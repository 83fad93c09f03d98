#include "nanoweft/domain/domain.hpp"

#include <limits>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

Domain::Domain(State& state, std::unique_ptr<Partitioner> partitioner, double tolerance)
    : partitioner_(std::move(partitioner)), tolerance_(tolerance), halo_(state.comm()) {}

void Domain::rebuild(State& state, double range, double cell) {
  for (double reach = cell;; reach *= 1.5) {
    state.dropGhosts();
    layGrid(state, reach);
    if (state.ranks() > 1) state.migrate(partitioner_->assign(state, *grid_));
    state.permute(CellIndex(state, *grid_, state.owned()).order);
    halo_.build(state, *grid_, range);
    // A bond may be longer than the pair range; then look further.
    int missing = !findPartners(state);
    MPI_Allreduce(MPI_IN_PLACE, &missing, 1, MPI_INT, MPI_MAX, state.comm());
    if (!missing) break;
    if (reach > 1e6 * cell)
      throw RunError("a segment's neighbour along its fibre cannot be found in the box");
  }
  std::int64_t most = state.owned();
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT64_T, MPI_MAX, state.comm());
  imbalance_ = static_cast<double>(most) * state.ranks() / static_cast<double>(state.total());
}

void Domain::layGrid(const State& state, double range) {
  // lower corner, negated upper corner: one reduction.
  std::array<double, 6> extent;
  extent.fill(std::numeric_limits<double>::infinity());
  for (int i = 0; i < state.owned(); ++i)
    for (int d = 0; d < 3; ++d) {
      extent[d] = std::min(extent[d], state.pose[8 * i + d]);
      extent[3 + d] = std::min(extent[3 + d], -state.pose[8 * i + d]);
    }
  MPI_Allreduce(MPI_IN_PLACE, extent.data(), 6, MPI_DOUBLE, MPI_MIN, state.comm());
  std::array<double, 3> lower, upper;
  for (int d = 0; d < 3; ++d) {
    lower[d] = state.box.periodic[d] ? state.box.lower[d] : extent[d];
    upper[d] = state.box.periodic[d] ? state.box.upper[d] : -extent[3 + d];
  }
  const bool balanced = imbalance_ <= tolerance_ || state.ranks() == 1;
  if (grid_ && grid_->range() == range && balanced && grid_->covers(lower, upper)) return;
  grid_ = std::make_unique<CellGrid>(state, lower, upper, range);
  petsc(DMSwarmSetCellDM(state.swarm(), grid_->dm()));
}

bool Domain::findPartners(const State& state) {
  local_ = IndexMap(static_cast<std::size_t>(state.local()));
  for (int i = 0; i < state.local(); ++i) local_.insert(state.row[i], i);
  for (int i = 0; i < state.owned(); ++i) {
    const auto next = state.successor(i), previous = state.predecessor(i);
    if ((next >= 0 && local_.at(next) < 0) || (previous >= 0 && local_.at(previous) < 0))
      return false;
  }
  return true;
}

void requireWideBox(const Box& box, double range, const char* length) {
  for (int d = 0; d < 3; ++d)
    if (box.periodic[d] && !(box.length(d) >= 2.0 * range))
      throw InputError(
          format("the periodic box is too thin along %c: %g %s, but two list ranges (cutoff + "
                 "segment + skin) are %g %s",
                 "xyz"[d], box.length(d), length, 2.0 * range, length));
}

}  // namespace nanoweft
