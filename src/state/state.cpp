#include "nanoweft/state/state.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/huge_pages.hpp"
#include "nanoweft/state/memory.hpp"

namespace nanoweft {

namespace {

static_assert(sizeof(PetscInt) == 4, "the int32 fields are registered as PetscInt");

template <class T>
void get(DM swarm, const char* name, T*& pointer) {
  void* data;
  petsc(DMSwarmGetField(swarm, name, nullptr, nullptr, &data));
  pointer = static_cast<T*>(data);
}

template <class T>
void restore(DM swarm, const char* name, T*& pointer) {
  void* data = pointer;
  petsc(DMSwarmRestoreField(swarm, name, nullptr, nullptr, &data));
  pointer = nullptr;
}

}  // namespace

State::State(MPI_Comm comm, const Box& b, ExtraFields extras)
    : box(b), comm_(comm), extras_(extras) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &ranks_);
  petsc(DMCreate(comm, &swarm_));
  petsc(DMSetType(swarm_, DMSWARM));
  petsc(DMSetDimension(swarm_, 3));
  // Never DMSWARM_PIC: its point location loses points on periodic DMDAs.
  petsc(DMSwarmSetType(swarm_, DMSWARM_BASIC));
  petsc(DMSwarmInitializeFieldRegister(swarm_));
  constexpr PetscDataType types[] = {PETSC_DOUBLE, PETSC_INT64, PETSC_INT};  // as in Field::member
  for (const Field& f : fields)
    if (f.in(extras) && f.name != DMSwarmField_pid)
      petsc(
          DMSwarmRegisterPetscDatatypeField(swarm_, f.name, f.components, types[f.member.index()]));
  petsc(DMSwarmFinalizeFieldRegister(swarm_));
  petsc(DMSwarmSetLocalSizes(swarm_, 0, 64));
  acquire();
}

State::~State() {
  // A destructor may run while an error unwinds: failures are ignored here.
  try {
    release();
  } catch (const PetscFailure&) {
  }
  DMDestroy(&swarm_);
}

void State::acquire() {
  for (const Field& f : fields)
    if (f.in(extras_)) f.visit(*this, [&](auto*& values) { get(swarm_, f.name, values); });
  acquired_ = true;
  if (pose == advised_) return;
  advised_ = pose;
  PetscInt count;
  petsc(DMSwarmGetLocalSize(swarm_, &count));
  for (const Field& f : fields)
    if (f.in(extras_) && !f.whole())
      preferHugePages(f.data(*this), f.bytes() * static_cast<std::size_t>(count));
}

void State::release() {
  if (!acquired_) return;
  acquired_ = false;
  for (const Field& f : fields)
    if (f.in(extras_)) f.visit(*this, [&](auto*& values) { restore(swarm_, f.name, values); });
}

int State::bufferFor(int n) const {
  // PETSc writes to the whole buffer, so it takes memory even while nothing is in it.
  return ranks_ > 1 ? std::max(64, n / 4) : 0;
}

void State::addOwned(int n) {
  release();
  petsc(DMSwarmSetLocalSizes(swarm_, owned_ + n, bufferFor(owned_ + n)));
  acquire();
  const auto begin = static_cast<std::size_t>(owned_), end = static_cast<std::size_t>(owned_ + n);
  for (const Field& f : fields)
    f.visit(*this, [&]<class T>(T* values) {
      const auto components = static_cast<std::size_t>(f.components);
      for (std::size_t k = components * begin; values && k < components * end; ++k)
        values[k] = static_cast<T>(f.freshAt(k % components));
    });
  owned_ += n;
}

void State::addGhosts(int n) {
  if (n == 0) return;
  release();
  petsc(DMSwarmAddNPoints(swarm_, n));
  acquire();
  ghosts_ += n;
}

void State::dropGhosts() {
  if (ghosts_ == 0) return;
  release();
  petsc(DMSwarmSetLocalSizes(swarm_, owned_, -1));
  acquire();
  ghosts_ = 0;
}

void State::countTotal() {
  const std::int64_t mine = owned_;
  MPI_Allreduce(&mine, &total_, 1, MPI_INT64_T, MPI_SUM, comm_);
}

void State::migrate(const std::vector<int>& destination, std::int64_t mostBytes) {
  // PETSc counts the bytes between two ranks in an int, so what exceeds that waits for another
  // time.
  const std::int64_t most = std::max<std::int64_t>(1, mostBytes / bytesOfSegment());
  std::vector<int> goal = destination;
  const std::int64_t before = total_;
  std::int64_t waiting;
  do {
    waiting = moveSome(goal, most);
    MPI_Allreduce(MPI_IN_PLACE, &waiting, 1, MPI_INT64_T, MPI_SUM, comm_);
  } while (waiting > 0);
  countTotal();
  if (total_ != before)
    throw RunError(format("migration changed the number of segments from %lld to %lld at step %lld",
                          static_cast<long long>(before), static_cast<long long>(total_),
                          static_cast<long long>(step)));
}

