#include "nanoweft/force/overlap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/base/threads.hpp"

namespace nanoweft {

double distanceOfPieces(const Vec3d& d, const Vec3d& a, const Vec3d& b, double half) {
  // s and t are places along the pieces. The least distance is where the two lines are closest, if
  // that is on both pieces, else at one of the four ends.
  const double ab = dot(a, b), da = dot(d, a), db = dot(d, b);
  auto held = [half](double x) { return std::clamp(x, -half, half); };
  auto squared = [&](double s, double t) {
    const Vec3d x = d + t * b - s * a;
    return dot(x, x);
  };
  double best = std::numeric_limits<double>::infinity();
  if (const double sine2 = 1.0 - ab * ab; sine2 > 1e-12) {
    const double s = (da - ab * db) / sine2, t = (ab * da - db) / sine2;
    if (std::abs(s) <= half && std::abs(t) <= half) best = squared(s, t);
  }
  for (const double end : {-half, half}) {
    best = std::min(best, squared(end, held(ab * end - db)));
    best = std::min(best, squared(held(ab * end + da), end));
  }
  return std::sqrt(best);
}

namespace {

/// Of equally close pairs, that with the lowest rows.
bool closer(const Overlap& a, const Overlap& b) {
  if (a.distance != b.distance) return a.distance < b.distance;
  return a.row[0] != b.row[0] ? a.row[0] < b.row[0] : a.row[1] < b.row[1];
}

}  // namespace

Overlap deepestOverlap(const State& state, const ForceField& forces, double below) {
  const Overlap none{std::numeric_limits<double>::infinity(), {0, 0}, {0, 0}, {0, 0}};
  const auto& lists = forces.lists().pairs().threads();
  std::vector<Overlap> found(lists.size(), none);
  const int points = forces.pair() ? forces.pair()->points().near : 1;
  const double half = 0.5 * forces.fibre().length * (points - 1) / points,
               reach2 = (below + 2.0 * half) * (below + 2.0 * half);
  onShares(lists.size(), [&](std::size_t t) {
    for (const auto* list : {&lists[t].inner, &lists[t].outer})
      list->forEach([&](const ListPair& p) {
        const Vec3d d = forces.nearest()(state.position(p.j) - state.position(p.i));
        if (dot(d, d) >= reach2) return;
        const double distance =
            distanceOfPieces(d, axis1(state.orientation(p.i)), axis1(state.orientation(p.j)), half);
        if (!(distance < below)) return;
        const Overlap pair{distance,
                           {state.row[p.i], state.row[p.j]},
                           {state.fibre[p.i], state.fibre[p.j]},
                           {state.chain[2 * p.i], state.chain[2 * p.j]}};
        if (closer(pair, found[t])) found[t] = pair;
      });
  });
  Overlap deepest = none;
  for (const Overlap& f : found)
    if (closer(f, deepest)) deepest = f;
  if (state.ranks() == 1) return deepest;
  double least = deepest.distance;
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, state.comm());
  if (std::isinf(least)) return none;
  std::vector<Overlap> all(static_cast<std::size_t>(state.ranks()));
  MPI_Allgather(&deepest, sizeof deepest, MPI_BYTE, all.data(), sizeof deepest, MPI_BYTE,
                state.comm());
  return *std::ranges::min_element(all, closer);
}

}  // namespace nanoweft
