#include "nanoweft/force/pair_survey.hpp"

#include <limits>
#include <vector>

#include "nanoweft/base/gather.hpp"

namespace nanoweft {

ClosestPair findClosestPair(const State& state, const ForceField& forces,
                            const std::function<double(const PairForce&)>& least) {
  ClosestPair closest{std::numeric_limits<double>::infinity(), 1, 0, {0, 0}, {0, 0}};
  double smallest = closest.distance;
  for (std::size_t c = 0; c < forces.pairs().classes().size(); ++c) {
    const PairForce& force = *forces.pairs().classes()[c].force;
    const Both<double> half = force.pointSpan();
    const double unit = least(force), span = half.i + half.j;
    if (!(unit > 0)) continue;
    for (const auto& thread : forces.lists().pairs()[c].threads())
      for (const PairRuns* list : thread.all())
        list->forEach([&](const ListPair& p) {
          const Vec3d separation = forces.nearest()(state.position(p.j) - state.position(p.i));
          // No points of the pair are closer than this.
          if (norm(separation) - span >= smallest * unit) return;
          const double distance =
              force.closest(separation, state.orientation(p.i), state.orientation(p.j));
          if (distance >= smallest * unit) return;
          smallest = distance / unit;
          closest = {distance,
                     unit,
                     force.closestSensible(),
                     {state.fibre[p.i], state.fibre[p.j]},
                     {state.chain[2 * p.i], state.chain[2 * p.j]}};
        });
  }
  largestOfRanks(-smallest, closest, state.comm());
  return closest;
}

StrongestSum findStrongestSum(const State& state, const ForceField& forces) {
  std::vector<Vec3d> sums(static_cast<std::size_t>(state.owned()));
  for (std::size_t c = 0; c < forces.pairs().classes().size(); ++c) {
    const PairForce& force = *forces.pairs().classes()[c].force;
    const Both<double> half = force.pointSpan();
    const double deep = force.closestSensible() + half.i + half.j;
    for (std::size_t t = 0; t < forces.shares().size(); ++t)
      for (const PairRuns* list : forces.lists().pairs()[c].threads()[t].all())
        list->forEach([&](const ListPair& p) {
          const Vec3d separation = forces.nearest()(state.position(p.j) - state.position(p.i));
          if (norm(separation) >= deep) return;
          const Vec3d f = force
                              .resolve(separation, state.orientation(p.i), state.orientation(p.j),
                                       {state.freeEnds(p.i), state.freeEnds(p.j)})
                              .force;
          // A pair of two threads' segments stands in both threads' lists.
          const Share share = forces.shares()[t];
          if (share.holds(p.i)) sums[static_cast<std::size_t>(p.i)] += f;
          if (share.holds(p.j)) sums[static_cast<std::size_t>(p.j)] += -f;
        });
  }
  StrongestSum strongest{0, 0, 0};
  const double most = forces.pairs().forceUnit() * 0x1p62;
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (const double share = norm(sums[i]) / most; share > strongest.share)
      strongest = {share, state.fibre[i], state.chain[2 * i]};
  largestOfRanks(strongest.share, strongest, state.comm());
  return strongest;
}

}  // namespace nanoweft
