/// HDF5 on a file that is open already, for one process.
///
/// HDF5's own drivers let a failed write pass for a broken library: files cannot be closed any
/// more, and the program ends in a crash or waits for ever. This one remembers the first failure
/// and keeps quiet about it, so that HDF5 always comes to its end; whoever writes asks for the
/// failure.
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
