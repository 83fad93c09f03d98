/// Pairs drawn from a list, threads' shares of the sums, and the order of the list: whatever the
/// way, the sums have the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "nanoweft/base/floats.hpp"
#include "nanoweft/force/pair_list.hpp"
#include "pair_sum.hpp"

namespace nanoweft::test {
namespace {

/// A ball of segments lying anyhow, and all pairs of them.
struct Ball {
  std::vector<double> pose;
  std::vector<ListPair> pairs;
  std::int32_t n = 0;

  explicit Ball(Random& random) {
    for (; n < 150; ++n) {
      const Vec3d x = random.vector(40.0);
      const Quatd q = random.orientation();
      pose.insert(pose.end(), {x.x, x.y, x.z, 0, q.w, q.x, q.y, q.z});
    }
    for (std::int32_t i = 0; i < n; ++i)
      for (std::int32_t j = i + 1; j < n; ++j) pairs.push_back({i, j});
  }
};

struct Sums {
  std::vector<ForceSum> records;
  ExactSum energy;
  std::int64_t resolved;

  bool operator==(const Sums& other) const {
    return std::memcmp(records.data(), other.records.data(), records.size() * sizeof(ForceSum)) ==
               0 &&
           std::equal(energy.data(), energy.data() + 3, other.energy.data());
  }
};

/// The sums of the segments begin <= k < end, without the spare record.
Sums sumsOf(const PairForce& force, const Ball& ball, DrawnPairs* drawn, bool draws, double margin,
            std::int32_t begin, std::int32_t end, bool energies = true) {
  std::vector<ForceSum> sum(static_cast<std::size_t>(ball.n) + 1, ForceSum{});
  const MinimumImage nearest{Box{}};
  PairJob job;
  job.pose = ball.pose.data();
  job.listed = ball.pairs;
  job.drawn = drawn;
  job.draws = draws;
  job.drawnRange = force.reach() + margin;
  job.begin = begin;
  job.end = end;
  job.spare = ball.n;
  job.sum = sum.data();
  job.nearest = &nearest;
  PairTally tally;
  tally.energyUnit = SumUnit(1.0);
  force.add(job, energies, tally);
  sum.pop_back();
  return {sum, tally.energy, tally.resolved};
}

class DrawnPairsOf : public testing::TestWithParam<const char*> {};

TEST_P(DrawnPairsOf, GiveTheSumsOfTheList) {
  const auto force = makeForce(GetParam());
  Random random;
  const double margin = 3.0;
  for (int round = 0; round < 3; ++round) {
    Ball ball(random);
    const Sums listed = sumsOf(*force, ball, nullptr, false, margin, 0, ball.n);
    ASSERT_GT(listed.resolved, 50);
    DrawnPairs drawn;
    EXPECT_TRUE(sumsOf(*force, ball, &drawn, true, margin, 0, ball.n) == listed);
    EXPECT_LT(drawn.ends.back().core + drawn.ends.back().rim, ball.pairs.size());
    EXPECT_GT(drawn.ends.back().rim, 0u);
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(sumsOf(*force, ball, &drawn, false, margin, 0, ball.n) ==
                  sumsOf(*force, ball, nullptr, false, margin, 0, ball.n));
      // In all less than half the margin.
      for (std::size_t i = 0; i < ball.pose.size(); i += 8) {
        const Vec3d way = random.vector(1.0), d = (0.49 / norm(way)) * way;
        ball.pose[i] += d.x;
        ball.pose[i + 1] += d.y;
        ball.pose[i + 2] += d.z;
      }
    }
  }
}

TEST_P(DrawnPairsOf, SharesOfTheSumsAreThoseOfTheWhole) {
  const auto force = makeForce(GetParam());
  Random random;
  const Ball ball(random);
  const Sums whole = sumsOf(*force, ball, nullptr, false, 1.0, 0, ball.n, false);
  for (const auto& [begin, end] : {std::pair{0, 61}, std::pair{61, 150}, std::pair{90, 90}}) {
    const Sums share = sumsOf(*force, ball, nullptr, false, 1.0, begin, end, false);
    for (std::int32_t i = 0; i < ball.n; ++i) {
      const bool mine = i >= begin && i < end;
      for (std::size_t c = 0; c < 8; ++c)
        EXPECT_EQ(share.records[static_cast<std::size_t>(i)].at[c],
                  mine ? whole.records[static_cast<std::size_t>(i)].at[c] : 0);
    }
  }
}

TEST_P(DrawnPairsOf, TheOrderOfTheListDoesNotMatter) {
  const auto force = makeForce(GetParam());
  Random random;
  Ball ball(random);
  const Sums before = sumsOf(*force, ball, nullptr, false, 1.0, 0, ball.n);
  interleave(ball.pairs);
  EXPECT_TRUE(sumsOf(*force, ball, nullptr, false, 1.0, 0, ball.n) == before);
}

std::vector<const char*> allOptions() {
  std::vector<const char*> options{"-pair_points 3", "-pair_points 3 -pair_far_points 1",
                                   "-pair_points 1", "-pair hertz"};
  if (singlePays) options.push_back("-pair_points 3 -pair_precision single");
  return options;
}
INSTANTIATE_TEST_SUITE_P(Laws, DrawnPairsOf, testing::ValuesIn(allOptions()));

TEST(Interleave, KeepsAllPairsAndSeparatesNeighbours) {
  for (std::int32_t n : {0, 1, 7, 8, 9, 255, 256, 257, 1000}) {
    std::vector<ListPair> pairs;
    for (std::int32_t k = 0; k < n; ++k) pairs.push_back({k / 10, k});
    auto mixed = pairs;
    interleave(mixed);
    for (std::size_t k = 0; n >= 256 && k + 1 < 8; ++k) EXPECT_NE(mixed[k].i, mixed[k + 1].i);
    std::sort(mixed.begin(), mixed.end(),
              [](const ListPair& a, const ListPair& b) { return a.j < b.j; });
    ASSERT_EQ(mixed.size(), pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) EXPECT_EQ(mixed[k].j, pairs[k].j);
  }
}

}  // namespace
}  // namespace nanoweft::test
