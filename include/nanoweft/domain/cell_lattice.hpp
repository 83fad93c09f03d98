/// A lattice of cells over a region of space: in which cell a point lies, and which cells are
/// neighbours. Points outside the region count in the outermost cells; neighbours still find each
/// other there.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "nanoweft/base/index_map.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class CellLattice {
 public:
  /// A lattice for `points` points that lie between the corners: cells with edges of about `edge`,
  /// and neighbours for points within `range` of each other. In periodic directions the corners
  /// must be those of the box.
  CellLattice(const std::array<double, 3>& lower, const std::array<double, 3>& upper,
              const std::array<bool, 3>& periodic, double edge, double range, double points);

  std::int64_t cellOf(const double* x) const {
    std::int64_t id = 0;
    for (int d = 2; d >= 0; --d) {
      const double c = (x[d] - lower_[d]) * inverseEdge_[d];
      id = id * cells_[d] + static_cast<int>(std::clamp(c, 0.0, cells_[d] - 1.0));
    }
    return id;
  }

  /// The cells that may hold points within the range of points of `cell`, itself included, each
  /// once.
  void neighbours(std::int64_t cell, std::vector<std::int64_t>& out) const;

 protected:
  CellLattice(const std::array<double, 3>& lower, const std::array<bool, 3>& periodic)
      : lower_(lower), periodic_(periodic) {}
  /// Sets the number of cells: edges of at least `edge`, or more where that would be too many cells
  /// for so many points.
  void choose(const std::array<double, 3>& length, double edge, double points);
  /// Sets what follows from the number of cells.
  void finish(const std::array<double, 3>& length, double range);

  std::array<double, 3> lower_, inverseEdge_;
  std::array<int, 3> cells_, reach_;
  std::array<bool, 3> periodic_;
};

/// Points by cell: `order` lists the points cell after cell, each cell's in the order of their
/// rows.
struct CellIndex {
  /// Of the points 0 <= i < count.
  CellIndex(const State& state, const CellLattice& lattice, int count);
  CellIndex(const State& state, const CellLattice& lattice, std::vector<int> points);

  struct Range {
    std::int64_t cell;
    int begin, end;  ///< places in `order`
  };
  std::vector<int> order;
  std::vector<Range> ranges;
  IndexMap rangeOf{0};  ///< cell -> place in `ranges`
};

}  // namespace nanoweft
