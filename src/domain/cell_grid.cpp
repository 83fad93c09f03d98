#include "nanoweft/domain/cell_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// More cells than this per direction would only cost memory in the histograms below.
constexpr double mostCells = 4096;
constexpr double mostCellsInAll = 1 << 24;
/// More cells than this for each segment would only cost memory, too: fibres that drift far apart
/// in an open box would otherwise fill the space between them with cells.
constexpr double mostCellsPerSegment = 8;

/// Ranks per direction: of all ways to factor their number, the one with the least cut area, and
/// with parts no thinner than a cell when there is such a way.
std::array<int, 3> arrangeRanks(int ranks, const std::array<double, 3>& length,
                                const std::array<bool, 3>& periodic,
                                const std::array<int, 3>& cells) {
  std::array<int, 3> best{ranks, 1, 1};
  double bestCost = std::numeric_limits<double>::infinity();
  for (int px = 1; px <= ranks; ++px) {
    if (ranks % px) continue;
    for (int py = 1; py <= ranks / px; ++py) {
      if ((ranks / px) % py) continue;
      const std::array<int, 3> p{px, py, ranks / px / py};
      double cost = 0;
      for (int d = 0; d < 3; ++d) {
        const double area = length[(d + 1) % 3] * length[(d + 2) % 3];
        cost += area * (p[d] > 1 && periodic[d] ? p[d] : p[d] - 1);
        if (p[d] > cells[d]) cost += 1e3 * area * p[d];
      }
      if (cost < bestCost) bestCost = cost, best = p;
    }
  }
  return best;
}

/// Cuts `histogram` into `parts` runs of about equal sums, each with at least one cell.
std::vector<PetscInt> cut(const std::vector<double>& histogram, int parts) {
  const int cells = static_cast<int>(histogram.size());
  double total = 0;
  for (double h : histogram) total += h;
  std::vector<PetscInt> ends;
  double sum = 0;
  int cell = 0;
  for (int p = 1; p <= parts; ++p) {
    const int first = ends.empty() ? 1 : ends.back() + 1, last = cells - (parts - p);
    // Stop where the sum is nearest to its share.
    const double share = total * p / parts;
    while (cell < last &&
           (cell < first || sum + 0.5 * histogram[static_cast<std::size_t>(cell)] < share))
      sum += histogram[static_cast<std::size_t>(cell++)];
    ends.push_back(p == parts ? cells : cell);
  }
  return ends;
}

}  // namespace

CellGrid::CellGrid(const State& state, const std::array<double, 3>& lower,
                   const std::array<double, 3>& upper, double range,
                   const std::vector<double>& work)
    : range_(range), lower_(lower), upper_(upper), periodic_(state.box.periodic) {
  std::array<double, 3> length;
  for (int d = 0; d < 3; ++d) {
    length[d] = std::max(upper[d] - lower[d], range);
    cells_[d] = static_cast<int>(std::clamp(std::floor(length[d] / range), 1.0, mostCells));
  }
  // A vast box gets coarser cells: the DMDA numbers cells with 32 bits, and its vectors have an
  // entry for each of them.
  const double most = std::min(
      mostCellsInAll, std::max(4096.0, mostCellsPerSegment * static_cast<double>(state.total())));
  while (static_cast<double>(cells_[0]) * cells_[1] * cells_[2] > most) {
    int& longest = *std::ranges::max_element(cells_);
    longest = (longest + 1) / 2;
  }
  parts_ = arrangeRanks(state.ranks(), length, periodic_, cells_);
  for (int d = 0; d < 3; ++d) {
    cells_[d] = std::max(cells_[d], parts_[d]);
    upper_[d] = lower_[d] + length[d];
    inverseEdge_[d] = cells_[d] / length[d];
    // The factor (1 - 1e-12): where an edge equals the range up to round-off, one cell suffices.
    reach_[d] = static_cast<int>(std::ceil(range * inverseEdge_[d] * (1 - 1e-12)));
    std::vector<double> histogram(static_cast<std::size_t>(cells_[d]), 0.0);
    for (int i = 0; i < state.owned(); ++i) {
      const double c = (state.pose[8 * i + d] - lower_[d]) * inverseEdge_[d];
      histogram[static_cast<std::size_t>(std::clamp(c, 0.0, cells_[d] - 1.0))] +=
          work[static_cast<std::size_t>(i)];
    }
    MPI_Allreduce(MPI_IN_PLACE, histogram.data(), cells_[d], MPI_DOUBLE, MPI_SUM, state.comm());
    ends_[d] = cut(histogram, parts_[d]);
  }
  std::array<std::vector<PetscInt>, 3> widths;
  for (int d = 0; d < 3; ++d)
    for (std::size_t p = 0; p < ends_[d].size(); ++p)
      widths[d].push_back(ends_[d][p] - (p == 0 ? 0 : ends_[d][p - 1]));
  auto boundary = [&](int d) { return periodic_[d] ? DM_BOUNDARY_PERIODIC : DM_BOUNDARY_NONE; };
  petsc(DMDACreate3d(state.comm(), boundary(0), boundary(1), boundary(2), DMDA_STENCIL_BOX,
                     cells_[0], cells_[1], cells_[2], parts_[0], parts_[1], parts_[2], 1, 1,
                     widths[0].data(), widths[1].data(), widths[2].data(), &dm_));
  petsc(DMSetUp(dm_));
}

