/// Pairs far apart with fewer points: the whole of PairForce, with its sifting of the list.
#include <gtest/gtest.h>

#include <functional>

#include "pair_sum.hpp"

namespace nanoweft::test {
namespace {

TEST(FarPoints, ManyPointsNearFewFar) {
  const auto near = makeForce("-pair_points 3"), far = makeForce("-pair_points 1"),
             both = makeForce(
                 "-pair_points 3 -pair_far_points 1 -pair_far_from 33.9 -pair_far_width 6.78");
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
      ASSERT_GT(size, 1e-4);
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
