/// The check of a state file as a whole, before its rows are read.
#pragma once

#include <string>

#include "nanoweft/base/provenance.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

struct CheckedState {
  std::string digest;      ///< SHA-256 of the whole file
  bool byProgram = false;  ///< a run wrote it
  Provenance run;          ///< of that run
};

/// Throws InputError, with the reason, for a file that cannot be used as a state. Not collective.
CheckedState checkState(const std::string& file, Trust trust = Trust::program);

}  // namespace nanoweft
