#include "nanoweft/domain/halo.hpp"

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "nanoweft/base/error.hpp"
#include "nanoweft/domain/deliver.hpp"
#include "nanoweft/state/box.hpp"
#include "nanoweft/state/memory.hpp"

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

template <class T>
using ToRanks = std::map<int, std::vector<T>>;
template <class T>
using FromRanks = std::vector<std::pair<int, std::vector<T>>>;

/// What this rank tells the owners of cells: where it has segments, and where it wants to see some.
ToRanks<CellNotice> noticesToOwners(const CellGrid& grid, const CellIndex& cells) {
  ToRanks<CellNotice> notices;
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
  return notices;
}

/// What this rank, as owner of cells, tells each holder of one: who wants it.
ToRanks<CellRequest> requestsToHolders(const FromRanks<CellNotice>& notices) {
  std::unordered_map<std::int64_t, std::pair<std::vector<int>, std::vector<int>>> directory;
  for (const auto& [rank, items] : notices)
    for (const CellNotice& n : items)
      (n.holds ? directory[n.cell].first : directory[n.cell].second).push_back(rank);
  ToRanks<CellRequest> requests;
  for (const auto& [cell, ranks] : directory)
    for (int holder : ranks.first)
      for (int wanter : ranks.second)
        if (holder != wanter) requests[holder].push_back({cell, wanter});
  return requests;
}

/// The segments that this rank holds in cells that others want.
ToRanks<Candidate> offersToWanters(const State& state, const CellIndex& cells,
                                   const FromRanks<CellRequest>& requests) {
  ToRanks<Candidate> offers;
  for (const auto& [rank, items] : requests)
    for (const CellRequest& r : items) {
      const auto& cell = cells.ranges[static_cast<std::size_t>(cells.rangeOf.at(r.cell))];
      auto& list = offers[r.wanter];
      for (int k = cell.begin; k < cell.end; ++k) {
        const int i = cells.order[static_cast<std::size_t>(k)];
        list.push_back(
            {{state.pose[8 * i], state.pose[8 * i + 1], state.pose[8 * i + 2]}, state.row[i], i});
      }
    }
  return offers;
}

/// Which offered segments this rank needs: those in range of an own one, and partners of bonds and
/// links that hold.
class NearOwn {
 public:
  NearOwn(const State& state, const CellGrid& grid, const CellIndex& cells, double range)
      : state_(state),
        grid_(grid),
        cells_(cells),
        nearest_(state.box),
        range2_(range * range),
        partners_(partnersOf(state)) {}

  bool wants(const Candidate& c) const {
    if (partners_.at(c.row) >= 0) return true;
    // Candidates come cell by cell, so the neighbours are found once for many of them.
    if (const std::int64_t cell = grid_.cellOf(c.x); cell != lastCell_) {
      grid_.neighbours(cell, around_);
      lastCell_ = cell;
    }
    return std::ranges::any_of(around_, [&](std::int64_t cell) { return inReach(cell, c); });
  }

 private:
  static IndexMap partnersOf(const State& state) {
    std::int64_t lowest = std::numeric_limits<std::int64_t>::max(), highest = -1;
    for (int i = 0; i < state.owned(); ++i)
      for (const Tie& tie : state.ties(i))
        lowest = std::min(lowest, tie.row), highest = std::max(highest, tie.row);
    for (const Link& link : state.links)
      for (const std::int64_t row : link.row)
        lowest = std::min(lowest, row), highest = std::max(highest, row);
    IndexMap partners(static_cast<std::size_t>(state.owned()), lowest, highest);
    for (int i = 0; i < state.owned(); ++i)
      for (const Tie& tie : state.ties(i))
        if (state.holds(i, tie)) partners.insert(tie.row, i);
    for (const Link& link : state.links)
      for (const std::int64_t row : link.row)
        if (!link.broken) partners.insert(row, 0);
    return partners;
  }

  /// Is the candidate in range of an own segment in that cell?
  bool inReach(std::int64_t cell, const Candidate& c) const {
    const int place = cells_.rangeOf.at(cell);
    if (place < 0) return false;
    const auto& r = cells_.ranges[static_cast<std::size_t>(place)];
    for (int k = r.begin; k < r.end; ++k) {
      const int i = cells_.order[static_cast<std::size_t>(k)];
      const Vec3d d = nearest_(state_.position(i) - Vec3d{c.x[0], c.x[1], c.x[2]});
      if (dot(d, d) < range2_) return true;
    }
    return false;
  }

  const State& state_;
  const CellGrid& grid_;
  const CellIndex& cells_;
  MinimumImage nearest_;
  double range2_;
  IndexMap partners_;
  mutable std::int64_t lastCell_ = -1;
  mutable std::vector<std::int64_t> around_;  ///< neighbours of that cell
};

constexpr int sumsOfSegment = 8;

}  // namespace

Halo::Halo(MPI_Comm comm) {
  petsc(PetscSFCreate(comm, &sf_));
  for (std::size_t k = 0; k < units_.size(); ++k) {
    const Field& f = fields[k];
    // PETSc confuses a unit of one MPI_INT with MPI_INT itself, in which it counts ghosts.
    if (f.whole())
      MPI_Type_contiguous(static_cast<int>(f.bytes()), MPI_BYTE, &units_[k]);
    else
      MPI_Type_contiguous(f.components, MPI_DOUBLE, &units_[k]);
    MPI_Type_commit(&units_[k]);
  }
  MPI_Type_contiguous(sumsOfSegment, MPI_INT64_T, &sumUnit_);
  MPI_Type_commit(&sumUnit_);
}

