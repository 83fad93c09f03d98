/// Events for -log_view: one per phase of a step.
#pragma once

#include <petsclog.h>

namespace nanoweft {

/// The event of this name, registered on first use.
PetscLogEvent logEvent(const char* name);

/// Logs the enclosing scope.
class LogScope {
 public:
  explicit LogScope(PetscLogEvent event) : event_(event) { PetscLogEventBegin(event_, 0, 0, 0, 0); }
  ~LogScope() { PetscLogEventEnd(event_, 0, 0, 0, 0); }
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;

 private:
  PetscLogEvent event_;
};

}  // namespace nanoweft
