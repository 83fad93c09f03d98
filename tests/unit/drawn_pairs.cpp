/// Pairs drawn from a list, their order in lanes, and threads' shares of the sums: whatever the
/// way, the sums have the same bits as those of every pair on its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

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

  explicit Ball(Random& random, int size = 150) {
    for (; n < size; ++n) {
      const Vec3d x = random.vector(40.0);
      const Quatd q = random.orientation();
      pose.insert(pose.end(), {x.x, x.y, x.z, 0, q.w, q.x, q.y, q.z});
    }
    for (std::int32_t i = 0; i < n; ++i)
      for (std::int32_t j = i + 1; j < n; ++j) pairs.push_back({i, j});
  }
};

DrawnPairs draw(const PairForce& force, const Ball& ball, std::span<const ListPair> pairs,
                double margin) {
  PairRuns listed;
  listed.set(FoundPairs(pairs), ball.n);
  DrawnPairs drawn;
  force.draw(listed, ball.pose.data(), MinimumImage{Box{}}, margin, drawn);
  return drawn;
}

struct Sums {
  std::vector<ForceSum> records;
  ExactSum energy;
  std::int64_t resolved = 0;

  explicit Sums(const Ball& ball) : records(static_cast<std::size_t>(ball.n), ForceSum{}) {}
  void operator+=(const Sums& other) {
    for (std::size_t i = 0; i < records.size(); ++i)
      for (std::size_t c = 0; c < 8; ++c) records[i].at[c] += other.records[i].at[c];
    energy.merge(other.energy);
    resolved += other.resolved;
  }
  /// Two sums that hold nothing are equal as well, and say nothing.
  bool holdForces() const {
    return std::ranges::any_of(records, [](const ForceSum& r) { return r.at[0] != 0; });
  }
  bool operator==(const Sums& other) const {
    return std::memcmp(records.data(), other.records.data(), records.size() * sizeof(ForceSum)) ==
               0 &&
           std::equal(energy.data(), energy.data() + 3, other.energy.data());
  }
};

/// The sums of the segments begin <= k < end, without the spare record.
Sums sumsOf(const PairForce& force, const Ball& ball, const DrawnPairs& drawn, std::int32_t begin,
            std::int32_t end, bool energies = true) {
  Sums sums(ball);
  sums.records.push_back({});
  const MinimumImage nearest{Box{}};
  PairJob job;
  job.pose = ball.pose.data();
  job.drawn = &drawn;
  job.begin = begin;
  job.end = end;
  job.spare = ball.n;
  job.sum = sums.records.data();
  job.nearest = &nearest;
  PairTally tally;
  tally.energyUnit = SumUnit(1.0);
  force.add(job, energies, tally);
  sums.records.pop_back();
  sums.energy = tally.energy;
  sums.resolved = tally.resolved;
  return sums;
}

Sums allSums(const PairForce& force, const Ball& ball, double margin, bool energies = true) {
  return sumsOf(force, ball, draw(force, ball, ball.pairs, margin), 0, ball.n, energies);
}

class DrawnPairsOf : public testing::TestWithParam<const char*> {};

TEST_P(DrawnPairsOf, GiveTheSumsOfEveryPairOnItsOwn) {
  const auto force = makeForce(GetParam());
  Random random;
  for (int size : {2, 3, 9, 17, 40}) {
    const Ball ball(random, size);
    Sums sum(ball);
    for (const ListPair& pair : ball.pairs)
      sum += sumsOf(*force, ball, draw(*force, ball, {&pair, 1}, 1.0), 0, ball.n);
    const Sums together = allSums(*force, ball, 1.0);
    EXPECT_TRUE(together == sum);
    EXPECT_EQ(together.resolved, sum.resolved);
    if (size == 40) {
      EXPECT_TRUE(together.holdForces());
    }
    // Forces do not depend on whether energies are asked for.
    const Sums forces = allSums(*force, ball, 1.0, false);
    EXPECT_EQ(std::memcmp(forces.records.data(), sum.records.data(),
                          sum.records.size() * sizeof(ForceSum)),
              0);
  }
}

