#include "nanoweft/force/pair_list.hpp"

#include <omp.h>

#include <bit>
#include <cstdlib>
#include <limits>

namespace nanoweft {

namespace {

/// The segments around a cell, as vectors to be compared with one segment at a time.
class Surroundings {
 public:
  struct Neighbour {
    std::int64_t row, start;
    std::int32_t point;
  };

  void clear() {
    list_.clear();
    for (auto* v : {&x_, &y_, &z_}) v->clear();
  }
  void add(const State& state, int j) {
    list_.push_back({state.row[j], state.row[j] - state.chain[2 * j], j});
    const Vec3d x = state.position(j);
    x_.push_back(x.x), y_.push_back(x.y), z_.push_back(x.z);
  }
  /// To be called when all are in: fills up whole SIMD groups with segments at infinity.
  void close() {
    for (auto* v : {&x_, &y_, &z_})
      v->insert(v->end(), laneCount, std::numeric_limits<double>::infinity());
  }

  /// Calls `found(neighbour)` for those within sqrt(range2) of x.
  template <class Found>
  void within(const Vec3d& x, double range2, const MinimumImage& nearest,
              const Found& found) const {
    const Vec3<Lanes> from{x.x, x.y, x.z};
    for (std::size_t k = 0; k < list_.size(); k += laneCount) {
      const Vec3<Lanes> d = nearest(Vec3<Lanes>{load(x_, k), load(y_, k), load(z_, k)} - from);
      for (unsigned near = lanesBelow(dot(d, d), range2); near; near &= near - 1)
        found(list_[k + static_cast<std::size_t>(std::countr_zero(near))]);
    }
  }

 private:
  NW_INLINE static Lanes load(const std::vector<double>& v, std::size_t k) {
    return Lanes(v.data() + k, stdx::element_aligned);
  }

  std::vector<Neighbour> list_;
  std::vector<double> x_, y_, z_;
};

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

void interleave(std::vector<ListPair>& pairs) {
  constexpr std::size_t streams = 8, stretch = 32 * streams;
  std::vector<ListPair> copy;
  for (std::size_t first = 0; first < pairs.size(); first += stretch) {
    const std::size_t length = std::min(stretch, pairs.size() - first) / streams;
    ListPair* const to = &pairs[first];
    copy.assign(to, to + length * streams);
    for (std::size_t k = 0; k < copy.size(); ++k) to[k] = copy[k % streams * length + k / streams];
  }
}

void PairList::build(const State& state, const CellGrid& grid, const CellIndex& cells,
                     const std::vector<Share>& shares, double range, int exclude) {
  const MinimumImage nearest(state.box);
  const double range2 = range * range;
  const int owned = state.owned();
  std::vector<std::int64_t> cellOfOwned(static_cast<std::size_t>(owned));
  for (const auto& r : cells.ranges)
    for (int k = r.begin; k < r.end; ++k)
      if (const int i = cells.order[static_cast<std::size_t>(k)]; i < owned)
        cellOfOwned[static_cast<std::size_t>(i)] = r.cell;
  threads_.resize(shares.size());
  drawn_.resize(shares.size());
  shares_ = shares;

#pragma omp parallel num_threads(static_cast <int>(shares.size()))
  {
    const auto t = static_cast<std::size_t>(omp_get_thread_num());
    const Share share = shares[t];
    auto& lists = threads_[t];
    lists.inner.clear();
    lists.outer.clear();
    Surroundings neighbours;
    std::vector<std::int64_t> around;
    std::int64_t lastCell = -1;
    for (std::int32_t i = share.begin; i < share.end; ++i) {
      if (const std::int64_t cell = cellOfOwned[static_cast<std::size_t>(i)]; cell != lastCell) {
        lastCell = cell;
        neighbours.clear();
        grid.neighbours(cell, around);
        for (std::int64_t c : around) {
          const int place = cells.rangeOf.at(c);
          if (place < 0) continue;
          const auto& r = cells.ranges[static_cast<std::size_t>(place)];
          for (int k = r.begin; k < r.end; ++k)
            neighbours.add(state, cells.order[static_cast<std::size_t>(k)]);
        }
        neighbours.close();
      }
      const std::int64_t row = state.row[i], start = row - state.chain[2 * i];
      neighbours.within(state.position(i), range2, nearest, [&](const auto& n) {
        const bool mine = n.point >= share.begin && n.point < share.end;
        if (mine ? n.row <= row : n.row == row) return;
        if (n.start == start) {
          const int places = placesOn(state, i, n.point);
          if (std::abs(places) < exclude) {
            if (!state.gap || std::abs(places) > 63) return;
            const std::int64_t apart = state.gap[4 * i + (places > 0 ? 2 : 3)];
            if (!(apart >> std::abs(places) & 1)) return;
          }
        }
        const ListPair pair = row < n.row ? ListPair{i, n.point} : ListPair{n.point, i};
        (n.point < owned ? lists.inner : lists.outer).push_back(pair);
      });
    }
    interleave(lists.inner);
    interleave(lists.outer);
  }
}

void PairList::count(std::vector<double>& pairs) const {
  const auto owned = static_cast<std::int32_t>(pairs.size());
  for (std::size_t t = 0; t < threads_.size(); ++t)
    for (const auto* list : {&threads_[t].inner, &threads_[t].outer})
      for (const ListPair& p : *list)
        for (std::int32_t k : {p.i, p.j})
          // A pair of two threads stands in both lists.
          if (k < owned && k >= shares_[t].begin && k < shares_[t].end)
            pairs[static_cast<std::size_t>(k)] += 0.5;
}

std::int64_t PairList::size() const {
  std::int64_t n = 0;
  for (const auto& t : threads_) n += static_cast<std::int64_t>(t.inner.size() + t.outer.size());
  return n;
}

}  // namespace nanoweft
