/// Pairs far apart with fewer points: the whole of PairForce, with its sifting of the list.
#include <gtest/gtest.h>

#include <functional>

#include "helpers.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/force/pair_force.hpp"

namespace nanoweft::test {
namespace {

constexpr double length = 13.56;

std::unique_ptr<PairForce> makeForce(const std::string& options) {
  petsc(PetscOptionsClear(nullptr));
  petsc(PetscOptionsInsertString(nullptr, options.c_str()));
  Options read;
  auto force = readPairForce(read, nanoUnits(), cnt1010(nanoUnits()));
  petsc(PetscOptionsClear(nullptr));
  return force;
}

struct Pose {
  Vec3d x;
  Quatd q;
};

struct Sum {
  double energy;
  std::vector<Vec3d> force, torque;
  std::int64_t resolved, pointPairs;
};

/// All pairs of the segments.
Sum evaluate(const PairForce& force, const std::vector<Pose>& segments) {
  std::vector<double> pose;
  std::vector<ListPair> pairs;
  const auto n = static_cast<std::int32_t>(segments.size());
  for (const Pose& s : segments)
    pose.insert(pose.end(), {s.x.x, s.x.y, s.x.z, 0, s.q.w, s.q.x, s.q.y, s.q.z});
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j = i + 1; j < n; ++j) pairs.push_back({i, j});
  std::vector<ForceSum> sum(segments.size(), ForceSum{});
  const MinimumImage nearest{Box{}};
  PairJob job;
  job.pose = pose.data();
  job.pairs = pairs.data();
  job.count = pairs.size();
  job.begin = 0;
  job.end = n;
  job.sum = sum.data();
  job.nearest = &nearest;
  PairTally tally;
  tally.energyUnit = SumUnit(1.0);
  force.add(job, true, tally);
  Sum result{tally.energy.value(tally.energyUnit), {}, {}, tally.resolved, tally.pointPairs};
  for (std::size_t i = 0; i < segments.size(); ++i) {
    auto vector = [&](std::size_t k, double unit) {
      return unit * Vec3d{static_cast<double>(sum[i].at[k]), static_cast<double>(sum[i].at[k + 1]),
                          static_cast<double>(sum[i].at[k + 2])};
    };
    result.force.push_back(vector(0, force.forceUnit()));
    result.torque.push_back(vector(3, force.torqueUnit()));
  }
  return result;
}

std::vector<Pose> pairAt(double distance, Random& random) {
  const Vec3d direction = random.vector(1.0);
  return {{{0, 0, 0}, random.orientation()},
          {(distance / norm(direction)) * direction, random.orientation()}};
}

TEST(FarPoints, ManyPointsNearFewFar) {
  const auto near = makeForce("-pair_points 3"), far = makeForce("-pair_points 1"),
             both = makeForce("-pair_points 3 -pair_far_points 1");
  Random random;
  for (double distance : {15.0, 20.0, 30.0, 33.8}) {
    const auto pair = pairAt(distance, random);
    EXPECT_EQ(evaluate(*both, pair).energy, evaluate(*near, pair).energy);
    EXPECT_EQ(norm(evaluate(*both, pair).force[0] - evaluate(*near, pair).force[0]), 0.0);
  }
  for (double distance : {40.7, 45.0, 54.0, 60.0}) {
    const auto pair = pairAt(distance, random);
    EXPECT_EQ(evaluate(*both, pair).energy, evaluate(*far, pair).energy);
    EXPECT_EQ(norm(evaluate(*both, pair).torque[0]), 0.0);
  }
  const auto pair = pairAt(37.29, random);  // half way
  EXPECT_NEAR(evaluate(*both, pair).energy,
              0.5 * (evaluate(*near, pair).energy + evaluate(*far, pair).energy), 1e-15);
  EXPECT_DOUBLE_EQ(both->reach(), 54.24);
  EXPECT_DOUBLE_EQ(near->reach(), 54.24 + 2.0 / 3.0 * length);
}

TEST(FarPoints, ForceAndTorqueAreTheGradientOfTheEnergy) {
  const auto force =
      makeForce("-pair_points 4 -pair_far_points 2 -pair_far_from 24 -pair_far_width 9");
  Random random;
  for (double distance : {22.0, 24.1, 26.0, 28.5, 31.0, 32.9, 35.0}) {
    const auto pair = pairAt(distance, random);
    const Sum sum = evaluate(*force, pair);
    const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const Vec3d& e : axes) {
      auto after = [&](const std::function<void(std::vector<Pose>&, double)>& change) {
        return derivative(
            [&](double s) {
              auto moved = pair;
              change(moved, s);
              return evaluate(*force, moved).energy;
            },
            1e-3);
      };
      const double size = norm(sum.force[0]) + norm(sum.torque[0]) + norm(sum.torque[1]);
      EXPECT_NEAR(after([&](auto& p, double s) { p[0].x += s * e; }), -dot(sum.force[0], e),
                  1e-7 * size);
      EXPECT_NEAR(after([&](auto& p, double s) { p[0].q = rotation(s * e) * p[0].q; }),
                  -dot(sum.torque[0], e), 1e-7 * size);
      EXPECT_NEAR(after([&](auto& p, double s) { p[1].q = rotation(s * e) * p[1].q; }),
                  -dot(sum.torque[1], e), 1e-7 * size);
    }
    EXPECT_EQ(norm(sum.force[0] + sum.force[1]), 0.0);
  }
}

