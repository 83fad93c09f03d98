#include "nanoweft/force/pair_list.hpp"

#include <omp.h>

#include <cstdlib>

namespace nanoweft {

std::vector<Share> shareSegments(const State& state, const CellGrid& grid, int threads) {
  const CellIndex cells(state, grid, state.local());
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

void PairList::build(const State& state, const CellGrid& grid, const std::vector<Share>& shares,
                     double range, int exclude) {
  const CellIndex cells(state, grid, state.local());
  const MinimumImage nearest(state.box);
  const double range2 = range * range;
  const int owned = state.owned();
  std::vector<std::int64_t> cellOfOwned(static_cast<std::size_t>(owned));
  for (const auto& r : cells.ranges)
    for (int k = r.begin; k < r.end; ++k)
      if (const int i = cells.order[static_cast<std::size_t>(k)]; i < owned)
        cellOfOwned[static_cast<std::size_t>(i)] = r.cell;
  threads_.resize(shares.size());
  shares_ = shares;

  struct Neighbour {
    Vec3d x;
    std::int64_t row, start;
    std::int32_t point;
  };
#pragma omp parallel num_threads(static_cast <int>(shares.size()))
  {
    const auto t = static_cast<std::size_t>(omp_get_thread_num());
    const Share share = shares[t];
    auto& lists = threads_[t];
    lists.inner.clear();
    lists.outer.clear();
    std::vector<Neighbour> neighbours;
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
          for (int k = r.begin; k < r.end; ++k) {
            const int j = cells.order[static_cast<std::size_t>(k)];
            neighbours.push_back(
                {state.position(j), state.row[j], state.row[j] - state.chain[2 * j], j});
          }
        }
      }
      const Vec3d x = state.position(i);
      const std::int64_t row = state.row[i], start = row - state.chain[2 * i];
      for (const Neighbour& n : neighbours) {
        const Vec3d d = nearest(n.x - x);
        if (!(dot(d, d) < range2)) continue;
        const bool mine = n.point >= share.begin && n.point < share.end;
        if (mine ? n.row <= row : n.row == row) continue;
        if (n.start == start) {
          const int places = placesOn(state, i, n.point);
          if (std::abs(places) < exclude) {
            if (!state.gap || std::abs(places) > 63) continue;
            const std::int64_t apart = state.gap[4 * i + (places > 0 ? 2 : 3)];
            if (!(apart >> std::abs(places) & 1)) continue;
          }
        }
        const ListPair pair = row < n.row ? ListPair{i, n.point} : ListPair{n.point, i};
        (n.point < owned ? lists.inner : lists.outer).push_back(pair);
      }
    }
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
