#include "nanoweft/domain/cell_lattice.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace nanoweft {

namespace {

/// More cells than this per direction would only cost memory in the histograms below.
constexpr double mostCells = 4096;
constexpr double mostCellsInAll = 1 << 24;
/// More cells than this for each segment would only cost memory, too: fibres that drift far apart
/// in an open box would otherwise fill the space between them with cells.
constexpr double mostCellsPerSegment = 8;

}  // namespace

CellLattice::CellLattice(const std::array<double, 3>& lower, const std::array<double, 3>& upper,
                         const Box& box, double edge, double range, double points)
    : CellLattice(lower, box) {
  std::array<double, 3> length;
  for (int d = 0; d < 3; ++d) length[d] = std::max(upper[d] - lower[d], edge);
  choose(length, edge, points);
  finish(length, range);
}

CellLattice::CellLattice(const std::array<double, 3>& lower, const Box& box)
    : lower_(lower), periodic_(box.periodic), tilt_(box.tilt) {
  if (!tilt_) return;
  slope_ = tilt_.way / box.length(tilt_.across);
  period_ = box.length(tilt_.along);
  straight_[static_cast<std::size_t>(tilt_.along)] = std::hypot(1.0, slope_);
}

double CellLattice::straightened(const double* x) const {
  const double way = x[tilt_.along] - lower_[static_cast<std::size_t>(tilt_.along)] -
                     slope_ * (x[tilt_.across] - lower_[static_cast<std::size_t>(tilt_.across)]);
  return way - period_ * std::floor(way / period_);
}

void CellLattice::choose(const std::array<double, 3>& length, double edge, double points) {
  for (int d = 0; d < 3; ++d)
    cells_[d] =
        static_cast<int>(std::clamp(std::floor(length[d] / (edge * straight_[d])), 1.0, mostCells));
  // A vast box gets coarser cells: a DMDA numbers cells with 32 bits, and its vectors have an entry
  // for each of them.
  const double most = std::min(mostCellsInAll, std::max(4096.0, mostCellsPerSegment * points));
  while (static_cast<double>(cells_[0]) * cells_[1] * cells_[2] > most) {
    int& longest = *std::ranges::max_element(cells_);
    longest = (longest + 1) / 2;
  }
}

void CellLattice::finish(const std::array<double, 3>& length, double range) {
  std::ranges::stable_sort(axes_, {}, [this](int d) { return cells_[d]; });
  for (int d = 0; d < 3; ++d) {
    inverseEdge_[d] = cells_[d] / length[d];
    // The factor (1 - 1e-12): where an edge equals the range up to round-off, one cell suffices.
    reach_[d] = static_cast<int>(std::ceil(range * straight_[d] * inverseEdge_[d] * (1 - 1e-12)));
  }
}

void CellLattice::neighbours(std::int64_t cell, std::vector<std::int64_t>& out) const {
  // First cell and number of cells along each direction.
  std::array<int, 3> first, count;
  const std::array<int, 3> layers = layersOf(cell);
  for (int d = 0; d < 3; ++d) {
    const int n = cells_[d], c = layers[static_cast<std::size_t>(d)];
    const bool all = periodic_[d] && 2 * reach_[d] + 1 >= n;  // without meeting a cell twice
    int last = all ? n - 1 : c + reach_[d];
    first[d] = all ? 0 : c - reach_[d];
    if (!periodic_[d]) {
      first[d] = std::max(first[d], 0);
      last = std::min(last, n - 1);
    }
    count[d] = last - first[d] + 1;
  }
  auto wrapped = [&](int d, int k) { return (first[d] + k + cells_[d]) % cells_[d]; };
  out.clear();
  const auto [along, across, slowest] = axes_;
  for (int z = 0; z < count[slowest]; ++z)
    for (int y = 0; y < count[across]; ++y) {
      const std::int64_t line =
          (std::int64_t{wrapped(slowest, z)} * cells_[across] + wrapped(across, y)) * cells_[along];
      for (int x = 0; x < count[along]; ++x) out.push_back(line + wrapped(along, x));
    }
}

namespace {

std::vector<int> upTo(int count) {
  std::vector<int> points(static_cast<std::size_t>(count));
  std::iota(points.begin(), points.end(), 0);
  return points;
}

}  // namespace

CellIndex::CellIndex(const State& state, const CellLattice& lattice, int count)
    : CellIndex(state, lattice, upTo(count)) {}

CellIndex::CellIndex(const State& state, const CellLattice& lattice, std::vector<int> points)
    : order(points.size()) {
  if (points.empty()) return;
  std::vector<std::int64_t> cell(static_cast<std::size_t>(std::ranges::max(points)) + 1);
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max(), highest = -1;
  for (const int i : points) {
    const std::int64_t c = cell[static_cast<std::size_t>(i)] = lattice.cellOf(state.pose + 8 * i);
    lowest = std::min(lowest, c);
    highest = std::max(highest, c);
  }
  const auto span = static_cast<std::size_t>(highest - lowest) + 1;
  // A rank's cells mostly lie close together; a counting sort is faster then.
  if (span <= 8 * order.size()) {
    std::vector<int> place(span + 1, 0);
    for (const int i : points)
      ++place[static_cast<std::size_t>(cell[static_cast<std::size_t>(i)] - lowest) + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (const int i : points) {
      const std::int64_t c = cell[static_cast<std::size_t>(i)] - lowest;
      order[static_cast<std::size_t>(place[static_cast<std::size_t>(c)]++)] = i;
    }
  } else {
    order = std::move(points);
    std::ranges::sort(order, {}, [&](int i) { return cell[static_cast<std::size_t>(i)]; });
  }
  rangeOf = IndexMap(order.size(), lowest, highest);
  const auto rowOf = [&](int i) { return state.row[i]; };
  for (auto begin = order.begin(); begin != order.end();) {
    const std::int64_t here = cell[static_cast<std::size_t>(*begin)];
    const auto end = std::find_if(begin, order.end(),
                                  [&](int i) { return cell[static_cast<std::size_t>(i)] != here; });
    // Owned points are kept in this order, so most cells are found sorted.
    if (!std::ranges::is_sorted(begin, end, {}, rowOf)) std::ranges::sort(begin, end, {}, rowOf);
    rangeOf.insert(here, static_cast<int>(ranges.size()));
    ranges.push_back(
        {here, static_cast<int>(begin - order.begin()), static_cast<int>(end - order.begin())});
    begin = end;
  }
}

}  // namespace nanoweft
