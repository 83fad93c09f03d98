#include "nanoweft/state/state_file.hpp"

#include <fcntl.h>
#include <petscsf.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"

namespace nanoweft {

namespace {

constexpr const char* formatName = "nanoweft-state";
constexpr std::int64_t formatVersion = 1;
// Fixed, so that a file does not depend on the number of ranks.
constexpr hsize_t chunkRows = 16384;

/// The rows that a rank reads or writes.
struct Block {
  std::int64_t begin, count;
  Block(std::int64_t total, int rank, int ranks) {
    begin = total * rank / ranks;
    count = total * (rank + 1) / ranks - begin;
  }
};

hid_t parallelAccess(MPI_Comm comm) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL);
  H5Pset_all_coll_metadata_ops(access, true);
  return access;
}

/// Reads this rank's rows of a dataset; leaves `values` empty when it is missing. Returns a
/// problem.
template <class T>
std::string readRows(hid_t group, const char* name, hid_t memoryType, const Block& block,
                     int columns, std::vector<T>& values) {
  if (H5Lexists(group, name, H5P_DEFAULT) <= 0) return "";
  h5::Handle set(H5Dopen2(group, name, H5P_DEFAULT), H5Dclose);
  h5::Handle space(H5Dget_space(set), H5Sclose);
  const hsize_t start[2] = {static_cast<hsize_t>(block.begin), 0};
  const hsize_t count[2] = {static_cast<hsize_t>(block.count), static_cast<hsize_t>(columns)};
  values.resize(static_cast<std::size_t>(block.count * columns));
  if (block.count == 0) return "";
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
  h5::Handle memory(H5Screate_simple(2, count, nullptr), H5Sclose);
  // Independent transfers: a rank that meets a damaged chunk must not leave the others waiting.
  if (H5Dread(set, memoryType, memory, space, H5P_DEFAULT, values.data()) < 0)
    return std::string("/state/") + name + " cannot be read (" + h5::lastError() + ")";
  return "";
}

template <class T>
bool allFinite(const std::vector<T>& values, std::size_t& where) {
  for (where = 0; where < values.size(); ++where)
    if (!std::isfinite(values[where])) return false;
  return true;
}

/// First row of the fibre that holds each of this rank's rows, and that fibre's number of segments.
/// A fibre may span the blocks of several ranks.
struct Chains {
  std::vector<std::int64_t> start, length;
};

Chains findChains(MPI_Comm comm, int rank, int ranks, std::int64_t total, const Block& block,
                  const std::vector<std::int64_t>& index) {
  // Every rank's first and last row where a fibre starts (index 0), or -1: two numbers a rank.
  std::int64_t mine[2] = {-1, -1};
  for (std::int64_t k = 0; k < block.count; ++k)
    if (index[static_cast<std::size_t>(k)] == 0) {
      if (mine[0] < 0) mine[0] = block.begin + k;
      mine[1] = block.begin + k;
    }
  std::vector<std::int64_t> all(2 * static_cast<std::size_t>(ranks));
  MPI_Allgather(mine, 2, MPI_INT64_T, all.data(), 2, MPI_INT64_T, comm);
  std::int64_t before = 0, after = total;
  for (int r = 0; r < rank; ++r)
    if (all[2 * static_cast<std::size_t>(r) + 1] >= 0)
      before = all[2 * static_cast<std::size_t>(r) + 1];
  for (int r = ranks - 1; r > rank; --r)
    if (all[2 * static_cast<std::size_t>(r)] >= 0) after = all[2 * static_cast<std::size_t>(r)];
  Chains chains;
  const auto n = static_cast<std::size_t>(block.count);
  chains.start.resize(n);
  chains.length.resize(n);
  std::int64_t start = before;
  for (std::size_t k = 0; k < n; ++k) {
    if (index[k] == 0) start = block.begin + static_cast<std::int64_t>(k);
    chains.start[k] = start;
  }
  std::int64_t end = after;
  for (std::size_t k = n; k-- > 0;) {
    chains.length[k] = end - chains.start[k];
    if (index[k] == 0) end = block.begin + static_cast<std::int64_t>(k);
  }
  return chains;
}

}  // namespace

