/// The grid of cells over the box, a PETSc DMDA: in which cell a point lies, which cells are
/// neighbours, and which rank owns a cell. Pair list, halo and rectilinear partition are built on
/// it. In open directions the grid spans the segments. A segment that leaves the grid later counts
/// in the outermost cell; neighbours still find each other there.
#pragma once

#include <petscdmda.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "nanoweft/base/index_map.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class CellGrid {
 public:
  /// Cells with edges of at least `range`, cut among the ranks so that each gets about the same
  /// `work` (of each owned segment). `lower`, `upper`: the box in periodic directions, else the
  /// segments' extent.
  CellGrid(const State& state, const std::array<double, 3>& lower,
           const std::array<double, 3>& upper, double range, const std::vector<double>& work);
  ~CellGrid();
  CellGrid(const CellGrid&) = delete;
  CellGrid& operator=(const CellGrid&) = delete;

  DM dm() const { return dm_; }
  double range() const { return range_; }
  bool covers(const std::array<double, 3>& lower, const std::array<double, 3>& upper) const;

  std::int64_t cellOf(const double* x) const {
    std::int64_t id = 0;
    for (int d = 2; d >= 0; --d) {
      const double c = (x[d] - lower_[d]) * inverseEdge_[d];
      id = id * cells_[d] + static_cast<int>(std::clamp(c, 0.0, cells_[d] - 1.0));
    }
    return id;
  }

  /// The rank whose part of the DMDA holds the cell.
  int owner(std::int64_t cell) const;

  /// The cells that may hold points within `range` of points of `cell`, itself included, each once.
  void neighbours(std::int64_t cell, std::vector<std::int64_t>& out) const;

 private:
  DM dm_ = nullptr;
  double range_;
  std::array<double, 3> lower_, upper_, inverseEdge_;
  std::array<int, 3> cells_, reach_, parts_;
  std::array<bool, 3> periodic_;
  std::array<std::vector<PetscInt>, 3> ends_;  // end of each part's cells, by direction
};

/// Points by cell: `order` lists the points cell after cell, each cell's in the order of their
/// rows.
struct CellIndex {
  CellIndex(const State& state, const CellGrid& grid, int count);

  struct Range {
    std::int64_t cell;
    int begin, end;  ///< places in `order`
  };
  std::vector<int> order;
  std::vector<Range> ranges;
  IndexMap rangeOf{0};  ///< cell -> place in `ranges`
};

}  // namespace nanoweft