TEST_P(DrawnPairsOf, ServeUntilASegmentHasMovedByHalfTheMargin) {
  const auto force = makeForce(GetParam());
  Random random;
  const double margin = 3.0;
  for (int round = 0; round < 3; ++round) {
    Ball ball(random);
    const DrawnPairs drawn = draw(*force, ball, ball.pairs, margin);
    const std::size_t rim = drawn.ends.back().rim;
    EXPECT_GT(rim, 0u);
    EXPECT_LT(rim, ball.pairs.size());
    for (int k = 0; k < 4; ++k) {
      const Sums sums = sumsOf(*force, ball, drawn, 0, ball.n);
      ASSERT_GT(sums.resolved, 50);
      ASSERT_TRUE(sums.holdForces());
      // With another margin other pairs are of the rim.
      EXPECT_TRUE(sums == allSums(*force, ball, 0.0));
      EXPECT_TRUE(sums == allSums(*force, ball, 10.0));
      // Outermost points move by less than half the margin in all.
      for (std::size_t i = 0; i < ball.pose.size(); i += 8) {
        const Vec3d way = random.vector(1.0), d = (0.29 / norm(way)) * way,
                    turn = (0.01 / norm(way)) * Vec3d{way.y, way.z, way.x};
        double* pose = &ball.pose[i];
        pose[0] += d.x;
        pose[1] += d.y;
        pose[2] += d.z;
        const Quatd q = rotation(turn) * Quatd{pose[4], pose[5], pose[6], pose[7]};
        pose[4] = q.w, pose[5] = q.x, pose[6] = q.y, pose[7] = q.z;
      }
    }
  }
}