std::string stateFileProblem(const std::string& file) {
  const std::string what = "state file " + file + " cannot be used: ";
  std::error_code code;
  if (!std::filesystem::exists(file, code)) return what + "it does not exist";
  if (std::filesystem::is_directory(file, code)) return what + "it is a folder";
  h5::silence();
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!f.valid()) return what + "not a readable HDF5 file (" + h5::lastError() + ")";
  if (H5Lexists(f, "state", H5P_DEFAULT) <= 0) return what + "it has no group /state";
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  if (!group.valid()) return what + "/state is not a group";
  const auto name = h5::readText(group, "format");
  if (!name || *name != formatName)
    return what + "the attribute format of /state is not '" + formatName + "'";
  const auto version = h5::readIntegers(group, "version");
  if (!version || version->size() != 1 || (*version)[0] != formatVersion)
    return what + "its version is not 1";
  const auto units = h5::readText(group, "units");
  if (!units || (*units != "nano" && *units != "si"))
    return what + "the attribute units must be 'nano' or 'si'";
  for (const char* corner : {"lower", "upper"}) {
    const auto values = h5::readReals(group, corner);
    if (!values || values->size() != 3 ||
        !std::ranges::all_of(*values, [](double x) { return std::isfinite(x); }))
      return what + "the attribute " + corner + " must be three finite numbers";
  }
  const auto lower = *h5::readReals(group, "lower"), upper = *h5::readReals(group, "upper");
  for (std::size_t d = 0; d < 3; ++d)
    if (!(lower[d] < upper[d])) return what + "the box has no extent (attributes lower and upper)";
  if (const auto step = h5::readIntegers(group, "step");
      step && (step->size() != 1 || (*step)[0] < 0))
    return what + "the attribute step must be a whole number, not negative";
  if (const auto time = h5::readReals(group, "time");
      time && (time->size() != 1 || !std::isfinite((*time)[0])))
    return what + "the attribute time must be a finite number";
  const auto periodic = h5::readIntegers(group, "periodic");
  if (!periodic || periodic->size() != 3)
    return what + "the attribute periodic must be three integers";

  hsize_t rows = 0;
  struct Expected {
    const char* name;
    int columns;
    bool required;
  };
  constexpr Expected datasets[] = {
      {"position", 3, true},
      {"orientation", 4, true},
      {"fibre", 1, true},
      {"index", 1, true},
      {"image", 3, false},
      {"velocity", 3, false},
      {"angular_velocity", 3, false},
      {"group", 1, false},
      {"bond_broken", 1, false},
      {"gap", 4, false},
      {"viscous", 6, false},
  };
  for (const Expected& e : datasets) {
    if (H5Lexists(group, e.name, H5P_DEFAULT) <= 0) {
      if (e.required) return what + "/state/" + e.name + " is missing";
      continue;
    }
    h5::Handle set(H5Dopen2(group, e.name, H5P_DEFAULT), H5Dclose);
    if (!set.valid()) return what + "/state/" + e.name + " is not a dataset";
    h5::Handle space(H5Dget_space(set), H5Sclose);
    hsize_t shape[8] = {0, 1};
    const int dimensions = H5Sget_simple_extent_ndims(space);
    if (dimensions >= 1 && dimensions <= 8) H5Sget_simple_extent_dims(space, shape, nullptr);
    const bool right = e.columns == 1
                           ? dimensions == 1
                           : dimensions == 2 && shape[1] == static_cast<hsize_t>(e.columns);
    if (rows == 0) rows = shape[0];
    if (!right || shape[0] != rows || rows == 0)
      return what + format("/state/%s must have the shape [N%s] with the same N > 0 as position",
                           e.name, e.columns == 1 ? "" : format(", %d", e.columns).c_str());
  }
  if (rows > 2147483647u) return what + "more than 2^31 - 1 segments";
  return "";
}

