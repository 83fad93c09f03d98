/// All options of a run, from wherever they are given, in PETSc's syntax.
///
/// Rank 0 reads each source once, as bytes, so that pipes and /dev/stdin serve on any number of
/// ranks. Later sources win: ~/.petscrc, .petscrc, petscrc (unless -skip_petscrc), PETSC_OPTIONS,
/// PETSC_OPTIONS_YAML, the command line with the files that it names, in its order. In one source
/// the later of two equal names wins.
#pragma once

#include <mpi.h>
#include <petscsys.h>

#include <optional>
#include <string>
#include <vector>

namespace nanoweft {

struct GivenOption {
  std::string name;  ///< with its -
  std::optional<std::string> value;
};

struct GivenOptions {
  std::vector<GivenOption> list;  ///< in the order in which they are to be set
  bool briefHelp = false;         ///< --help or -h: PETSc's own options are not wanted
  bool version = false;
};

/// Collective. Throws InputError, which says where in which source, or Interrupted.
GivenOptions readOptions(MPI_Comm comm, int argc, char** argv);

/// Likewise from `words`, as they would stand on the command line, and from no other source.
GivenOptions readOptions(MPI_Comm comm, const std::vector<std::string>& words);

/// Puts them into PETSc's database; before PetscInitialize, so that it finds its own.
void insertOptions(const GivenOptions& options);

/// Starts PETSc with these options alone and without its signal handlers. Returns PETSc's error
/// code. Throws PetscFailure.
PetscErrorCode initialisePetsc(const std::string& program, const GivenOptions& options);

}  // namespace nanoweft
