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

  /// Finds the ghosts and appends them to `state` (which must have none), with their fields as far
  /// as they carry them (Field::ghosts). Owned points must be in the order of their cells.
  /// Collective.
  void build(State& state, const CellGrid& grid, double range);

  /// Brings up to date what changes every step; what lies between begin and end overlaps with it.
  void refreshBegin(State& state);
  void refreshEnd(State& state);
  /// The same for what is asked for: velocities, which only viscous damping needs.
  void refreshVelocities(State& state);

 private:
  using Broadcast = decltype(PetscSFBcastBegin);
  void broadcast(Broadcast* half, State& state, Ghosts which);

  PetscSF sf_ = nullptr;
  std::array<MPI_Datatype, std::size(fields)> units_;  ///< of each field, the values of a segment
};

}  // namespace nanoweft
