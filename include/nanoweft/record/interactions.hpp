/// Visits the interacting pairs one by one, for observers that look at them now and then (stress,
/// fields of the segments). Only right after an evaluation of the forces, while lists and ghosts
/// are up to date.
#pragma once

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// x_j - x_i by the minimum image.
inline Vec3d separationOf(const State& state, const ForceField& forces, int i, int j) {
  return forces.nearest()(state.position(j) - state.position(i));
}

/// What a pair force does in a pair at the separation d.
inline PairAction resolved(const State& state, const PairForce& force, const ListPair& p,
                           const Vec3d& d) {
  return force.resolve(d, state.orientation(p.i), state.orientation(p.j),
                       {state.freeEnds(p.i), state.freeEnds(p.j)});
}

/// Calls visit(pair force, pair, x_j - x_i) for the pairs in reach that a thread lists. A pair of
/// two threads' or ranks' segments is listed, and visited, by both.
template <class Visit>
void forEachPair(const State& state, const ForceField& forces, std::size_t thread,
                 const Visit& visit) {
  for (std::size_t c = 0; c < forces.pairs().classes().size(); ++c) {
    const PairForce& force = *forces.pairs().classes()[c].force;
    const double reach2 = force.reach() * force.reach();
    const auto& lists = forces.lists().pairs()[c].threads()[thread];
    for (const PairRuns* list : lists.all())
      list->forEach([&](const ListPair& p) {
        if (const Vec3d d = separationOf(state, forces, p.i, p.j); dot(d, d) < reach2)
          visit(force, p, d);
      });
  }
}

}  // namespace nanoweft
