/// Ghosts: copies of other ranks' segments within a range of this rank's, and of bond partners.
///
/// Ranks meet through the cell directory: each tells the owners of cells where it has segments and
/// where it wants to see some; the owners tell the holders who wants them. Nobody holds a table of
/// all ranks or segments, and any assignment of segments to ranks works.
#pragma once

#include <petscsf.h>

#include "nanoweft/domain/cell_grid.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class Halo {
 public:
  explicit Halo(MPI_Comm comm);
  ~Halo();
  Halo(const Halo&) = delete;
  Halo& operator=(const Halo&) = delete;

  /// Finds the ghosts and appends them to `state` (which must have none) with their poses. Owned
  /// points must be in the order of their cells. Collective.
  void build(State& state, const CellGrid& grid, double range);

  /// Brings the ghosts' poses up to date; what lies between begin and end overlaps with it.
  void refreshBegin(State& state);
  void refreshEnd(State& state);
  /// Same for velocities: only viscous damping needs them.
  void refreshVelocities(State& state);

 private:
  PetscSF sf_ = nullptr, velocitySf_ = nullptr;
  MPI_Datatype pose_, triple_;
};

}  // namespace nanoweft
