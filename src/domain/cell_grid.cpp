#include "nanoweft/domain/cell_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

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
    : CellLattice(lower, state.box), range_(range), upper_(upper), from_(lower), to_(upper) {
  std::array<double, 3> length;
  for (int d = 0; d < 3; ++d) length[d] = std::max(upper[d] - lower[d], range);
  choose(length, range, static_cast<double>(state.total()));
  parts_ = arrangeRanks(state.ranks(), length, periodic_, cells_);
  for (int d = 0; d < 3; ++d) cells_[d] = std::max(cells_[d], parts_[d]);
  finish(length, range);
  for (int d = 0; d < 3; ++d) {
    upper_[d] = lower_[d] + length[d];
    std::vector<double> histogram(static_cast<std::size_t>(cells_[d]), 0.0);
    for (int i = 0; i < state.owned(); ++i)
      histogram[static_cast<std::size_t>(layerOf(state.pose + 8 * i, d))] +=
          work[static_cast<std::size_t>(i)];
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

bool CellGrid::covers(const std::array<double, 3>& lower, const std::array<double, 3>& upper,
                      const Tilt& tilt) const {
  if (tilt != tilt_) return false;
  for (std::size_t d = 0; d < 3; ++d)
    if (periodic_[d] && (lower[d] != from_[d] || upper[d] != to_[d])) return false;
  for (int d = 0; d < 3; ++d)
    if (!periodic_[d] && (lower[d] < lower_[d] - range_ || upper[d] > upper_[d] + range_))
      return false;
  return true;
}

int CellGrid::owner(std::int64_t cell) const {
  const std::array<int, 3> layers = layersOf(cell);
  int part[3];
  for (std::size_t d = 0; d < 3; ++d)
    part[d] = static_cast<int>(std::ranges::upper_bound(ends_[d], layers[d]) - ends_[d].begin());
  return part[0] + parts_[0] * (part[1] + parts_[1] * part[2]);
}

}  // namespace nanoweft
