#include "nanoweft/base/log.hpp"

#include "nanoweft/base/error.hpp"

namespace nanoweft {

PetscLogEvent logEvent(const char* name) {
  static PetscClassId classId = 0;
  if (classId == 0) {
    petsc(PetscClassIdRegister("nanoweft", &classId));
    // PETSc forgets its classes when it ends, and may be initialised again.
    petsc(PetscRegisterFinalize([]() -> PetscErrorCode { return classId = 0; }));
  }
  PetscLogEvent event;
  petsc(PetscLogEventGetId(name, &event));
  if (event < 0) petsc(PetscLogEventRegister(name, classId, &event));
  return event;
}

}  // namespace nanoweft
