/// A law split into a near part with many points and a far part with few: the whole of PairForce.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "nanoweft/force/vdw.hpp"
#include "pair_sum.hpp"

namespace nanoweft::test {
namespace {

TEST(FarPoints, TheFarPartIsTheLawBeyondAndASpringWithin) {
  const auto few = makeForce("-pair_points 1"),
             both = makeForce("-pair_points 3 -pair_far_points 1 -pair_far_from 24");
  Random random;
  // No points are within the near part's range.
  for (double distance : {37.0, 45.0, 54.0, 60.0}) {
    const auto pair = pairAt(distance, random);
    const Sum split = evaluate(*both, pair), plain = evaluate(*few, pair);
    EXPECT_NEAR(split.energy, plain.energy, 1e-11 * std::abs(plain.energy) + 1e-15);
    EXPECT_LT(norm(split.force[0] - plain.force[0]),
              1e-11 * norm(plain.force[0]) + 2 * both->forceUnit());
    EXPECT_EQ(norm(split.torque[0]), 0.0);
  }
  EXPECT_DOUBLE_EQ(both->reach(), 54.24);
}

TEST(FarPoints, BothPartsAddUpToTheLaw) {
  const PairTable law = Vdw(VdwParameters{}).table();
  const PairTable near = law.nearPart(24), far = law.farPart(24);
  for (double r = 6.0; r < 56.0; r += 0.13) {
    const auto u = law(r * r), n = near(r * r), f = far(r * r);
    EXPECT_NEAR(n.slope + f.slope, u.slope, 1e-10 * std::abs(u.slope) + 1e-14) << r;
    EXPECT_NEAR(n.energy + f.energy, u.energy, 1e-10 * std::abs(u.energy) + 1e-12) << r;
    if (r < 24) {
      EXPECT_DOUBLE_EQ(f.slope, law.slope(24.0 * 24.0)) << r;
    } else if (r > 24.001) {
      EXPECT_EQ(n.slope, 0.0) << r;
      EXPECT_EQ(n.energy, 0.0) << r;
    }
  }
}

/// Energy per length of two endless straight fibres `distance` apart, the second shifted along.
double energyOfTwo(const PairForce& force, double distance, double shift) {
  double sum = 0;
  for (int k = -5; k <= 5; ++k)
    sum += force.resolve({k * length + shift, distance, 0}, Quatd{}, Quatd{}).energy;
  return sum / length;
}

TEST(FarPoints, FibresSlideAlongEachOtherWithoutCorrugation) {
  const auto force = makeForce("");
  double least = 0, most = -1;
  for (int k = 0; k < 32; ++k) {
    const double energy = energyOfTwo(*force, 17.0716, k * length / 32);
    least = std::min(least, energy);
    most = std::max(most, energy);
  }
  EXPECT_LT(most - least, 0.001 * 0.193731);
  // The limit of many points (model.md 4.1).
  EXPECT_NEAR(least, -0.193731, 0.001 * 0.193731);
}

TEST(FarPoints, ForceAndTorqueAreTheGradientOfTheEnergy) {
  const auto force = makeForce("-pair_points 4 -pair_far_points 2 -pair_far_from 24");
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
