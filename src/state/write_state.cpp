#include <fcntl.h>
#include <petscsf.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/state/state_file.hpp"
#include "nanoweft/state/state_format.hpp"

namespace nanoweft {

namespace {

// Fixed, so that a file does not depend on the number of ranks.
constexpr hsize_t chunkRows = 16384;

/// Sends rows from where they live to the ranks that write them.
class RowOrder {
 public:
  RowOrder(const State& state, const RowBlock& block) : block_(block) {
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
  RowBlock block_;
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
  const RowBlock block(state.total(), state.rank(), state.ranks());
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
    h5::writeAttribute(group, "format", stateFormatName);
    h5::writeScalar(group, "version", stateFormatVersion);
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

    if (!run.reals.empty() || !run.integers.empty() || !run.texts.empty()) {
      h5::Handle record(H5Gcreate2(f, "run", H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
      for (const auto& [name, values] : run.reals) h5::writeAttribute(record, name.c_str(), values);
      for (const auto& [name, values] : run.integers)
        h5::writeAttribute(record, name.c_str(), values);
      for (const auto& [name, text] : run.texts) h5::writeAttribute(record, name.c_str(), text);
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
