/// Pairs of two ranks' or threads' segments: one of the two resolves them for both.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "support/program.hpp"

namespace nanoweft::test {
namespace {

/// Floating-point operations of pairs on all ranks, by PETSc's log.
double pairWork(const std::string& options, int ranks, int threads) {
  const Folder folder;
  const auto outcome =
      run(folder, options + " -ts_max_steps 2 -log_view :log.csv:ascii_csv", ranks, threads);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  // Stage, event, rank, count, time, messages, their length, reductions, operations.
  std::istringstream log(readFile(folder / "log.csv"));
  double sum = 0;
  for (std::string line; std::getline(log, line);) {
    std::istringstream row(line);
    std::string cell;
    for (int k = 0; k < 9; ++k) {
      std::getline(row, cell, ',');
      if (k == 1 && cell != "NwPairs") break;
      if (k == 8) sum += std::stod(cell);
    }
  }
  return sum;
}

TEST(SharedPairs, AreResolvedOnceOnAnyRanksAndThreads) {
  // The log has six digits.
  const std::string options = "-scene bundle -bundle_fibres 19 -bundle_segments 40 -ts_dt 5";
  const double alone = pairWork(options, 1, 1);
  ASSERT_GT(alone, 0);
  for (const auto& [ranks, threads] : {std::pair{2, 1}, {3, 1}, {4, 1}, {1, 2}, {2, 2}})
    EXPECT_NEAR(pairWork(options, ranks, threads), alone, 2e-5 * alone)
        << ranks << " x " << threads;
}

TEST(SharedPairs, OfRanksWithFewSegmentsAreResolvedByBoth) {
  const std::string options = "-scene bundle -bundle_fibres 7 -bundle_segments 20 -ts_dt 5";
  const double alone = pairWork(options, 1, 1);
  EXPECT_NEAR(pairWork(options, 1, 2), alone, 2e-5 * alone);
  EXPECT_GT(pairWork(options, 2, 1), 1.03 * alone);
}

}  // namespace
}  // namespace nanoweft::test
