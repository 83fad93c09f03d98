#include "nanoweft/state/state.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/huge_pages.hpp"

namespace nanoweft {

namespace {

struct Field {
  const char* name;
  PetscDataType type;
  int count;
};

// DMSwarm_pid is the id that every DMSwarm carries; it holds the row.
constexpr Field fields[] = {
    {"pose", PETSC_DOUBLE, 8},
    {"velocity", PETSC_DOUBLE, 3},
    {"angular_velocity", PETSC_DOUBLE, 3},
    {"force", PETSC_DOUBLE, 3},
    {"torque", PETSC_DOUBLE, 3},
    {"fibre", PETSC_INT64, 1},
    {"chain", PETSC_INT, 2},
    {"bond", PETSC_INT, 1},
    {"group", PETSC_INT, 1},
    {"image", PETSC_INT, 3},
};
constexpr Field gapField{"gap", PETSC_INT64, 4};
constexpr Field viscousField{"viscous", PETSC_DOUBLE, 6};
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

State::State(MPI_Comm comm, const Box& b, Extras extras) : box(b), comm_(comm), extras_(extras) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &ranks_);
  petsc(DMCreate(comm, &swarm_));
  petsc(DMSetType(swarm_, DMSWARM));
  petsc(DMSetDimension(swarm_, 3));
  // Never DMSWARM_PIC: its point location loses points on periodic DMDAs.
  petsc(DMSwarmSetType(swarm_, DMSWARM_BASIC));
  petsc(DMSwarmInitializeFieldRegister(swarm_));
  for (const Field& f : fields)
    petsc(DMSwarmRegisterPetscDatatypeField(swarm_, f.name, f.count, f.type));
  for (const auto& [wanted, f] :
       {std::pair{extras_.gap, gapField}, std::pair{extras_.viscous, viscousField}})
    if (wanted) petsc(DMSwarmRegisterPetscDatatypeField(swarm_, f.name, f.count, f.type));
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
  get(swarm_, "pose", pose);
  get(swarm_, "velocity", velocity);
  get(swarm_, "angular_velocity", angular);
  get(swarm_, "force", force);
  get(swarm_, "torque", torque);
  get(swarm_, DMSwarmField_pid, row);
  get(swarm_, "fibre", fibre);
  get(swarm_, "chain", chain);
  get(swarm_, "bond", bond);
  get(swarm_, "group", group);
  get(swarm_, "image", image);
  if (extras_.gap) get(swarm_, gapField.name, gap);
  if (extras_.viscous) get(swarm_, viscousField.name, viscous);
  acquired_ = true;
  if (pose == advised_) return;
  advised_ = pose;
  PetscInt count;
  petsc(DMSwarmGetLocalSize(swarm_, &count));
  const auto triples = 24 * static_cast<std::size_t>(count);
  preferHugePages(pose, 64 * static_cast<std::size_t>(count));
  for (double* field : {velocity, angular, force, torque}) preferHugePages(field, triples);
}

void State::release() {
  if (!acquired_) return;
  acquired_ = false;
  restore(swarm_, "pose", pose);
  restore(swarm_, "velocity", velocity);
  restore(swarm_, "angular_velocity", angular);
  restore(swarm_, "force", force);
  restore(swarm_, "torque", torque);
  restore(swarm_, DMSwarmField_pid, row);
  restore(swarm_, "fibre", fibre);
  restore(swarm_, "chain", chain);
  restore(swarm_, "bond", bond);
  restore(swarm_, "group", group);
  restore(swarm_, "image", image);
  if (extras_.gap) restore(swarm_, gapField.name, gap);
  if (extras_.viscous) restore(swarm_, viscousField.name, viscous);
}

void State::addOwned(int n) {
  release();
  // The buffer spares a reallocation of every field at each migration.
  petsc(DMSwarmSetLocalSizes(swarm_, owned_ + n, std::max(64, (owned_ + n) / 4)));
  acquire();
  const auto from = static_cast<std::size_t>(owned_);
  const auto count = static_cast<std::size_t>(n);
  std::fill_n(pose + 8 * from, 8 * count, 0.0);
  std::fill_n(velocity + 3 * from, 3 * count, 0.0);
  std::fill_n(angular + 3 * from, 3 * count, 0.0);
  std::fill_n(force + 3 * from, 3 * count, 0.0);
  std::fill_n(torque + 3 * from, 3 * count, 0.0);
  std::fill_n(row + from, count, 0);
  std::fill_n(fibre + from, count, 0);
  std::fill_n(chain + 2 * from, 2 * count, 0);
  std::fill_n(bond + from, count, 0);
  std::fill_n(group + from, count, 0);
  std::fill_n(image + 3 * from, 3 * count, 0);
  if (gap) std::fill_n(gap + 4 * from, 4 * count, 0);
  if (viscous) std::fill_n(viscous + 6 * from, 6 * count, 0.0);
  owned_ += n;
  for (auto i = from; i < from + count; ++i) pose[8 * i + 4] = 1.0;
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

void State::migrate(const std::vector<int>& destination) {
  release();
  PetscInt* rankField;
  get(swarm_, DMSwarmField_rank, rankField);
  std::copy(destination.begin(), destination.end(), rankField);
  restore(swarm_, DMSwarmField_rank, rankField);
  // Sent points are left in place and dropped below: removing them one by one inside PETSc clears
  // the whole buffer each time.
  petsc(DMSwarmMigrate(swarm_, PETSC_FALSE));
  PetscInt count;
  petsc(DMSwarmGetLocalSize(swarm_, &count));
  get(swarm_, DMSwarmField_rank, rankField);
  std::vector<int> keep;
  for (PetscInt i = 0; i < count; ++i)
    if (rankField[i] == rank_) keep.push_back(i);
  restore(swarm_, DMSwarmField_rank, rankField);
  acquire();
  permute(keep);
  release();
  owned_ = static_cast<int>(keep.size());
  petsc(DMSwarmSetLocalSizes(swarm_, owned_, std::max(64, owned_ / 4)));
  acquire();
  const std::int64_t before = total_;
  countTotal();
  if (total_ != before)
    throw RunError(format("migration changed the number of segments from %lld to %lld at step %lld",
                          static_cast<long long>(before), static_cast<long long>(total_),
                          static_cast<long long>(step)));
}

namespace {

/// Places first <= k < last of an order that has no other places there: the rest stays as it is.
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

/// Reorders values of a fixed size.
template <std::size_t bytes>
void reorder(void* data, const std::vector<int>& order, const std::vector<Stretch>& moved,
             std::vector<char>& copy) {
  char* const values = static_cast<char*>(data);
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
  reorder<64>(pose, order, moved, copy);
  for (double* field : {velocity, angular, force, torque}) reorder<24>(field, order, moved, copy);
  reorder<8>(row, order, moved, copy);
  reorder<8>(fibre, order, moved, copy);
  reorder<8>(chain, order, moved, copy);
  reorder<4>(bond, order, moved, copy);
  reorder<4>(group, order, moved, copy);
  reorder<12>(image, order, moved, copy);
  if (gap) reorder<32>(gap, order, moved, copy);
  if (viscous) reorder<48>(viscous, order, moved, copy);
}

}  // namespace nanoweft