TEST(FarPoints, APairOnItsOwnIsTheSame) {
  Random random;
  for (const char* options : {"-pair_points 3", "-pair_points 5 -pair_far_points 2",
                              "-pair_points 3 -pair_far_points 1", "-pair hertz -pair_points 4"}) {
    const auto force = makeForce(options);
    for (double distance = 10.0; distance < 64.0; distance += 0.7) {
      const auto pair = pairAt(distance, random);
      const Sum sum = evaluate(*force, pair);
      const PairAction one = force->resolve(pair[1].x - pair[0].x, pair[0].q, pair[1].q);
      // Sums have a unit: 1e-22 eV, and forceUnit.
      EXPECT_NEAR(one.energy, sum.energy, 1e-11 * std::abs(sum.energy) + 1e-15);
      EXPECT_LT(norm(one.force - sum.force[0]),
                1e-11 * norm(sum.force[0]) + 2 * force->forceUnit());
    }
  }
}

TEST(FarPoints, EveryPairOfALongListIsResolvedOnce) {
  // More pairs of each class than a block holds; the sum over all is that over each alone.
  const auto force = makeForce("-pair_points 3 -pair_far_points 1");
  Random random;
  std::vector<Pose> segments;
  for (int k = 0; k < 60; ++k) segments.push_back({random.vector(25.0), random.orientation()});
  const Sum all = evaluate(*force, segments);
  std::vector<Vec3d> single(segments.size());
  double energy = 0, size = 0;
  std::int64_t resolved = 0, pointPairs = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::size_t j = i + 1; j < segments.size(); ++j) {
      const Sum one = evaluate(*force, {segments[i], segments[j]});
      single[i] += one.force[0];
      single[j] += one.force[1];
      energy += one.energy;
      size += std::abs(one.energy);
      resolved += one.resolved;
      pointPairs += one.pointPairs;
    }
  EXPECT_GT(resolved, 500);
  EXPECT_EQ(all.resolved, resolved);
  EXPECT_EQ(all.pointPairs, pointPairs);
  EXPECT_NEAR(all.energy, energy, 1e-12 * size);
  // Sums are integers: equal, but for the rounding of this test's own sum.
  for (std::size_t i = 0; i < segments.size(); ++i)
    EXPECT_LT(norm(all.force[i] - single[i]), 1e-12 * (1 + norm(single[i])));
}

}  // namespace
}  // namespace nanoweft::test
