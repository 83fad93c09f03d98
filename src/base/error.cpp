#include "nanoweft/base/error.hpp"

#include <cstdarg>
#include <cstring>
#include <new>
#include <vector>

namespace nanoweft {

namespace {

std::string firstMessage;

PetscErrorCode remember(MPI_Comm, int, const char*, const char*, PetscErrorCode code,
                        PetscErrorType type, const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL) firstMessage = message ? message : "";
  return code;
}

}  // namespace

void keepPetscErrors() {
  PetscPushErrorHandler(remember, nullptr);
}

std::string petscMessage(PetscErrorCode code) {
  std::string text = firstMessage;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.empty() ? "PETSc error " + std::to_string(static_cast<int>(code)) : text;
}

void petsc(PetscErrorCode code, std::source_location where) {
  if (code == 0) return;
  if (code == PETSC_ERR_MEM) throw std::bad_alloc();
  const std::string text = petscMessage(code);
  const char* file = std::strrchr(where.file_name(), '/');
  throw PetscFailure(text + " [" + (file ? file + 1 : where.file_name()) + ":" +
                     std::to_string(where.line()) + "]");
}

template <class Error>
void agree(MPI_Comm comm, std::string problem) {
  int rank, size;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  const int mine = problem.empty() ? size : rank;
  int first;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm);
  if (first == size) return;
  int length = static_cast<int>(problem.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm);
  problem.resize(static_cast<std::size_t>(length));
  MPI_Bcast(problem.data(), length, MPI_CHAR, first, comm);
  throw Error(problem);
}

template void agree<InputError>(MPI_Comm, std::string);
template void agree<RunError>(MPI_Comm, std::string);

std::string format(const char* pattern, ...) {
  va_list arguments, again;
  va_start(arguments, pattern);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, pattern, arguments);
  va_end(arguments);
  std::string text(static_cast<std::size_t>(length), '\0');
  std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  va_end(again);
  return text;
}

}  // namespace nanoweft
