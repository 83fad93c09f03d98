#include "nanoweft/state/output_target.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <vector>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

namespace {

/// Rows read at a time.
constexpr hsize_t blockRows = 16384;

/// Can all datasets of /state be read? HDF5 compares their checksums.
bool datasetsIntact(const std::string& file) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  auto visit = [](hid_t object, const char* name, const H5L_info_t*, void* out) -> herr_t {
    h5::Handle set(H5Dopen2(object, name, H5P_DEFAULT), H5Dclose);
    h5::Handle type(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose);
    if (!set.valid()) return 0;
    hsize_t shape[2] = {0, 1};
    if (H5Sget_simple_extent_ndims(space) > 2) return 0;
    H5Sget_simple_extent_dims(space, shape, nullptr);
    std::vector<char> buffer;
    for (hsize_t row = 0; row < shape[0]; row += blockRows) {
      const hsize_t start[2] = {row, 0}, count[2] = {std::min(blockRows, shape[0] - row), shape[1]};
      buffer.resize(count[0] * count[1] * H5Tget_size(type));
      H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
      h5::Handle memory(H5Screate_simple(2, count, nullptr), H5Sclose);
      if (H5Dread(set, type, memory, space, H5P_DEFAULT, buffer.data()) < 0)
        *static_cast<bool*>(out) = false;
    }
    return 0;
  };
  bool intact = true;
  H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &intact);
  return intact;
}

}  // namespace

void refuseForeignTarget(MPI_Comm comm, const std::string& file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string problem;
  std::error_code code;
  if (rank == 0) {
    if (std::filesystem::is_directory(file, code) || std::filesystem::path(file).filename().empty())
      problem = "cannot write a state to " + file + ": it is a folder";
    else if (std::filesystem::exists(file, code) && !stateFileProblem(file).empty())
      problem = "will not overwrite " + file +
                ": it is not a nanoweft state file; remove it or choose another name";
    else if (std::filesystem::exists(file, code) && !datasetsIntact(file))
      problem = "will not overwrite " + file +
                ": it is a damaged state file; remove it or choose another name";
  }
  agree<InputError>(comm, problem);
}

void requireWritable(MPI_Comm comm, const std::string& file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string problem;
  if (rank == 0) {
    const std::string probe = file + ".tmp";
    if (const int fd = ::open(probe.c_str(), O_WRONLY | O_CREAT | O_EXCL, 0666); fd >= 0) {
      ::close(fd);
      ::unlink(probe.c_str());
    } else if (errno != EEXIST) {
      problem = format("cannot write %s: %s", file.c_str(), std::strerror(errno));
    }
  }
  agree<InputError>(comm, problem);
}

void makeParentFolder(MPI_Comm comm, const std::string& file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string problem;
  if (rank == 0) {
    const auto folder = std::filesystem::path(file).parent_path();
    std::error_code code;
    if (!folder.empty()) std::filesystem::create_directories(folder, code);
    if (code) problem = "cannot make the folder " + folder.string() + ": " + code.message();
  }
  agree<InputError>(comm, problem);
}

}  // namespace nanoweft
