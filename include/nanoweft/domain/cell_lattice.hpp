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
  /// must be those of the box. In a tilted box cells lie in straightened coordinates, in which
  /// images across the tilt do not slide.
  CellLattice(const std::array<double, 3>& lower, const std::array<double, 3>& upper,
              const Box& box, double edge, double range, double points);

  std::int64_t cellOf(const double* x) const {
    std::int64_t id = 0;
    for (int k = 2; k >= 0; --k) id = id * cells_[axes_[k]] + layerOf(x, axes_[k]);
    return id;
  }
  /// Number of the layer of cells along an axis.
  int layerOf(const double* x, int d) const {
    const double way = d == tilt_.along && tilt_ ? straightened(x) : x[d] - lower_[d];
    return static_cast<int>(std::clamp(way * inverseEdge_[d], 0.0, cells_[d] - 1.0));
  }

  /// The cells that may hold points within the range of points of `cell`, itself included, each
  /// once.
  void neighbours(std::int64_t cell, std::vector<std::int64_t>& out) const;

 protected:
  CellLattice(const std::array<double, 3>& lower, const Box& box);
  /// The numbers of a cell's layers along the axes.
  std::array<int, 3> layersOf(std::int64_t cell) const {
    std::array<int, 3> layers;
    for (const int d : axes_) {
      layers[static_cast<std::size_t>(d)] = static_cast<int>(cell % cells_[d]);
      cell /= cells_[d];
    }
    return layers;
  }
  /// Sets the number of cells: edges of at least `edge`, or more where that would be too many cells
  /// for so many points.
  void choose(const std::array<double, 3>& length, double edge, double points);
  /// Sets what follows from the number of cells.
  void finish(const std::array<double, 3>& length, double range);

  std::array<double, 3> lower_, inverseEdge_;
  std::array<int, 3> cells_, reach_;
  /// Axes by their numbers of cells. Cells are counted along the first of them first, so that
  /// consecutive cells fill thin slices across the last, and threads that share the segments in
  /// this order have short borders.
  std::array<int, 3> axes_{0, 1, 2};
  std::array<bool, 3> periodic_;
  Tilt tilt_;

 private:
  /// Place along the tilt in straightened coordinates.
  double straightened(const double* x) const;

  double slope_ = 0, period_ = 0;            ///< of the tilt, and length of the box along it
  std::array<double, 3> straight_{1, 1, 1};  ///< by how much straightened distances are longer
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
