/// The halo: ghosts, copies of other ranks' segments in range of a rank's own or bonded to them.
///
/// Ranks find each other through the owners of cells. Each rank tells the owners in which cells it
/// has segments and in which cells it needs those of others. The owner of a cell tells the ranks
/// that have segments there which ranks need them. No rank holds a table of all ranks or segments,
/// and any assignment of segments to ranks works.
#pragma once

#include <petscsf.h>

#include <cstdint>
#include <optional>
#include <vector>

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

  /// Bring the ghosts' fields that change every step up to date. Work done between begin and end
  /// overlaps with the communication.
  void refreshBegin(State& state);
  void refreshEnd(State& state);
  /// Add what has been summed on each ghost, eight integers a segment, to the sums of its owner.
  /// Work done between begin and end, except on `ghosts`, overlaps with the communication.
  /// Collective.
  void addGhostsBegin(const std::int64_t* ghosts);
  void addGhostsEnd(const std::int64_t* ghosts, std::int64_t* owned);
  /// Brings the ghosts' velocities up to date, which only viscous damping needs.
  void refreshVelocities(State& state);
  /// Brings the contacts of those ghosts up to date that follow or precede an owned segment along
  /// its fibre, which only friction needs.
  void refreshContacts(State& state);

 private:
  using Broadcast = decltype(PetscSFBcastBegin);
  void broadcast(Broadcast* half, State& state, Ghosts which);
  void chooseAlong(const State& state);
  void findOwners();

  PetscSF sf_ = nullptr;
  std::array<MPI_Datatype, std::size(fields)> units_;  ///< of each field, the values of a segment
  MPI_Datatype sumUnit_;                               ///< the sums of a segment
  /// Sums of other ranks, and the owned segment of each, once known.
  std::vector<std::int64_t> arriving_;
  std::optional<std::vector<PetscInt>> owner_;
  PetscSF along_ = nullptr;  ///< of sf_, the ghosts of Ghosts::alongFibres; only with friction
};

}  // namespace nanoweft