std::int64_t State::bytesOfSegment() const {
  std::int64_t bytes = sizeof(double) * 4 + sizeof(PetscInt);  // what DMSwarm has of its own
  for (const Field& f : fields)
    if (f.in(extras_)) bytes += static_cast<std::int64_t>(f.bytes());
  return bytes;
}

double State::memoryOfSegment() const {
  double bytes = stateBytes;
  for (const Field& f : fields)
    if (f.extra && f.in(extras_)) bytes += static_cast<double>(f.bytes());
  return bytes;
}

std::int64_t State::moveSome(std::vector<int>& goal, std::int64_t most) {
  release();
  PetscInt* rankField;
  get(swarm_, DMSwarmField_rank, rankField);
  std::map<int, std::int64_t> sent;
  std::int64_t waiting = 0;
  for (std::size_t i = 0; i < goal.size(); ++i) {
    const bool waits = goal[i] != rank_ && ++sent[goal[i]] > most;
    waiting += waits;
    rankField[i] = waits ? rank_ : goal[i];
  }
  restore(swarm_, DMSwarmField_rank, rankField);
  // Sent points are left in place and dropped below: removing them one by one inside PETSc clears
  // the whole buffer each time.
  petsc(DMSwarmMigrate(swarm_, PETSC_FALSE));
  PetscInt count;
  petsc(DMSwarmGetLocalSize(swarm_, &count));
  get(swarm_, DMSwarmField_rank, rankField);
  std::vector<int> keep, left;
  for (PetscInt i = 0; i < count; ++i)
    if (rankField[i] == rank_) {
      keep.push_back(i);
      left.push_back(static_cast<std::size_t>(i) < goal.size() ? goal[static_cast<std::size_t>(i)]
                                                               : rank_);
    }
  goal = std::move(left);
  restore(swarm_, DMSwarmField_rank, rankField);
  acquire();
  permute(keep);
  release();
  owned_ = static_cast<int>(keep.size());
  petsc(DMSwarmSetLocalSizes(swarm_, owned_, bufferFor(owned_)));
  acquire();
  return waiting;
}

namespace {

/// Places first <= k < last that an order permutes among themselves. Places outside all such
/// stretches keep their segments.
struct Stretch {
  std::size_t first, last;
};

std::vector<Stretch> movedStretches(const std::vector<int>& order) {
  std::vector<Stretch> moved;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (order[k] == static_cast<int>(k)) continue;
    const std::size_t first = k;
    auto farthest = static_cast<std::size_t>(order[k]);
    while (k < farthest && k + 1 < order.size())
      farthest = std::max(farthest, static_cast<std::size_t>(order[++k]));
    moved.push_back({first, k + 1});
  }
  return moved;
}

/// Reorders values of a fixed size; `values` is null for a field that the state does not have.
template <std::size_t bytes>
void reorder(char* values, const std::vector<int>& order, const std::vector<Stretch>& moved,
             std::vector<char>& copy) {
  if (!values) return;
  for (const Stretch& s : moved) {
    copy.resize((s.last - s.first) * bytes);
    for (std::size_t k = s.first; k < s.last; ++k)
      std::memcpy(&copy[(k - s.first) * bytes], values + static_cast<std::size_t>(order[k]) * bytes,
                  bytes);
    std::memcpy(values + s.first * bytes, copy.data(), copy.size());
  }
}

}  // namespace

void State::permute(const std::vector<int>& order) {
  const auto moved = movedStretches(order);
  std::vector<char> copy;
  [&]<std::size_t... k>(std::index_sequence<k...>) {
    (reorder<fields[k].bytes()>(fields[k].data(*this), order, moved, copy), ...);
  }
  (std::make_index_sequence<std::size(fields)>());
}

namespace {

/// All bits that may stand in `ends`, whatever a file says.
constexpr int both = freePrevious | freeNext;

}  // namespace

void State::noteFreeEnds() {
  for (int i = 0; i < owned_; ++i) {
    int bits = both;
    for (const Tie& tie : ties(i))
      if (!tie.broken) bits &= ~(tie.first ? freeNext : freePrevious);
    pose[8 * i + 3] = kind(i) + 0.25 * bits + 0.0625 * (ends[i] & both);
    ends[i] = bits;
  }
}

void State::recallFreeEnds() {
  for (int i = 0; i < owned_; ++i) pose[8 * i + 3] = kind(i) + 0.3125 * (ends[i] & both);
}

}  // namespace nanoweft