StateHeader readStateHeader(MPI_Comm comm, const std::string& file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  agree<InputError>(comm, rank == 0 ? stateFileProblem(file) : "");
  h5::silence();
  // Small and read-only: every rank reads it by itself.
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  StateHeader header;
  const auto lower = *h5::readReals(group, "lower"), upper = *h5::readReals(group, "upper");
  const auto periodic = *h5::readIntegers(group, "periodic");
  for (int d = 0; d < 3; ++d) {
    header.box.lower[d] = lower[d];
    header.box.upper[d] = upper[d];
    header.box.periodic[d] = periodic[d] != 0;
  }
  header.units = *h5::readText(group, "units");
  if (auto step = h5::readIntegers(group, "step"); step && !step->empty()) header.step = (*step)[0];
  if (auto time = h5::readReals(group, "time"); time && !time->empty()) header.time = (*time)[0];
  h5::Handle position(H5Dopen2(group, "position", H5P_DEFAULT), H5Dclose);
  h5::Handle space(H5Dget_space(position), H5Sclose);
  hsize_t shape[2];
  H5Sget_simple_extent_dims(space, shape, nullptr);
  header.rows = static_cast<std::int64_t>(shape[0]);
  int ranks;
  MPI_Comm_size(comm, &ranks);
  std::vector<std::int8_t> broken;
  const std::string problem =
      readRows(group, "bond_broken", H5T_NATIVE_INT8, Block(header.rows, rank, ranks), 1, broken);
  agree<InputError>(comm,
                    problem.empty() ? "" : "state file " + file + " cannot be used: " + problem);
  int any = std::ranges::any_of(broken, [](std::int8_t b) { return b != 0; });
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, comm);
  header.anyBroken = any != 0;
  if (H5Lexists(f, "run", H5P_DEFAULT) > 0) {
    h5::Handle run(H5Gopen2(f, "run", H5P_DEFAULT), H5Gclose);
    auto visit = [](hid_t object, const char* name, const H5A_info_t*, void* out) -> herr_t {
      auto& record = *static_cast<RunRecord*>(out);
      h5::Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
      h5::Handle type(H5Aget_type(attribute), H5Tclose);
      if (H5Tget_class(type) == H5T_FLOAT)
        record.reals[name] = *h5::readReals(object, name);
      else if (H5Tget_class(type) == H5T_INTEGER)
        record.integers[name] = *h5::readIntegers(object, name);
      return 0;
    };
    H5Aiterate2(run, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &header.run);
  }
  return header;
}

