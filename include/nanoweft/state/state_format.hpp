/// What reading and writing a state file share.
#pragma once

#include <hdf5.h>
#include <mpi.h>

#include <cstdint>

namespace nanoweft {

inline constexpr const char* stateFormatName = "nanoweft-state";
inline constexpr std::int64_t stateFormatVersion = 1;

/// The rows that a rank reads or writes.
struct RowBlock {
  std::int64_t begin, count;
  RowBlock(std::int64_t total, int rank, int ranks) {
    begin = total * rank / ranks;
    count = total * (rank + 1) / ranks - begin;
  }
};

/// File access by all ranks together; to be closed with H5Pclose.
inline hid_t parallelAccess(MPI_Comm comm) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL);
  H5Pset_all_coll_metadata_ops(access, true);
  return access;
}

}  // namespace nanoweft
