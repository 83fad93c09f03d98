/// Checks of the places that a run will write to, made before it starts: nothing of another's is
/// overwritten, and no result is lost for want of a folder. All are collective.
#pragma once

#include <mpi.h>

#include <string>

namespace nanoweft {

/// Throws InputError when `file` exists and is not a state file: such a file is never overwritten.
void refuseForeignTarget(MPI_Comm comm, const std::string& file);

/// Throws InputError when `file` cannot be made.
void requireWritable(MPI_Comm comm, const std::string& file);

/// Creates the folder that `file` lies in, where it is missing. Throws InputError.
void makeParentFolder(MPI_Comm comm, const std::string& file);

}  // namespace nanoweft