void readStateRows(const std::string& file, const StateHeader& header, State& state) {
  const MPI_Comm comm = state.comm();
  const Block block(header.rows, state.rank(), state.ranks());
  std::vector<double> position, orientation, velocity, angular, viscous;
  std::vector<std::int64_t> fibre, index, gap, closed;
  std::vector<std::int32_t> image, group;
  std::vector<std::int8_t> broken;
  std::string problem;
  {
    h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    h5::Handle g(f.valid() ? H5Gopen2(f, "state", H5P_DEFAULT) : -1, H5Gclose);
    if (!g.valid()) problem = "it cannot be opened on every rank";
    auto read = [&](const char* name, hid_t type, int columns, auto& values) {
      if (problem.empty()) problem = readRows(g, name, type, block, columns, values);
    };
    read("position", H5T_NATIVE_DOUBLE, 3, position);
    read("orientation", H5T_NATIVE_DOUBLE, 4, orientation);
    read("fibre", H5T_NATIVE_INT64, 1, fibre);
    read("index", H5T_NATIVE_INT64, 1, index);
    read("image", H5T_NATIVE_INT32, 3, image);
    read("velocity", H5T_NATIVE_DOUBLE, 3, velocity);
    read("angular_velocity", H5T_NATIVE_DOUBLE, 3, angular);
    read("group", H5T_NATIVE_INT32, 1, group);
    read("bond_broken", H5T_NATIVE_INT8, 1, broken);
    read("gap", H5T_NATIVE_INT64, 4, gap);
    read("viscous", H5T_NATIVE_DOUBLE, 6, viscous);
    if (problem.empty() && H5Lexists(g, "fibre_closed", H5P_DEFAULT) > 0) {
      h5::Handle set(H5Dopen2(g, "fibre_closed", H5P_DEFAULT), H5Dclose);
      h5::Handle space(H5Dget_space(set), H5Sclose);
      const hssize_t count = H5Sget_simple_extent_npoints(space);
      closed.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
      if (count > 0 &&
          H5Dread(set, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, closed.data()) < 0)
        problem = "/state/fibre_closed cannot be read";
      std::ranges::sort(closed);
    }
  }
  const std::string what = "state file " + file + " cannot be used: ";
  agree<InputError>(comm, problem.empty() ? "" : what + problem);

  const auto n = static_cast<std::size_t>(block.count);
  auto rowName = [&](std::size_t k) {
    return format("row %lld (fibre %lld, index %lld)",
                  static_cast<long long>(block.begin + static_cast<std::int64_t>(k)),
                  static_cast<long long>(fibre[k]), static_cast<long long>(index[k]));
  };
  // The last (fibre, index) of the rank before, to check the order across blocks.
  std::int64_t last[2] = {0, -1}, previous[2] = {0, -1};
  if (n > 0) last[0] = fibre[n - 1], last[1] = index[n - 1];
  std::vector<std::int64_t> lasts(2 * static_cast<std::size_t>(state.ranks()));
  MPI_Allgather(last, 2, MPI_INT64_T, lasts.data(), 2, MPI_INT64_T, comm);
  for (int r = 0; r < state.rank(); ++r)
    if (const auto k = 2 * static_cast<std::size_t>(r); lasts[k + 1] >= 0)
      previous[0] = lasts[k], previous[1] = lasts[k + 1];
  std::size_t at;
  for (std::size_t k = 0; k < n && problem.empty(); ++k) {
    const bool continues =
        previous[1] >= 0 && fibre[k] == previous[0] && index[k] == previous[1] + 1;
    const bool starts = index[k] == 0 && (previous[1] < 0 || fibre[k] > previous[0]);
    if (!continues && !starts)
      problem = rowName(k) +
                ": rows must be ordered by fibre, and index must count 0, 1, 2, ... along each";
    previous[0] = fibre[k], previous[1] = index[k];
    const double* q = &orientation[4 * k];
    const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (problem.empty() && !(std::abs(norm2 - 1.0) < 2e-3))
      problem = rowName(k) +
                format(": its orientation is not a unit quaternion (norm %g)", std::sqrt(norm2));
  }
  auto checkFinite = [&](const std::vector<double>& values, std::size_t columns, const char* name) {
    if (problem.empty() && !allFinite(values, at))
      problem = rowName(at / columns) + ": its " + name + " is not a finite number";
  };
  checkFinite(position, 3, "position");
  checkFinite(velocity, 3, "velocity");
  checkFinite(angular, 3, "angular_velocity");
  agree<InputError>(comm, problem.empty() ? "" : what + problem);

  // Every closed fibre must be there.
  std::vector<int> found(closed.size(), 0);
  for (std::size_t k = 0; k < n; ++k)
    if (const auto at = std::ranges::lower_bound(closed, fibre[k]);
        at != closed.end() && *at == fibre[k])
      found[static_cast<std::size_t>(at - closed.begin())] = 1;
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_INT, MPI_MAX, comm);
  for (std::size_t k = 0; k < found.size(); ++k)
    if (!found[k])
      throw InputError(what + format("fibre_closed names the fibre %lld, which it does not have",
                                     static_cast<long long>(closed[k])));

  const Chains chains = findChains(comm, state.rank(), state.ranks(), header.rows, block, index);
  for (std::size_t k = 0; k < n && problem.empty(); ++k)
    if (chains.length[k] < 3 && std::ranges::binary_search(closed, fibre[k]))
      problem =
          format("fibre_closed names the fibre %lld of %lld segments; a closed fibre needs three",
                 static_cast<long long>(fibre[k]), static_cast<long long>(chains.length[k]));
  agree<InputError>(comm, problem.empty() ? "" : what + problem);
  state.addOwned(static_cast<int>(n));
  for (std::size_t k = 0; k < n; ++k) {
    const int i = static_cast<int>(k);
    state.row[k] = block.begin + i;
    state.fibre[k] = fibre[k];
    state.chain[2 * k] = static_cast<std::int32_t>(index[k]);
    state.chain[2 * k + 1] = static_cast<std::int32_t>(chains.length[k]);
    std::copy_n(&position[3 * k], 3, state.pose + 8 * k);
    const double* q = &orientation[4 * k];
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    // Our own states come back with their bits; only foreign ones need normalising.
    const double scale = std::abs(norm - 1.0) < 1e-12 ? 1.0 : 1.0 / norm;
    state.setOrientation(i, {scale * q[0], scale * q[1], scale * q[2], scale * q[3]});
    if (!velocity.empty()) std::copy_n(&velocity[3 * k], 3, state.velocity + 3 * k);
    if (!angular.empty()) std::copy_n(&angular[3 * k], 3, state.angular + 3 * k);
    if (!viscous.empty() && state.viscous) std::copy_n(&viscous[6 * k], 6, state.viscous + 6 * k);
    if (!image.empty()) std::copy_n(&image[3 * k], 3, state.image + 3 * k);
    if (!group.empty()) state.group[k] = group[k];
    if (!gap.empty() && state.gap) std::copy_n(&gap[4 * k], 4, state.gap + 4 * k);
    if (std::ranges::binary_search(closed, fibre[k])) state.bond[k] |= fibreClosed;
    if (!broken.empty() && broken[k]) state.bond[k] |= nextBroken;
    state.box.wrap(state.pose + 8 * k, state.image + 3 * k);
  }
  state.countTotal();
  state.step = header.step;
  state.time = header.time;
}

