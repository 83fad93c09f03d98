#include "nanoweft/domain/domain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/domain/link_moves.hpp"

namespace nanoweft {

Domain::Domain(State& state, const PartitionSettings& settings)
    : settings_(settings),
      partitioner_(std::make_unique<RectilinearPartitioner>()),
      halo_(state.comm()) {
  if (settings.kind == PartitionSettings::metis && state.ranks() > 1) {
    partitioner_ = std::make_unique<MetisPartitioner>(settings.piece);
    metis_ = true;
  }
}

bool Domain::turnToMetis(const State& state) {
  // METIS takes over only when straight cuts made from measured work are unequal.
  if (settings_.kind != PartitionSettings::automatic || metis_ || failed_ || !fresh_) return false;
  // With few pieces for each rank METIS cuts badly; that pays only against very unequal shares.
  const std::int64_t piecesPerRank = imbalance_ > 1.3 ? 10 : 50;
  if (state.total() < piecesPerRank * settings_.piece * state.ranks()) return false;
  partitioner_ = std::make_unique<MetisPartitioner>(settings_.piece);
  straight_ = most_;
  onTrial_ = true;
  return metis_ = true;
}

void Domain::judgeMetis() {
  // Equal shares with long borders may be more work than unequal ones with short borders, since
  // ghosts cost something.
  if (std::exchange(onTrial_, false) && most_ >= straight_) failed_ = true;
}

void Domain::rebuild(State& state, double range, double cell, const std::vector<double>* known) {
  std::vector<double> work =
      known ? *known : std::vector<double>(static_cast<std::size_t>(state.owned()), 1.0);
  bool anew = false;
  if (revoked()) {
    partitioner_ = std::make_unique<RectilinearPartitioner>();
    metis_ = false;
    anew = true;
  } else if (state.ranks() > 1 && unequal())
    // Shares made from measured work are made anew only when the imbalance has grown since; until
    // then new cuts would be as unequal.
    anew = turnToMetis(state) || !fresh_ || imbalance_ > reached_ + 0.02;
  if (anew) fresh_ = known != nullptr, reached_ = 0;
  for (double reach = cell;; reach *= 1.5) {
    state.dropGhosts();
    layGrid(state, reach, work, anew && !metis_);
    if (state.ranks() > 1) {
      const std::vector<int> destination = partitioner_->assign(state, *grid_, work, anew);
      if (state.linked) moveLinks(state, destination);
      state.migrate(destination);
    }
    anew = false;
    state.permute(CellIndex(state, *grid_, state.owned()).order);
    halo_.build(state, *grid_, range);
    // A bond may be longer than the pair range; then the halo is built again on larger cells.
    int missing = !findPartners(state);
    MPI_Allreduce(MPI_IN_PLACE, &missing, 1, MPI_INT, MPI_MAX, state.comm());
    if (!missing) break;
    if (reach > 1e6 * cell)
      throw RunError("a segment's neighbour along its fibre cannot be found in the box");
    work.assign(static_cast<std::size_t>(state.owned()), 1.0);
  }
}

void Domain::noteWork(const State& state, double own, double resolved) {
  double most[2] = {own, resolved}, all = own;
  MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, state.comm());
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_DOUBLE, MPI_SUM, state.comm());
  imbalance_ = all > 0 ? most[0] * state.ranks() / all : 1.0;
  if (reached_ == 0) reached_ = imbalance_;
  most_ = most[1];
  judgeMetis();
}

void Domain::layGrid(const State& state, double range, const std::vector<double>& work, bool anew) {
  // Lower corner and negated upper corner, so that one reduction (minimum) serves for both.
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
  if (grid_ && grid_->range() == range && !anew && grid_->covers(lower, upper, state.box.tilt))
    return;
  grid_ = std::make_unique<CellGrid>(state, lower, upper, range, work);
  petsc(DMSwarmSetCellDM(state.swarm(), grid_->dm()));
}

bool Domain::findPartners(const State& state) {
  const auto rows = std::minmax_element(state.row, state.row + state.local());
  if (state.local() > 0)
    local_ = IndexMap(static_cast<std::size_t>(state.local()), *rows.first, *rows.second);
  else
    local_ = IndexMap();
  for (int i = 0; i < state.local(); ++i) local_.insert(state.row[i], i);
  for (int i = 0; i < state.owned(); ++i)
    for (const Tie& tie : state.ties(i))
      if (state.holds(i, tie) && partner(state, i, tie) < 0) return false;
  for (const Link& link : state.links)
    for (const std::int64_t row : link.row)
      if (!link.broken && local_.at(row) < 0) return false;
  return true;
}

Domain::Census Domain::census(const State& state) const {
  std::int64_t counts[2] = {state.ghosts(), 0};
  for (int i = 0; i < state.owned(); ++i)
    for (const Tie& tie : state.ties(i))
      counts[1] += tie.first && partner(state, i, tie) >= state.owned();
  MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPI_INT64_T, MPI_SUM, state.comm());
  return {counts[0], counts[1]};
}

void requireWideBox(const Box& box, double least, const char* what, const char* length) {
  for (int d = 0; d < 3; ++d)
    if (box.periodic[d] && !(box.length(d) >= least))
      throw InputError(format("the periodic box is too thin along %c: %g %s, but %s are %g %s",
                              "xyz"[d], box.length(d), length, what, least, length));
}

void requireNear(const State& state, double most, const char* length) {
  double farthest = 0;
  for (int i = 0; i < state.owned(); ++i)
    for (int c = 0; c < 3; ++c) farthest = std::max(farthest, std::abs(state.pose[8 * i + c]));
  MPI_Allreduce(MPI_IN_PLACE, &farthest, 1, MPI_DOUBLE, MPI_MAX, state.comm());
  if (farthest > most)
    throw InputError(format(
        "fibres reach to %g %s from the origin along an axis: coordinates that large have too "
        "few digits for the bonds; bring them nearer, to %g %s at most",
        farthest, length, most, length));
}

}  // namespace nanoweft
