#include "support/expect.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace nanoweft::test {

bool says(const Outcome& outcome, const std::string& words) {
  return outcome.output.find(words) != std::string::npos;
}

void expectDone(const Outcome& outcome) {
  EXPECT_EQ(outcome.status, 0) << outcome.output;
}

void expectRefused(const Outcome& outcome, const std::vector<std::string>& fragments) {
  EXPECT_EQ(outcome.status, 1) << outcome.output;
  EXPECT_TRUE(outcome.output.starts_with("nanoweft: error: ")) << outcome.output;
  EXPECT_EQ(std::ranges::count(outcome.output, '\n'), 1) << outcome.output;
  for (const std::string& fragment : fragments)
    EXPECT_TRUE(says(outcome, fragment)) << "no '" << fragment << "' in: " << outcome.output;
  expectClean(outcome.output);
}

void expectClean(const std::string& output) {
  for (const char* word : {"internal error", "PETSC ERROR", "HDF5-DIAG", "terminate called",
                           "Segmentation", "MPI_ABORT"})
    EXPECT_EQ(output.find(word), std::string::npos) << word << " in:\n" << output;
}

}  // namespace nanoweft::test
