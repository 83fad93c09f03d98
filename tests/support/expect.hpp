/// What tests expect of a run of the program.
#pragma once

#include <string>
#include <vector>

#include "support/program.hpp"

namespace nanoweft::test {

bool says(const Outcome& outcome, const std::string& words);

/// Status 0.
void expectDone(const Outcome& outcome);

/// One line "nanoweft: error: ..." that holds all fragments, and the status 1.
void expectRefused(const Outcome& outcome, const std::vector<std::string>& fragments);

/// No noise of MPI, PETSc, HDF5 or of a crash.
void expectClean(const std::string& output);

}  // namespace nanoweft::test
