/// Writes datasets whose rows are spread over all ranks into an HDF5 file that rank 0 has open.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <vector>

#include "nanoweft/base/hdf5.hpp"

namespace nanoweft {

/// Rank 0 writes rows in blocks, always the same ones, as they arrive from the ranks in their
/// order: it never holds more than a block, and the file has the same bytes on any number of ranks.
class DatasetWriter {
 public:
  explicit DatasetWriter(MPI_Comm comm);

  /// Shape of a row: nothing for one number.
  using Shape = std::vector<hsize_t>;
  /// Writes /GROUP/name, whose rows have that shape, in rank 0's open group. `rows`: those of this
  /// rank, which follow the ranks before. Collective. After a failure of rank 0, and on all ranks,
  /// it does nothing any more and returns false.
  template <class T>
  bool write(hid_t group, const char* name, const Shape& shape, const std::vector<T>& rows);
  template <class T>
  bool write(hid_t group, const char* name, int columns, const std::vector<T>& rows) {
    return write(group, name, columns > 1 ? Shape{static_cast<hsize_t>(columns)} : Shape{}, rows);
  }
  /// For what rank 0 writes besides: its success counts for all at the next `write`.
  void note(bool success) { good_ = good_ && success; }
  bool good() const { return good_; }

 private:
  struct Types {
    hid_t stored, memory;
    std::size_t bytes;
  };
  bool writeBytes(hid_t group, const char* name, Types types, const Shape& row, const char* rows,
                  std::int64_t count);
  void sendRows(const char* rows, std::int64_t count, std::size_t rowBytes) const;

  MPI_Comm comm_;
  int rank_, ranks_;
  bool good_ = true;
};

}  // namespace nanoweft
