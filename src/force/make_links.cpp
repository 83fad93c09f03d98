#include "nanoweft/force/make_links.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/gather.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/force/overlap.hpp"

namespace nanoweft {

namespace {

/// The listed pairs that are close enough, each on the rank that owns its first segment.
std::vector<ListPair> places(const State& state, const ForceField& forces, double distance) {
  std::vector<ListPair> found;
  for (std::size_t c = 0; c < forces.pairs().classes().size(); ++c) {
    if (!forces.pairs().classes()[c].widest) continue;
    const Both<double> length = forces.pairs().classes()[c].force->length();
    for (std::size_t t = 0; t < forces.shares().size(); ++t) {
      const Share share = forces.shares()[t];
      const auto& lists = forces.lists().pairs()[c].threads()[t];
      for (const PairRuns* list : lists.all())
        list->forEach([&](const ListPair& p) {
          if (!share.holds(p.i) || state.fibre[p.i] == state.fibre[p.j]) return;
          const Vec3d d = forces.nearest()(state.position(p.j) - state.position(p.i));
          if (distanceOfPieces(d, axis1(state.orientation(p.i)), axis1(state.orientation(p.j)),
                               {0.5 * length.i, 0.5 * length.j}) <= distance)
            found.push_back(p);
        });
    }
  }
  return found;
}

Link linkAt(const State& state, const ForceField& forces, const ListPair& p) {
  Link link;
  const int ends[2] = {p.i, p.j};
  const Vec3d chord = forces.nearest()(state.position(p.j) - state.position(p.i));
  link.length = norm(chord);
  const Quatd frame = frameAlong((1.0 / link.length) * chord);
  for (std::size_t side = 0; side < 2; ++side) {
    const int k = ends[side];
    link.row[side] = state.row[k];
    link.fibre[side] = state.fibre[k];
    link.index[side] = state.chain[2 * k];
    link.frame[side] = conjugate(state.orientation(k)) * frame;
  }
  return link;
}

/// Links are made among the pairs of the lists. Throws InputError where these need not have all
/// pairs of pieces that are so near.
void requireListed(double distance, const ForceField& forces, const UnitSystem& units) {
  if (!forces.pairs())
    throw InputError(
        "-links_density: links are made among the pairs of the lists, and there are none without "
        "-pair");
  const double skin = forces.lists().range() - forces.pairs().reach();
  double most = std::numeric_limits<double>::infinity();
  for (const PairForces::Class& c : forces.pairs().classes()) {
    const Both<double> length = c.force->length();
    if (c.widest) most = std::min(most, c.force->reach() + skin - 0.5 * (length.i + length.j));
  }
  if (distance <= most) return;
  throw InputError(
      format("-links_distance %g: beyond %.4g %s, up to which the pair lists have all pairs of "
             "segments; links are made among their pairs (a wider -pair_skin lists more)",
             distance, most, units.length));
}

/// Makes the links of one kind, where it has none yet.
void makeLinksOf(int kind, State& state, const ForceField& forces, const UnitSystem& units,
                 std::uint64_t seed) {
  const LinkLaw& law = forces.links().laws()[static_cast<std::size_t>(kind)];
  requireListed(law.distance, forces, units);
  auto pairs = places(state, forces, law.distance);
  std::vector<std::array<std::int64_t, 2>> tied;
  for (const Link& l : state.links)
    if (l.kind == kind)
      tied.push_back({std::min(l.row[0], l.row[1]), std::max(l.row[0], l.row[1])});
  std::ranges::sort(tied);
  std::erase_if(pairs, [&](const ListPair& p) {
    const auto [low, high] = std::minmax(state.row[p.i], state.row[p.j]);
    return std::ranges::binary_search(tied, std::array<std::int64_t, 2>{low, high});
  });
  double sums[2] = {static_cast<double>(pairs.size()), 0.0};  // places, and length of fibre
  for (int i = 0; i < state.owned(); ++i) sums[1] += forces.kinds()[state.kind(i)].length;
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, state.comm());
  const double share = law.density * sums[1] / std::max(1.0, sums[0]);
  if (share > 1.0)
    throw InputError(
        format("-links_density %g: there are only %.0f pairs of segments without a link within "
               "-links_distance %g, so %.3g 1/%s at most",
               law.density, sums[0], law.distance, sums[0] / sums[1], units.length));
  Links mine;
  for (const ListPair& p : pairs)
    if (uniformPair(seed, linksOfKind(kind), state.row[p.i],
                    static_cast<std::uint32_t>(state.row[p.j]))[0] < share)
      mine.push_back(linkAt(state, forces, p));
  std::int64_t id = state.links.empty() ? 0 : state.links.back().id + 1;
  MPI_Allreduce(MPI_IN_PLACE, &id, 1, MPI_INT64_T, MPI_MAX, state.comm());
  std::vector<std::int64_t> rows(state.row, state.row + state.owned());
  std::ranges::sort(rows);
  auto own = [&](std::int64_t row) { return std::ranges::binary_search(rows, row); };
  Links all = ofAllRanks(mine, state.comm());
  std::ranges::sort(all, {}, &Link::row);  // an order that does not depend on ranks
  for (Link& link : all) {
    link.id = id++;
    link.kind = kind;
    if (own(link.row[0]) || own(link.row[1])) state.links.push_back(link);
  }
  state.linked = id > 0;
}

}  // namespace

void makeLinks(State& state, const ForceField& forces, const UnitSystem& units,
               std::uint64_t seed) {
  const LinkLaws& laws = forces.links().laws();
  for (std::size_t k = 0; k < laws.size(); ++k) {
    if (!(laws[k].density > 0)) continue;
    try {
      makeLinksOf(static_cast<int>(k), state, forces, units, seed);
    } catch (const InputError& problem) {
      if (laws[k].kind.empty()) throw;
      throw InputError("links " + laws[k].kind + ": " + problem.what());
    }
  }
}

}  // namespace nanoweft
