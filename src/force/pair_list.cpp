#include "nanoweft/force/pair_list.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <utility>

#include "nanoweft/base/threads.hpp"

namespace nanoweft {

namespace {

/// Positions of the segments in the order of their cells, an array a coordinate, so that one
/// segment is compared with `laneCount` others at a time.
class OrderedSegments {
 public:
  explicit OrderedSegments(std::size_t count) {
    // Padding, so that a whole SIMD group can be read from any place.
    for (auto* v : {&x_, &y_, &z_}) v->resize(count + laneCount);
    point_.resize(count + laneCount);
  }
  void set(std::size_t place, int point, const Vec3d& x) {
    x_[place] = x.x;
    y_[place] = x.y;
    z_[place] = x.z;
    point_[place] = point;
  }

  /// Writes the segments at the places begin <= place < end that lie within sqrt(range2) of x to
  /// `found`, and returns their number. `found` needs room for end - begin + laneCount.
  std::size_t within(const Vec3d& x, double range2, const MinimumImage& nearest, int begin, int end,
                     std::int32_t* found) const {
    const Vec3<Lanes> from{x.x, x.y, x.z};
    std::size_t count = 0;
    for (int k = begin; k < end; k += laneCount) {
      const Vec3<Lanes> d = nearest(Vec3<Lanes>{load(x_, k), load(y_, k), load(z_, k)} - from);
      unsigned near = lanesBelow(dot(d, d), range2);
      if (end - k < laneCount) near &= (1u << (end - k)) - 1;
      packLanes(near, &point_[static_cast<std::size_t>(k)], found + count);
      count += static_cast<std::size_t>(std::popcount(near));
    }
    return count;
  }

 private:
  NW_INLINE static Lanes load(const std::vector<double>& v, int place) {
    return Lanes(v.data() + place, stdx::element_aligned);
  }

  std::vector<double> x_, y_, z_;
  std::vector<std::int32_t> point_;
};

/// Consecutive places of the order whose segments lie in a cell or next to it.
struct Run {
  int begin, end;
  bool own;  ///< only a thread's own segments lie there, in the order of their indices
};

void runsAround(const KindCells& where, std::int64_t cell, std::vector<std::int64_t>& around,
                std::vector<Run>& runs) {
  const CellIndex& cells = where.cells;
  runs.clear();
  where.lattice.neighbours(cell, around);
  for (std::int64_t c : around) {
    const int place = cells.rangeOf.at(c);
    if (place < 0) continue;
    const auto& r = cells.ranges[static_cast<std::size_t>(place)];
    if (!runs.empty() && runs.back().end == r.begin)
      runs.back().end = r.end;
    else
      runs.push_back({r.begin, r.end, false});
  }
}

bool ownedAscend(const std::vector<int>& order, int owned) {
  int last = -1;
  for (const int i : order) {
    if (i >= owned) continue;
    if (i < last) return false;
    last = i;
  }
  return true;
}

void findOwn(const CellIndex& cells, Share share, std::vector<Run>& runs) {
  for (Run& run : runs)
    run.own = std::all_of(cells.order.begin() + run.begin, cells.order.begin() + run.end,
                          [&](int i) { return i >= share.begin && i < share.end; });
}

}  // namespace

std::vector<Share> shareSegments(const State& state, const CellGrid& grid, const CellIndex& cells,
                                 int threads) {
  if (threads == 1) return {{0, state.owned()}};
  // Neighbours of a segment, estimated by the population of the cells around it, plus its own work.
  std::vector<double> work(static_cast<std::size_t>(state.owned()) + 1, 0.0);
  std::vector<std::int64_t> around;
  for (const auto& r : cells.ranges) {
    grid.neighbours(r.cell, around);
    double population = 10.0;
    for (std::int64_t c : around)
      if (const int place = cells.rangeOf.at(c); place >= 0) {
        const auto& other = cells.ranges[static_cast<std::size_t>(place)];
        population += other.end - other.begin;
      }
    for (int k = r.begin; k < r.end; ++k)
      if (const int i = cells.order[static_cast<std::size_t>(k)]; i < state.owned())
        work[static_cast<std::size_t>(i) + 1] = population;
  }
  for (std::size_t i = 1; i < work.size(); ++i) work[i] += work[i - 1];
  std::vector<Share> shares(static_cast<std::size_t>(threads));
  std::int32_t begin = 0;
  for (int t = 0; t < threads; ++t) {
    const double goal = work.back() * (t + 1) / threads;
    auto end =
        static_cast<std::int32_t>(std::lower_bound(work.begin(), work.end(), goal) - work.begin());
    if (t == threads - 1) end = state.owned();
    shares[static_cast<std::size_t>(t)] = {begin, std::max(begin, std::min(end, state.owned()))};
    begin = shares[static_cast<std::size_t>(t)].end;
  }
  return shares;
}

/// What a thread finds. A pair of two threads' or ranks' segments is taken by that of the first
/// segment or of the second as the sum of rows is odd or even, so that each takes about half.
struct PairList::Found {
  const bool sharing, ranksShare;
  const State& state;
  const Share share;
  FoundPairs inner, across, left, taken, shared;

