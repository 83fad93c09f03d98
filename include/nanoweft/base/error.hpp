/// Errors of PETSc as exceptions, and errors that all ranks throw together.
#pragma once

#include <petscsys.h>

#include <source_location>
#include <stdexcept>
#include <string>

#include "nanoweft/base/exceptions.hpp"

namespace nanoweft {

/// A PETSc call failed; what() says which and where.
struct PetscFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What PETSc said about its last error.
std::string petscMessage(PetscErrorCode code);

/// Turns a PETSc error code into an exception; memory that PETSc did not get into std::bad_alloc.
void petsc(PetscErrorCode code, std::source_location where = std::source_location::current());

/// Makes PETSc keep the first message of an error for `petsc` instead of printing a trace (which
/// would end all ranks but the first with status 0).
void keepPetscErrors();

/// Throws `Error` on all ranks when any rank's `problem` is not empty, with the lowest such rank's
/// text.
template <class Error>
void agree(MPI_Comm comm, std::string problem);

/// printf into a std::string.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

}  // namespace nanoweft
