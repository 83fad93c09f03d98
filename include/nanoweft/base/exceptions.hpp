/// Exceptions for bad input and for a failed run, thrown by all ranks together.
#pragma once

#include <stdexcept>

namespace nanoweft {

/// The user's input is wrong: one line, exit status 1.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The run failed (instability, lost segments, failed output): exit status 2.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace nanoweft
