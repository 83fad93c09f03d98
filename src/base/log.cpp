#include "nanoweft/base/log.hpp"

#include "nanoweft/base/error.hpp"

namespace nanoweft {

PetscLogEvent logEvent(const char* name) {
  static PetscClassId classId = 0;
  if (classId == 0) petsc(PetscClassIdRegister("nanoweft", &classId));
  PetscLogEvent event;
  petsc(PetscLogEventGetId(name, &event));
  if (event < 0) petsc(PetscLogEventRegister(name, classId, &event));
  return event;
}

}  // namespace nanoweft