  bool mine(std::int32_t i) const { return share.holds(i); }
  /// A pair with at least one segment of the thread; `inOrder`: i comes first.
  void add(std::int32_t i, std::int32_t j, bool inOrder) {
    auto takes = [&] { return mine(inOrder ? i : j) == ((state.row[i] + state.row[j]) % 2 == 1); };
    if (i >= state.owned() || j >= state.owned()) {
      (!ranksShare || takes() ? taken : left).add(i, j, inOrder);
    } else if (!sharing || mine(i) == mine(j)) {
      inner.add(i, j, inOrder);
    } else {
      across.add(i, j, inOrder);
      if (takes()) shared.add(i, j, inOrder);
    }
  }
};

void PairList::keep(const Found& found, const State& state, std::size_t thread) {
  threads_[thread].inner.set(found.inner, state.owned());
  threads_[thread].across.set(found.across, state.owned());
  threads_[thread].left.set(found.left, state.local());
  threads_[thread].taken.set(found.taken, state.local());
  drawn_[thread].shared.set(found.shared, state.owned());
}

void PairList::start(const State& state, const std::vector<Share>& shares) {
  // With fewer segments the messages that take sums back last longer than the pairs that they save.
  constexpr std::int64_t leastOfRank = 100;
  ranksShare_ = sharing_ && state.ranks() > 1 && state.total() >= leastOfRank * state.ranks();
  shares_ = shares;
  // What was drawn before gives its memory to the pairs that are being found.
  drawn_.clear();
  drawn_.resize(shares.size());
  threads_.resize(shares.size());
}

void PairList::build(const State& state, const KindCells& where, const std::vector<Share>& shares,
                     double range, int exclude) {
  const CellIndex& cells = where.cells;
  const MinimumImage nearest(state.box);
  const double range2 = range * range;
  const int owned = state.owned();
  const std::vector<int>& order = cells.order;
  // Owned segments are stored in the order of the domain's cells, which other cells do not have.
  const bool ascends = ownedAscend(order, owned);
  OrderedSegments segments(order.size());
  start(state, shares);

#pragma omp parallel for num_threads(teamOf(shares.size()))
  for (std::size_t k = 0; k < order.size(); ++k)
    segments.set(k, order[k], state.position(order[k]));
  onShares(shares.size(), [&](std::size_t t) {
    const Share share = shares[t];
    Found lists{sharing_, ranksShare_, state, share, {}, {}, {}, {}, {}};
    std::vector<Run> runs;
    std::vector<std::int64_t> around;
    std::vector<std::int32_t> found;
    for (const auto& cell : cells.ranges) {
      bool arrived = false;
      for (int k = cell.begin; k < cell.end; ++k) {
        const int i = order[static_cast<std::size_t>(k)];
        if (!share.holds(i)) continue;
        if (!std::exchange(arrived, true)) {
          runsAround(where, cell.cell, around, runs);
          if (ascends) findOwn(cells, share, runs);
          int longest = 0;
          for (const Run& run : runs) longest = std::max(longest, run.end - run.begin);
          found.resize(static_cast<std::size_t>(longest + laneCount));
        }
        const std::int64_t row = state.row[i], start = row - state.chain[2 * i];
        for (const Run& run : runs) {
          // A pair of two own segments is found from the one of the lower index, which in a run of
          // own ones comes first in the cells' order.
          const std::size_t count = segments.within(
              state.position(i), range2, nearest, run.own ? std::max(run.begin, k + 1) : run.begin,
              run.end, found.data());
          for (std::size_t n = 0; n < count; ++n) {
            const int j = found[n];
            const std::int64_t other = state.row[j];
            if (!run.own && (share.holds(j) ? j <= i : other == row)) continue;
            if (other - state.chain[2 * j] == start) {
              const int places = placesOn(state, i, j);
              if (std::abs(places) < exclude) {
                if (!state.gap || std::abs(places) > 63) continue;
                const std::int64_t apart = state.gap[4 * i + (places > 0 ? 2 : 3)];
                if (!(apart >> std::abs(places) & 1)) continue;
              }
            }
            lists.add(i, j, row < other);
          }
        }
      }
    }
    keep(lists, state, t);
  });
}

void PairList::buildMixed(const State& state, const std::vector<int>& firsts,
                          const KindCells& others, const std::vector<Share>& shares, double range) {
  const MinimumImage nearest(state.box);
  const double range2 = range * range;
  const std::vector<int>& order = others.cells.order;
  OrderedSegments segments(order.size());
  for (std::size_t k = 0; k < order.size(); ++k)
    segments.set(k, order[k], state.position(order[k]));
  start(state, shares);
  onShares(shares.size(), [&](std::size_t t) {
    Found lists{sharing_, ranksShare_, state, shares[t], {}, {}, {}, {}, {}};
    std::vector<Run> runs;
    std::vector<std::int64_t> around;
    std::vector<std::int32_t> found;
    for (const int i : firsts) {
      const Vec3d x = state.position(i);
      runsAround(others, others.lattice.cellOf(state.pose + 8 * i), around, runs);
      for (const Run& run : runs) {
        found.resize(static_cast<std::size_t>(run.end - run.begin + laneCount));
        const std::size_t count =
            segments.within(x, range2, nearest, run.begin, run.end, found.data());
        for (std::size_t n = 0; n < count; ++n) {
          const int j = found[n];
          if (lists.mine(i) || lists.mine(j)) lists.add(i, j, true);
        }
      }
    }
    keep(lists, state, t);
  });
}

void PairList::count(double weight, std::vector<double>& work) const {
  const auto owned = static_cast<std::int32_t>(work.size());
  for (std::size_t t = 0; t < threads_.size(); ++t)
    for (const PairRuns* list : threads_[t].all())
      list->forEach([&](const ListPair& p) {
        for (std::int32_t k : {p.i, p.j})
          // A pair of two threads' or ranks' segments stands in two lists.
          if (k < owned && shares_[t].holds(k)) work[static_cast<std::size_t>(k)] += 0.5 * weight;
      });
}

std::int64_t PairList::size() const {
  std::int64_t n = 0;
  for (std::size_t t = 0; t < threads_.size(); ++t)
    n += static_cast<std::int64_t>(threads_[t].inner.pairs() + threads_[t].taken.pairs() +
                                   drawn_[t].shared.pairs());
  return n;
}

}  // namespace nanoweft
