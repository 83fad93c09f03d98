/// The grid of cells over the box, a PETSc DMDA: a lattice of cells, each owned by a rank. Pair
/// list, halo and rectilinear partition are built on it. In open directions the grid spans the
/// segments.
#pragma once

#include <petscdmda.h>

#include <array>
#include <cstdint>
#include <vector>

#include "nanoweft/domain/cell_lattice.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class CellGrid : public CellLattice {
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
  bool covers(const std::array<double, 3>& lower, const std::array<double, 3>& upper,
              const Tilt& tilt) const;

  /// The rank whose part of the DMDA holds the cell.
  int owner(std::int64_t cell) const;

 private:
  DM dm_ = nullptr;
  double range_;
  std::array<double, 3> upper_;
  std::array<double, 3> from_, to_;  ///< what it was laid over
  std::array<int, 3> parts_;
  std::array<std::vector<PetscInt>, 3> ends_;  // end of each part's cells, by direction
};

}  // namespace nanoweft
