#include "nanoweft/force/overlap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/base/threads.hpp"

namespace nanoweft {

namespace {

/// Of equally deep pairs, that with the lowest rows.
bool deeper(const Overlap& a, const Overlap& b) {
  if (a.depth != b.depth) return a.depth > b.depth;
  return a.row[0] != b.row[0] ? a.row[0] < b.row[0] : a.row[1] < b.row[1];
}

}  // namespace

Overlap deepestOverlap(const State& state, const ForceField& forces, double beyond) {
  const Overlap none{-std::numeric_limits<double>::infinity(), {0, 0}, {0, 0}, {0, 0}};
  std::vector<Overlap> found(forces.shares().size(), none);
  auto look = [&](const PairForce& force, const PairRuns& list, Overlap& deepest) {
    const Both<double> half = force.pointSpan(), radius = force.radius();
    const double touch = radius.i + radius.j, thinner = std::min(radius.i, radius.j),
                 below = touch - beyond * thinner, reach = below + half.i + half.j;
    list.forEach([&](const ListPair& p) {
      const Vec3d d = forces.nearest()(state.position(p.j) - state.position(p.i));
      if (dot(d, d) >= reach * reach) return;
      const double distance =
          distanceOfPieces(d, axis1(state.orientation(p.i)), axis1(state.orientation(p.j)), half);
      if (!(distance < below)) return;
      const Overlap pair{(touch - distance) / thinner,
                         {state.row[p.i], state.row[p.j]},
                         {state.fibre[p.i], state.fibre[p.j]},
                         {state.chain[2 * p.i], state.chain[2 * p.j]}};
      if (deeper(pair, deepest)) deepest = pair;
    });
  };
  onShares(found.size(), [&](std::size_t t) {
    for (std::size_t c = 0; c < forces.pairs().classes().size(); ++c) {
      const auto& lists = forces.lists().pairs()[c].threads()[t];
      for (const PairRuns* list : lists.all())
        look(*forces.pairs().classes()[c].force, *list, found[t]);
    }
  });
  Overlap deepest = none;
  for (const Overlap& f : found)
    if (deeper(f, deepest)) deepest = f;
  if (state.ranks() == 1) return deepest;
  double most = deepest.depth;
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, state.comm());
  if (std::isinf(most)) return none;
  std::vector<Overlap> all(static_cast<std::size_t>(state.ranks()));
  MPI_Allgather(&deepest, sizeof deepest, MPI_BYTE, all.data(), sizeof deepest, MPI_BYTE,
                state.comm());
  return *std::ranges::min_element(all, deeper);
}

}  // namespace nanoweft