namespace {

/// Sends rows from where they live to the ranks that write them.
class RowOrder {
 public:
  RowOrder(const State& state, const Block& block) : block_(block) {
    PetscLayout layout;
    petsc(PetscLayoutCreate(state.comm(), &layout));
    petsc(PetscLayoutSetLocalSize(layout, static_cast<PetscInt>(block.count)));
    petsc(PetscLayoutSetUp(layout));
    std::vector<PetscInt> rows(state.row, state.row + state.owned());
    petsc(PetscSFCreate(state.comm(), &sf_));
    petsc(
        PetscSFSetGraphLayout(sf_, layout, state.owned(), nullptr, PETSC_COPY_VALUES, rows.data()));
    petsc(PetscSFSetUp(sf_));
    petsc(PetscLayoutDestroy(&layout));
  }
  ~RowOrder() { PetscSFDestroy(&sf_); }
  RowOrder(const RowOrder&) = delete;
  RowOrder& operator=(const RowOrder&) = delete;

  template <class T>
  std::vector<T> operator()(const T* values, int columns) const {
    static_assert(sizeof(T) % 4 == 0);
    MPI_Datatype unit;
    MPI_Type_contiguous(columns * static_cast<int>(sizeof(T) / 4), MPI_INT, &unit);
    MPI_Type_commit(&unit);
    std::vector<T> ordered(static_cast<std::size_t>(block_.count * columns));
    petsc(PetscSFReduceBegin(sf_, unit, values, ordered.data(), MPI_REPLACE));
    petsc(PetscSFReduceEnd(sf_, unit, values, ordered.data(), MPI_REPLACE));
    MPI_Type_free(&unit);
    return ordered;
  }

 private:
  PetscSF sf_ = nullptr;
  Block block_;
};

/// Writes one dataset, each rank its block of rows; false on failure.
template <class T>
bool writeRows(hid_t group, const char* name, hid_t stored, hid_t memoryType, std::int64_t total,
               std::int64_t begin, std::int64_t count, int columns, bool matrix,
               const std::vector<T>& values) {
  const hsize_t shape[2] = {static_cast<hsize_t>(total), static_cast<hsize_t>(columns)};
  const int dimensions = matrix ? 2 : 1;
  h5::Handle space(H5Screate_simple(dimensions, shape, nullptr), H5Sclose);
  h5::Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  if (total > 0) {
    const hsize_t chunk[2] = {std::min(shape[0], chunkRows), shape[1]};
    H5Pset_chunk(creation, dimensions, chunk);
    H5Pset_fletcher32(creation);
  }
  h5::Handle set(H5Dcreate2(group, name, stored, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                 H5Dclose);
  if (!set.valid()) return false;
  if (total == 0) return true;
  const hsize_t start[2] = {static_cast<hsize_t>(begin), 0};
  const hsize_t extent[2] = {static_cast<hsize_t>(count), static_cast<hsize_t>(columns)};
  h5::Handle memory(H5Screate_simple(dimensions, extent, nullptr), H5Sclose);
  if (count > 0) {
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, extent, nullptr);
  } else {
    H5Sselect_none(space);
    H5Sselect_none(memory);
  }
  h5::Handle transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  // Filtered chunks demand collective transfers, and those that stored and memory type be the same.
  H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  return H5Dwrite(set, memoryType, memory, space, transfer, values.data()) >= 0;
}

/// Makes the complete file visible under its name, on rank 0: data and directory reach the disk.
std::string publish(const std::string& temporary, const std::string& file) {
  const int fd = ::open(temporary.c_str(), O_RDONLY);
  if (fd < 0 || ::fsync(fd) != 0) {
    if (fd >= 0) ::close(fd);
    return format("cannot sync %s: %s", temporary.c_str(), std::strerror(errno));
  }
  ::close(fd);
  if (std::rename(temporary.c_str(), file.c_str()) != 0)
    return format("cannot rename %s to %s: %s", temporary.c_str(), file.c_str(),
                  std::strerror(errno));
  const auto folder = std::filesystem::path(file).parent_path();
  const int dir = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (dir >= 0) {
    ::fsync(dir);
    ::close(dir);
  }
  return "";
}

}  // namespace

