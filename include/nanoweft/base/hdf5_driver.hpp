/// HDF5 on a file that is open already, for one process.
///
/// After a failed write, HDF5's own drivers leave files that cannot be closed, and the program
/// crashes or hangs. This driver tells HDF5 that every write succeeds, so HDF5 always comes to its
/// end. It keeps the first failure in `OpenFile`, where the code that writes a file looks for it.
#pragma once

#include <hdf5.h>

#include "nanoweft/base/hdf5.hpp"

namespace nanoweft::h5 {

/// What a file access must know; lives as long as the file is open in HDF5.
struct OpenFile {
  int descriptor = -1;
  int failure = 0;  ///< errno of the first write that failed
};

/// Access list for H5Fcreate or H5Fopen, which then use `file.descriptor` whatever name they are
/// given. The descriptor stays the caller's. No locks are taken.
Handle accessTo(OpenFile& file);

}  // namespace nanoweft::h5