Halo::~Halo() {
  PetscSFDestroy(&sf_);
  PetscSFDestroy(&along_);
  for (MPI_Datatype& unit : units_) MPI_Type_free(&unit);
  MPI_Type_free(&sumUnit_);
}

void Halo::build(State& state, const CellGrid& grid, double range) {
  const MPI_Comm comm = state.comm();
  if (state.ranks() == 1) return;
  const CellIndex cells(state, grid, state.owned());
  const auto notices = deliver(comm, noticesToOwners(grid, cells));
  const auto requests = deliver(comm, requestsToHolders(notices));
  const auto offers = deliver(comm, offersToWanters(state, cells, requests));
  const NearOwn near(state, grid, cells, range);
  std::vector<PetscSFNode> remote;
  for (const auto& [rank, items] : offers) {
    const std::size_t first = remote.size();
    for (const Candidate& c : items)
      if (near.wants(c)) remote.push_back({rank, c.local});
    // One block of leaves per rank, so that MPI receives straight into place.
    std::sort(remote.begin() + static_cast<std::ptrdiff_t>(first), remote.end(),
              [](const PetscSFNode& a, const PetscSFNode& b) { return a.index < b.index; });
  }
  // The candidates that were kept, the ghosts, are the leaves of the star forest.
  const int ghosts = static_cast<int>(remote.size()), owned = state.owned();
  petsc(PetscSFSetGraph(sf_, owned, ghosts, nullptr, PETSC_COPY_VALUES, remote.data(),
                        PETSC_COPY_VALUES));
  owner_.reset();
  requirePlaces(comm, std::int64_t{owned} + ghosts);
  state.addGhosts(ghosts);
  for (Broadcast* half : {PetscSFBcastBegin, PetscSFBcastEnd})
    for (const Ghosts which : {Ghosts::whenBuilt, Ghosts::everyStep}) broadcast(half, state, which);
  if (state.extras().friction) chooseAlong(state);
}

void Halo::chooseAlong(const State& state) {
  IndexMap wanted(2 * static_cast<std::size_t>(state.owned()));
  for (int i = 0; i < state.owned(); ++i)
    for (const Tie& tie : state.ties(i)) wanted.insert(tie.row, 0);
  std::vector<PetscInt> chosen;
  for (int k = 0; k < state.ghosts(); ++k)
    if (wanted.at(state.row[state.owned() + k]) >= 0) chosen.push_back(k);
  petsc(PetscSFDestroy(&along_));
  petsc(PetscSFCreateEmbeddedLeafSF(sf_, static_cast<PetscInt>(chosen.size()), chosen.data(),
                                    &along_));
}

void Halo::broadcast(Broadcast* half, State& state, Ghosts which) {
  if (state.ranks() == 1) return;
  for (std::size_t k = 0; k < units_.size(); ++k) {
    char* const values = fields[k].data(state);
    if (fields[k].ghosts != which || !values) continue;
    const std::size_t ownBytes = fields[k].bytes() * static_cast<std::size_t>(state.owned());
    petsc(half(which == Ghosts::alongFibres ? along_ : sf_, units_[k], values, values + ownBytes,
               MPI_REPLACE));
  }
}

void Halo::refreshBegin(State& state) {
  broadcast(PetscSFBcastBegin, state, Ghosts::everyStep);
}

void Halo::refreshEnd(State& state) {
  broadcast(PetscSFBcastEnd, state, Ghosts::everyStep);
}

void Halo::findOwners() {
  PetscInt owned;
  const PetscInt* ghosts;
  petsc(PetscSFGetGraph(sf_, &owned, nullptr, nullptr, nullptr));
  petsc(PetscSFComputeDegreeBegin(sf_, &ghosts));
  petsc(PetscSFComputeDegreeEnd(sf_, &ghosts));
  owner_.emplace();
  for (PetscInt i = 0; i < owned; ++i)
    owner_->insert(owner_->end(), static_cast<std::size_t>(ghosts[i]), i);
  arriving_.resize(sumsOfSegment * owner_->size());
}

void Halo::addGhostsBegin(const std::int64_t* ghosts) {
  if (!owner_) findOwners();
  petsc(PetscSFGatherBegin(sf_, sumUnit_, ghosts, arriving_.data()));
}

void Halo::addGhostsEnd(const std::int64_t* ghosts, std::int64_t* owned) {
  petsc(PetscSFGatherEnd(sf_, sumUnit_, ghosts, arriving_.data()));
  const std::int64_t* from = arriving_.data();
  for (const PetscInt i : *owner_)
    for (int c = 0; c < sumsOfSegment; ++c)
      owned[sumsOfSegment * static_cast<std::ptrdiff_t>(i) + c] += *from++;
}

void Halo::refreshVelocities(State& state) {
  broadcast(PetscSFBcastBegin, state, Ghosts::whenAsked);
  broadcast(PetscSFBcastEnd, state, Ghosts::whenAsked);
}

void Halo::refreshContacts(State& state) {
  broadcast(PetscSFBcastBegin, state, Ghosts::alongFibres);
  broadcast(PetscSFBcastEnd, state, Ghosts::alongFibres);
}

}  // namespace nanoweft