void writeState(const std::string& name, State& state, const UnitSystem& units,
                const RunRecord& run, const StateWriteOptions& what) {
  // A link stays one: its target is replaced.
  std::error_code code;
  const auto target = std::filesystem::canonical(name, code);
  const std::string file = !code && std::filesystem::is_symlink(name) ? target.string() : name;
  const Block block(state.total(), state.rank(), state.ranks());
  const RowOrder ordered(state, block);
  const int n = state.owned();
  const std::string temporary = file + ".tmp";
  h5::silence();
  bool good = true;
  {
    h5::Handle access(parallelAccess(state.comm()), H5Pclose);
    h5::Handle f(H5Fcreate(temporary.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
    agree<RunError>(state.comm(), f.valid() ? "" : "cannot create " + temporary);
    h5::Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    h5::Handle group(H5Gcreate2(f, "state", H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
    h5::writeAttribute(group, "format", formatName);
    h5::writeScalar(group, "version", formatVersion);
    h5::writeScalar(group, "step", state.step);
    h5::writeScalar(group, "time", state.time);
    h5::writeAttribute(group, "units", units.name);
    h5::writeAttribute(group, "lower",
                       std::vector<double>(state.box.lower.begin(), state.box.lower.end()));
    h5::writeAttribute(group, "upper",
                       std::vector<double>(state.box.upper.begin(), state.box.upper.end()));
    h5::writeAttribute(
        group, "periodic",
        std::vector<std::int64_t>(state.box.periodic.begin(), state.box.periodic.end()));

    std::vector<double> position(3 * static_cast<std::size_t>(n)),
        orientation(4 * static_cast<std::size_t>(n));
    std::vector<std::int64_t> index(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      std::copy_n(state.pose + 8 * k, 3, &position[3 * k]);
      std::copy_n(state.pose + 8 * k + 4, 4, &orientation[4 * k]);
      index[k] = state.chain[2 * k];
    }
    auto write = [&](const char* name, hid_t stored, hid_t memory, const auto& rows, int columns) {
      good = writeRows(group, name, stored, memory, state.total(), block.begin, block.count,
                       columns, columns > 1, rows) &&
             good;
    };
    const auto orderedPosition = ordered(position.data(), 3);
    const auto orderedImage = ordered(state.image, 3);
    const auto orderedBond = ordered(state.bond, 1);
    const auto orderedFibre = ordered(state.fibre, 1);
    const auto orderedChain = ordered(state.chain, 2);
    write("position", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, orderedPosition, 3);
    write("image", H5T_STD_I32LE, H5T_NATIVE_INT32, orderedImage, 3);
    write("orientation", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, ordered(orientation.data(), 4), 4);
    write("fibre", H5T_STD_I64LE, H5T_NATIVE_INT64, orderedFibre, 1);
    write("index", H5T_STD_I64LE, H5T_NATIVE_INT64, ordered(index.data(), 1), 1);
    write("velocity", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, ordered(state.velocity, 3), 3);
    write("angular_velocity", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, ordered(state.angular, 3), 3);
    write("group", H5T_STD_I32LE, H5T_NATIVE_INT32, ordered(state.group, 1), 1);
    std::vector<std::int8_t> broken(orderedBond.size());
    std::vector<std::int64_t> closed;
    for (std::size_t k = 0; k < orderedBond.size(); ++k) {
      broken[k] = (orderedBond[k] & nextBroken) != 0;
      if ((orderedBond[k] & fibreClosed) && orderedChain[2 * k] == 0)
        closed.push_back(orderedFibre[k]);
    }
    write("bond_broken", H5T_STD_I8LE, H5T_NATIVE_INT8, broken, 1);
    std::int64_t mine = static_cast<std::int64_t>(closed.size()), offset = 0, count = 0;
    MPI_Exscan(&mine, &offset, 1, MPI_INT64_T, MPI_SUM, state.comm());
    if (state.rank() == 0) offset = 0;
    MPI_Allreduce(&mine, &count, 1, MPI_INT64_T, MPI_SUM, state.comm());
    if (count > 0)
      good = writeRows(group, "fibre_closed", H5T_STD_I64LE, H5T_NATIVE_INT64, count, offset, mine,
                       1, false, closed) &&
             good;
    if (what.forces) {
      write("force", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, ordered(state.force, 3), 3);
      write("torque", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, ordered(state.torque, 3), 3);
    }
    if (state.gap) write("gap", H5T_STD_I64LE, H5T_NATIVE_INT64, ordered(state.gap, 4), 4);
    if (state.viscous)
      write("viscous", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, ordered(state.viscous, 6), 6);

    if (!run.reals.empty() || !run.integers.empty()) {
      h5::Handle record(H5Gcreate2(f, "run", H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
      for (const auto& [name, values] : run.reals) h5::writeAttribute(record, name.c_str(), values);
      for (const auto& [name, values] : run.integers)
        h5::writeAttribute(record, name.c_str(), values);
    }

    if (!what.fields.empty()) {
      h5::Handle fields(H5Gcreate2(f, "field", H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
      for (const SegmentField& field : what.fields)
        good = writeRows(fields, field.name, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, state.total(),
                         block.begin, block.count, 1, false, ordered(field.values.data(), 1)) &&
               good;
    }

    if (what.mesh) {
      h5::Handle mesh(H5Gcreate2(f, "mesh", H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
      const auto rows = static_cast<std::size_t>(block.count);
      std::vector<float> points(3 * rows);
      for (std::size_t k = 0; k < 3 * rows; ++k) {
        const int d = static_cast<int>(k % 3);
        points[k] = static_cast<float>(orderedPosition[k] + orderedImage[k] * state.box.length(d));
      }
      std::vector<std::int32_t> lines;
      for (std::size_t k = 0; k < rows; ++k) {
        // Bonds that close a ring through the periodic boundary would be drawn across the box, so
        // a line joins neighbours along the fibre only.
        if (broken[k] || orderedChain[2 * k] + 1 >= orderedChain[2 * k + 1]) continue;
        const auto first = static_cast<std::int32_t>(block.begin + static_cast<std::int64_t>(k));
        lines.insert(lines.end(), {first, first + 1});
      }
      std::int64_t own = static_cast<std::int64_t>(lines.size() / 2), lineOffset = 0, lineTotal = 0;
      MPI_Exscan(&own, &lineOffset, 1, MPI_INT64_T, MPI_SUM, state.comm());
      if (state.rank() == 0) lineOffset = 0;
      MPI_Allreduce(&own, &lineTotal, 1, MPI_INT64_T, MPI_SUM, state.comm());
      good = writeRows(mesh, "points", H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, state.total(), block.begin,
                       block.count, 3, true, points) &&
             good;
      good = writeRows(mesh, "lines", H5T_STD_I32LE, H5T_NATIVE_INT32, lineTotal, lineOffset, own,
                       2, true, lines) &&
             good;
    }
    good = H5Fflush(f, H5F_SCOPE_GLOBAL) >= 0 && good;
  }
  std::string problem;
  if (!good) problem = "cannot write " + temporary + " (" + h5::lastError() + ")";
  agree<RunError>(state.comm(), problem);
  agree<RunError>(state.comm(), state.rank() == 0 ? publish(temporary, file) : "");
}

}  // namespace nanoweft
