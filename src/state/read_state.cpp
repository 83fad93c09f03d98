#include <algorithm>
#include <cmath>
#include <filesystem>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/state/state_file.hpp"
#include "nanoweft/state/state_format.hpp"

namespace nanoweft {

namespace {

/// Reads this rank's rows of a dataset; leaves `values` empty when it is missing. Returns a
/// problem.
template <class T>
std::string readRows(hid_t group, const char* name, hid_t memoryType, const RowBlock& block,
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

Chains findChains(MPI_Comm comm, int rank, int ranks, std::int64_t total, const RowBlock& block,
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
  if (!name || *name != stateFormatName)
    return what + "the attribute format of /state is not '" + stateFormatName + "'";
  const auto version = h5::readIntegers(group, "version");
  if (!version || version->size() != 1 || (*version)[0] != stateFormatVersion)
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
  const std::string problem = readRows(group, "bond_broken", H5T_NATIVE_INT8,
                                       RowBlock(header.rows, rank, ranks), 1, broken);
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
      else if (H5Tget_class(type) == H5T_STRING)
        record.texts[name] = h5::readText(object, name).value_or("");
      return 0;
    };
    H5Aiterate2(run, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &header.run);
  }
  return header;
}

void readStateRows(const std::string& file, const StateHeader& header, State& state) {
  const MPI_Comm comm = state.comm();
  const RowBlock block(header.rows, state.rank(), state.ranks());
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

}  // namespace nanoweft