CellGrid::~CellGrid() {
  DMDestroy(&dm_);
}

bool CellGrid::covers(const std::array<double, 3>& lower,
                      const std::array<double, 3>& upper) const {
  for (int d = 0; d < 3; ++d)
    if (!periodic_[d] && (lower[d] < lower_[d] - range_ || upper[d] > upper_[d] + range_))
      return false;
  return true;
}

int CellGrid::owner(std::int64_t cell) const {
  int part[3];
  for (int d = 0; d < 3; ++d) {
    const auto c = static_cast<PetscInt>(cell % cells_[d]);
    cell /= cells_[d];
    part[d] =
        static_cast<int>(std::upper_bound(ends_[d].begin(), ends_[d].end(), c) - ends_[d].begin());
  }
  return part[0] + parts_[0] * (part[1] + parts_[1] * part[2]);
}

void CellGrid::neighbours(std::int64_t cell, std::vector<std::int64_t>& out) const {
  // First cell and number of cells along each direction.
  std::array<int, 3> first, count;
  for (int d = 0; d < 3; ++d) {
    const int n = cells_[d], c = static_cast<int>(cell % n);
    cell /= n;
    const bool all = 2 * reach_[d] + 1 >= n;
    int last = c + reach_[d];
    first[d] = all ? 0 : c - reach_[d];
    if (all) last = n - 1;
    if (!periodic_[d]) {
      first[d] = std::max(first[d], 0);
      last = std::min(last, n - 1);
    }
    count[d] = last - first[d] + 1;
  }
  auto wrapped = [&](int d, int k) { return (first[d] + k + cells_[d]) % cells_[d]; };
  out.clear();
  for (int z = 0; z < count[2]; ++z)
    for (int y = 0; y < count[1]; ++y) {
      const std::int64_t line =
          (std::int64_t{wrapped(2, z)} * cells_[1] + wrapped(1, y)) * cells_[0];
      for (int x = 0; x < count[0]; ++x) out.push_back(line + wrapped(0, x));
    }
}

CellIndex::CellIndex(const State& state, const CellGrid& grid, int count)
    : order(static_cast<std::size_t>(count)) {
  if (count == 0) return;
  std::vector<std::int64_t> cell(order.size());
  for (int i = 0; i < count; ++i)
    cell[static_cast<std::size_t>(i)] = grid.cellOf(state.pose + 8 * i);
  const auto [lowest, highest] = std::ranges::minmax(cell);
  const auto span = static_cast<std::size_t>(highest - lowest) + 1;
  // A rank's cells mostly lie close together; a counting sort is faster then.
  if (span <= 8 * order.size()) {
    std::vector<int> place(span + 1, 0);
    for (const std::int64_t c : cell) ++place[static_cast<std::size_t>(c - lowest) + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (int i = 0; i < count; ++i) {
      const std::int64_t c = cell[static_cast<std::size_t>(i)] - lowest;
      order[static_cast<std::size_t>(place[static_cast<std::size_t>(c)]++)] = i;
    }
  } else {
    std::iota(order.begin(), order.end(), 0);
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
