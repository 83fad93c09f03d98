/// Shares among threads: all are done, whatever team the runtime gives.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "nanoweft/base/random.hpp"
#include "nanoweft/base/team_size.hpp"
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

TEST(Threads, EachShareIsDoneOnceByASmallerTeam) {
  const int before = std::exchange(teamMeter().most, 2);
  expectEachShareOnce(5);
  std::atomic<int> team = 0;
  onShares(5, [&](std::size_t) { team = omp_get_num_threads(); });
  EXPECT_LE(team, 2);
  teamMeter().most = before;
}

CoreSet cores(std::initializer_list<int> numbers) {
  CoreSet set;
  CPU_ZERO(&set);
  for (const int k : numbers) CPU_SET(k, &set);
  return set;
}

TEST(Threads, ARankHasItsCoresOrItsShareOfThem) {
  const CoreSet all = cores({0, 1, 2, 3}), left = cores({0, 1}), right = cores({2, 3});
  EXPECT_EQ(shareOfCores(all, {all}), 4);
  EXPECT_EQ(shareOfCores(all, {all, all}), 2);
  EXPECT_EQ(shareOfCores(left, {left, right}), 2);  // bound
  EXPECT_EQ(shareOfCores(left, {left, left}), 1);   // both confined to the same cores
  EXPECT_EQ(shareOfCores(right, {left, left, right, right}), 1);
  EXPECT_EQ(shareOfCores(left, {left, left, left}), 1);  // more ranks than cores
}

TEST(Threads, TheTimeOfTeamsIsCountedOnce) {
  const double before = teamMeter().seconds, begin = omp_get_wtime();
  onShares(2, [&](std::size_t) {
    onShares(2, [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
  });
  const double counted = teamMeter().seconds - before;
  EXPECT_GE(counted, 0.02);
  EXPECT_LE(counted, omp_get_wtime() - begin);
}

/// Cores of which other programs take some, all of equal rank: a team of more threads than there
/// are free cores goes at the speed of threads that share a core.
struct Machine {
  int cores, taken;

  double cost(int team) const { return (team > cores - taken ? 2.0 : 1.0) / team; }
  double delay(int team) const { return team > cores - taken ? 0.5 / team : 0.0; }
  /// Mean team over so many seconds.
  double run(TeamTrials& trials, double seconds) const {
    double sum = 0;
    for (double t = 0; t < seconds; t += 0.1) {
      const int team = trials.size();
      sum += 0.1 * team;
      trials.note(cost(team), delay(team), 0.1);
    }
    return sum / seconds;
  }
};

TEST(TeamSize, LeavesAllThreadsToWhatComesAfter) {
  {
    const TeamSize size(2, false, CoreWatch());
    EXPECT_DOUBLE_EQ(size.mean(), 2);
    teamMeter().most = 1;  // as it does where a core is taken
  }
  EXPECT_EQ(teamMeter().most, TeamMeter{}.most);
}

TEST(TeamSize, StaysWhereNobodyDisturbs) {
  TeamTrials trials(4);
  for (int k = 0; k < 1000; ++k) {
    EXPECT_EQ(trials.size(), 4);
    trials.note(1.0 + 0.5 * uniformPair(1, Purpose::errorEstimate, k, 0)[0], 0.09, 0.1);
  }
}

TEST(TeamSize, ShrinksBesideOthersAndGrowsAgain) {
  TeamTrials trials(4);
  const Machine busy{4, 1}, quiet{4, 0};
  EXPECT_NEAR(busy.run(trials, 100), 3, 0.1);
  EXPECT_EQ(trials.size(), 3);
  quiet.run(trials, 31);  // the longest time between trials
  EXPECT_EQ(trials.size(), 4);
  EXPECT_NEAR(busy.run(trials, 100), 3, 0.1);
}

TEST(TeamSize, TriesNoThreadForWhichThereIsNoCore) {
  TeamTrials trials(2);
  trials.begin(1.6);
  EXPECT_EQ(trials.size(), 2);
  trials.begin(1.4);
  EXPECT_EQ(trials.size(), 1);
  for (int k = 0; k < 1000; ++k) {
    trials.note(1.0, 0.0, 0.1, 0.1);
    ASSERT_EQ(trials.size(), 1);
  }
  trials.note(1.0, 0.0, 0.1, 0.9);
  EXPECT_EQ(trials.size(), 2);
}

TEST(TeamSize, BeginsWithTheThreadsThatHaveCores) {
  TeamTrials trials(4);
  for (const auto& [cores, size] : {std::pair{15.0, 4}, {3.7, 4}, {2.9, 3}, {0.2, 1}}) {
    trials.begin(cores);
    EXPECT_EQ(trials.size(), size) << cores;
  }
  trials.note(1.0, 0.0, 0.1, 2.0);  // the others have gone
  EXPECT_EQ(trials.size(), 2);
}

TEST(TeamSize, BeginsWithFewerWhereThreadsHaveWaited) {
  TeamTrials trials(2);
  trials.lookBack(0.2);
  EXPECT_EQ(trials.size(), 2);
  trials.lookBack(0.5);
  EXPECT_EQ(trials.size(), 1);
}

TEST(TeamSize, TheCoresOfThisProcessAreCounted) {
  const CoreWatch cores;
  EXPECT_FALSE(cores.spare());  // too little time has passed
  const double begin = omp_get_wtime();
  while (omp_get_wtime() - begin < 0.2) continue;
  const auto spare = cores.spare();
  ASSERT_TRUE(spare);
  EXPECT_GE(*spare, 0);
  EXPECT_GT(cores.used(), 0);
}

TEST(TeamSize, WaitsForAsManyShares) {
  TeamSize size(2, false, CoreWatch());
  EXPECT_TRUE(size.noteStep(1));
  EXPECT_FALSE(size.noteStep(2));
}

TEST(TeamSize, KeepsAllWhereFewerAreNoFaster) {
  // Somebody takes a fifth of one core.
  TeamTrials trials(2);
  int least = 2, tried = 0;
  for (int k = 0; k < 1000; ++k) {
    const int team = trials.size();
    least = std::min(least, team);
    tried += team < 2;
    trials.note(team == 2 ? 0.6 : 1.0, team == 2 ? 0.15 : 0.0, 0.1);
  }
  EXPECT_EQ(least, 1);
  EXPECT_LE(tried, 12);
}

TEST(TeamSize, NeverLeavesItsBounds) {
  TeamTrials trials(3);
  for (int k = 0; k < 5000; ++k) {
    trials.note(uniformPair(1, Purpose::errorEstimate, k, 0)[0],
                uniformPair(2, Purpose::errorEstimate, k, 0)[0], 0.3);
    ASSERT_GE(trials.size(), 1);
    ASSERT_LE(trials.size(), 3);
  }
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
