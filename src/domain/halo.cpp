#include "nanoweft/domain/halo.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "nanoweft/base/error.hpp"
#include "nanoweft/domain/deliver.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

namespace {

/// What a rank says of a cell to the cell's owner.
struct CellNotice {
  std::int64_t cell;
  std::int32_t holds;  // else: wants
};

/// What a cell's owner tells a holder.
struct CellRequest {
  std::int64_t cell;
  std::int32_t wanter;
};

struct Candidate {
  double x[3];
  std::int64_t row;
  std::int32_t local;
};

}  // namespace

Halo::Halo(MPI_Comm comm) {
  petsc(PetscSFCreate(comm, &sf_));
  for (std::size_t k = 0; k < units_.size(); ++k) {
    const Field& f = fields[k];
    if (f.whole())
      MPI_Type_contiguous(static_cast<int>(f.bytes() / sizeof(int)), MPI_INT, &units_[k]);
    else
      MPI_Type_contiguous(f.components, MPI_DOUBLE, &units_[k]);
    MPI_Type_commit(&units_[k]);
  }
}

Halo::~Halo() {
  PetscSFDestroy(&sf_);
  for (MPI_Datatype& unit : units_) MPI_Type_free(&unit);
}

void Halo::build(State& state, const CellGrid& grid, double range) {
  const MPI_Comm comm = state.comm();
  if (state.ranks() == 1) return;
  const CellIndex cells(state, grid, state.owned());

  // (a) Tell the owners of cells what is held and wanted.
  std::map<int, std::vector<CellNotice>> notices;
  {
    IndexMap wanted(4 * cells.ranges.size());
    std::vector<std::int64_t> around;
    for (const auto& r : cells.ranges) {
      notices[grid.owner(r.cell)].push_back({r.cell, 1});
      grid.neighbours(r.cell, around);
      for (std::int64_t c : around)
        if (wanted.at(c) < 0) {
          wanted.insert(c, 0);
          notices[grid.owner(c)].push_back({c, 0});
        }
    }
  }
  // (b) As owner: tell each holder of a cell who wants it.
  std::map<int, std::vector<CellRequest>> requests;
  {
    std::unordered_map<std::int64_t, std::pair<std::vector<int>, std::vector<int>>> directory;
    for (const auto& [rank, items] : deliver(comm, notices))
      for (const CellNotice& n : items)
        (n.holds ? directory[n.cell].first : directory[n.cell].second).push_back(rank);
    for (const auto& [cell, ranks] : directory)
      for (int holder : ranks.first)
        for (int wanter : ranks.second)
          if (holder != wanter) requests[holder].push_back({cell, wanter});
  }
  // (c) As holder: send the segments of those cells.
  std::map<int, std::vector<Candidate>> offers;
  for (const auto& [rank, items] : deliver(comm, requests))
    for (const CellRequest& r : items) {
      const auto& cell = cells.ranges[static_cast<std::size_t>(cells.rangeOf.at(r.cell))];
      auto& list = offers[r.wanter];
      for (int k = cell.begin; k < cell.end; ++k) {
        const int i = cells.order[static_cast<std::size_t>(k)];
        list.push_back(
            {{state.pose[8 * i], state.pose[8 * i + 1], state.pose[8 * i + 2]}, state.row[i], i});
      }
    }
  // (d) Keep those in range of an own segment, and bond partners.
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max(), highest = -1;
  for (int i = 0; i < state.owned(); ++i)
    for (const Tie& tie : state.ties(i))
      lowest = std::min(lowest, tie.row), highest = std::max(highest, tie.row);
  IndexMap partners(static_cast<std::size_t>(state.owned()), lowest, highest);
  for (int i = 0; i < state.owned(); ++i)
    for (const Tie& tie : state.ties(i)) partners.insert(tie.row, i);
  const MinimumImage nearest(state.box);
  std::vector<Candidate> kept;
  std::vector<PetscSFNode> remote;
  std::vector<std::int64_t> around;
  for (const auto& [rank, items] : deliver(comm, offers)) {
    const std::size_t first = kept.size();
    std::int64_t lastCell = -1;
    for (const Candidate& c : items) {
      bool keep = partners.at(c.row) >= 0;
      if (const std::int64_t cell = grid.cellOf(c.x); !keep && cell != lastCell) {
        grid.neighbours(cell, around);
        lastCell = cell;
      }
      if (!keep)
        for (std::size_t a = 0; a < around.size() && !keep; ++a) {
          const int place = cells.rangeOf.at(around[a]);
          if (place < 0) continue;
          const auto& r = cells.ranges[static_cast<std::size_t>(place)];
          for (int k = r.begin; k < r.end && !keep; ++k) {
            const int i = cells.order[static_cast<std::size_t>(k)];
            const Vec3d d = nearest(state.position(i) - Vec3d{c.x[0], c.x[1], c.x[2]});
            keep = dot(d, d) < range * range;
          }
        }
      if (keep) kept.push_back(c);
    }
    // One block of leaves per rank, so that MPI receives straight into place.
    std::sort(kept.begin() + static_cast<std::ptrdiff_t>(first), kept.end(),
              [](const Candidate& a, const Candidate& b) { return a.local < b.local; });
    for (std::size_t k = first; k < kept.size(); ++k) remote.push_back({rank, kept[k].local});
  }
  // (e) The kept ones are the leaves of the star forest.
  const int ghosts = static_cast<int>(kept.size()), owned = state.owned();
  petsc(PetscSFSetGraph(sf_, owned, ghosts, nullptr, PETSC_COPY_VALUES, remote.data(),
                        PETSC_COPY_VALUES));
  state.addGhosts(ghosts);
  for (Broadcast* half : {PetscSFBcastBegin, PetscSFBcastEnd})
    for (const Ghosts which : {Ghosts::whenBuilt, Ghosts::everyStep}) broadcast(half, state, which);
}

void Halo::broadcast(Broadcast* half, State& state, Ghosts which) {
  if (state.ranks() == 1) return;
  for (std::size_t k = 0; k < units_.size(); ++k) {
    char* const values = fields[k].data(state);
    if (fields[k].ghosts != which || !values) continue;
    const std::size_t ownBytes = fields[k].bytes() * static_cast<std::size_t>(state.owned());
    petsc(half(sf_, units_[k], values, values + ownBytes, MPI_REPLACE));
  }
}

void Halo::refreshBegin(State& state) {
  broadcast(PetscSFBcastBegin, state, Ghosts::everyStep);
}

void Halo::refreshEnd(State& state) {
  broadcast(PetscSFBcastEnd, state, Ghosts::everyStep);
}

void Halo::refreshVelocities(State& state) {
  broadcast(PetscSFBcastBegin, state, Ghosts::whenAsked);
  broadcast(PetscSFBcastEnd, state, Ghosts::whenAsked);
}

}  // namespace nanoweft
