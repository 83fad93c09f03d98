/// Shares among threads: all are done, whatever team the runtime gives.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "nanoweft/base/threads.hpp"
#include "nanoweft/force/overlap.hpp"

namespace nanoweft::test {
namespace {

void expectEachShareOnce(std::size_t count) {
  std::vector<std::atomic<int>> done(count);
  onShares(count, [&](std::size_t share) { ++done[share]; });
  for (std::size_t k = 0; k < count; ++k) EXPECT_EQ(done[k], 1) << "share " << k << " of " << count;
}

TEST(Threads, EachShareIsDoneOnce) {
  for (const std::size_t count : {1u, 2u, 3u, 7u, 64u}) expectEachShareOnce(count);
}

TEST(Threads, EachShareIsDoneOnceWhenTheRuntimeGivesOneThread) {
  const int levels = omp_get_max_active_levels();
  omp_set_max_active_levels(0);
  EXPECT_EQ(teamGiven(3), 1);
  for (const std::size_t count : {1u, 2u, 3u, 7u}) expectEachShareOnce(count);
  omp_set_max_active_levels(levels);
}

TEST(Threads, EachShareIsDoneOnceInsideAnotherTeam) {
  std::atomic<int> done = 0;
  onShares(2, [&](std::size_t) { onShares(5, [&](std::size_t) { ++done; }); });
  EXPECT_EQ(done, 10);
}

TEST(Threads, NoShareIsNoWork) {
  onShares(0, [](std::size_t) { FAIL(); });
}

TEST(Threads, AnExceptionComesOutOfTheTeam) {
  EXPECT_THROW(onShares(4,
                        [](std::size_t share) {
                          if (share == 2) throw std::bad_alloc();
                        }),
               std::bad_alloc);
  expectEachShareOnce(4);
}

TEST(Overlap, DistanceOfStraightPieces) {
  const Vec3d x{1, 0, 0}, y{0, 1, 0};
  // Crossing, above each other; beside each other; end to end; an end above the middle.
  EXPECT_DOUBLE_EQ(distanceOfPieces({0.5, 0.25, 3}, x, y, 2), 3);
  EXPECT_DOUBLE_EQ(distanceOfPieces({1, 0, 4}, x, x, 2), 4);
  EXPECT_DOUBLE_EQ(distanceOfPieces({1, 0, 4}, x, -x, 2), 4);
  EXPECT_DOUBLE_EQ(distanceOfPieces({7, 0, 0}, x, x, 2), 3);
  EXPECT_DOUBLE_EQ(distanceOfPieces({1, 5, 0}, x, y, 2), 3);
  EXPECT_DOUBLE_EQ(distanceOfPieces({5, 6, 0}, x, y, 2), 5);
  // Pieces without length are points.
  EXPECT_DOUBLE_EQ(distanceOfPieces({3, 4, 0}, x, y, 0), 5);
}

}  // namespace
}  // namespace nanoweft::test