TEST_P(DrawnPairsOf, SharesOfTheSumsAreThoseOfTheWhole) {
  const auto force = makeForce(GetParam());
  Random random;
  const Ball ball(random);
  const DrawnPairs drawn = draw(*force, ball, ball.pairs, 1.0);
  const Sums whole = sumsOf(*force, ball, drawn, 0, ball.n, false);
  ASSERT_TRUE(whole.holdForces());
  for (const auto& [begin, end] : {std::pair{0, 61}, std::pair{61, 150}, std::pair{90, 90}}) {
    const Sums share = sumsOf(*force, ball, drawn, begin, end, false);
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
  const Sums before = allSums(*force, ball, 1.0);
  ASSERT_TRUE(before.holdForces());
  std::reverse(ball.pairs.begin(), ball.pairs.end());
  EXPECT_TRUE(allSums(*force, ball, 1.0) == before);
}

std::vector<const char*> allOptions() {
  std::vector<const char*> options{"-pair_points 3",
                                   "-pair_points 3 -pair_far_points 1",
                                   "-pair_points 5 -pair_far_points 2 -pair_far_from 22",
                                   "-pair_points 12 -pair_far_points 1 -pair_far_from 20",
                                   "-pair_points 1",
                                   "-pair hertz"};
  if (singlePays)
    for (const char* single : {"-pair_points 3 -pair_precision single",
                               "-pair_points 5 -pair_far_points 1 -pair_precision single"})
      options.push_back(single);
  return options;
}
INSTANTIATE_TEST_SUITE_P(Laws, DrawnPairsOf, testing::ValuesIn(allOptions()));

/// Viscous force on the first of two segments `distance` apart along x.
Vec3d viscousForce(const PairForce& force, double distance, const Quatd& q) {
  Random random;
  Ball ball(random, 2);
  for (std::size_t k = 0; k < 2; ++k) {
    const double record[8] = {distance * static_cast<double>(k), 0, 0, 0, q.w, q.x, q.y, q.z};
    std::copy(record, record + 8, &ball.pose[8 * k]);
  }
  const DrawnPairs drawn = draw(force, ball, ball.pairs, 1.0);
  const double velocity[6] = {1, 2, 3, 5, 7, 11}, angular[6] = {};
  std::vector<ForceSum> sums(3);
  std::vector<std::int64_t> viscous(12, 0);
  const MinimumImage nearest{Box{}};
  PairJob job;
  job.pose = ball.pose.data();
  job.drawn = &drawn;
  job.begin = 0;
  job.end = job.spare = 2;
  job.sum = sums.data();
  job.nearest = &nearest;
  job.velocity = velocity;
  job.angular = angular;
  job.viscousSum = viscous.data();
  job.viscous.linear = 1e-3;
  job.viscousUnits = {force.forceUnit(), force.torqueUnit()};
  PairTally tally;
  force.add(job, false, tally);
  for (std::size_t c = 0; c < 6; ++c) EXPECT_EQ(viscous[c], -viscous[6 + c]);
  const double unit = force.forceUnit();
  return {unit * static_cast<double>(viscous[0]), unit * static_cast<double>(viscous[1]),
          unit * static_cast<double>(viscous[2])};
}

TEST(ViscousDamping, ActsOnceOnPairsWithPointsWithinTheCutoff) {
  const Quatd along{}, across{std::sqrt(0.5), 0, std::sqrt(0.5), 0};
  const Vec3d whole{4e-3, 5e-3, 8e-3};
  for (const char* options : {"-pair_points 3", "-pair_points 3 -pair_far_points 1"}) {
    const auto force = makeForce(options);
    // In both parts of the law, in the far one (first of a pair drawn as near), and at either side
    // of the cutoff.
    for (double distance : {20.0, 27.5, 37.0, 45.0, 54.0})
      EXPECT_LT(norm(viscousForce(*force, distance, across) - whole), 1e-12) << distance;
    EXPECT_EQ(norm(viscousForce(*force, 54.3, across)), 0.0);
  }
  // Points of segments in a row reach farther than their centres.
  const auto force = makeForce("-pair_points 3");
  EXPECT_LT(norm(viscousForce(*force, 63.2, along) - whole), 1e-12);
  EXPECT_EQ(norm(viscousForce(*force, 63.3, along)), 0.0);
}

TEST(PairRuns, HoldWhatTheyWereGiven) {
  for (std::int32_t size : {0, 1, 5, 60}) {
    std::vector<ListPair> pairs;
    for (std::int32_t k = 0; k < 4 * size; ++k) pairs.push_back({k * k % (size + 1), k});
    PairRuns runs;
    runs.set(FoundPairs(pairs), size + 1);
    EXPECT_EQ(runs.pairs(), pairs.size());
    std::vector<ListPair> found;
    runs.forEach([&](const ListPair& p) { found.push_back(p); });
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const ListPair& a, const ListPair& b) { return a.i < b.i; });
    ASSERT_EQ(found.size(), pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      EXPECT_EQ(found[k].i, pairs[k].i);
      EXPECT_EQ(found[k].j, pairs[k].j);
    }
  }
}

TEST(LanePairs, HaveEveryPairOnceAndWasteFewLanes) {
  LanePairs lanes;
  std::map<std::pair<std::int32_t, std::int32_t>, int> wanted, found;
  LanePairs::Place begin = lanes.end();
  std::size_t pairs = 0;
  for (int stretch = 0; stretch < 3; ++stretch) {
    for (std::int32_t i = 0; i < 200; ++i) {
      std::vector<std::int32_t> partners;
      for (std::int32_t j = 0; j < 5 + i % 13; ++j) partners.push_back(1000 * stretch + i + j);
      if (i % 7 == 0) partners.clear();
      lanes.add(i, partners);
      for (const std::int32_t j : partners) ++wanted[{i, j}];
      pairs += partners.size();
    }
    lanes.arrange();
    const LaneView view = lanes.between(begin, lanes.end());
    begin = lanes.end();
    const std::int32_t* partner = view.partners;
    for (const LaneGroup& group : view.groups) {
      EXPECT_EQ(group.depth(), *std::max_element(group.count, group.count + laneCount));
      for (int k = 0; k < group.depth(); ++k)
        for (int lane = 0; lane < laneCount; ++lane, ++partner)
          if (k < group.count[lane]) ++found[{group.first[lane], *partner}];
    }
    EXPECT_EQ(partner, lanes.between(begin, begin).partners);
  }
  EXPECT_TRUE(found == wanted);
  EXPECT_LT(static_cast<double>(begin.partner), 1.06 * static_cast<double>(pairs));
}

}  // namespace
}  // namespace nanoweft::test
