/// Single precision of the pair sum against doubles, within what rounding explains.
#ifdef __AVX512F__  // elsewhere it is not offered
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "nanoweft/force/single_table.hpp"
#include "nanoweft/force/vdw.hpp"
#include "pair_sum.hpp"

namespace nanoweft::test {
namespace {

constexpr double epsilon = 0x1p-24;  ///< largest relative error of rounding to single precision

const PairTable& table() {
  static const PairTable made = Vdw(VdwParameters{}).table();
  return made;
}

/// What rounding does to the mean over the points of a pair, when all sums of a point pair's
/// squared distance and of its law make `roundings` errors of the size of their largest term.
struct Rounding {
  double energy = 0, force = 0;
};

Rounding rounding(int n, const Vec3d& d, const Vec3d& ei, const Vec3d& ej) {
  constexpr double roundings = 6;
  const double inner2 = std::pow(table().joins().inner, 2);
  Rounding sum;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const double sa = (a - 0.5 * (n - 1)) / n * length, sb = (b - 0.5 * (n - 1)) / n * length;
      const double r = norm(d + sb * ej - sa * ei);
      // Terms of r^2, of which the inner join's is taken off.
      const double largest = std::abs(dot(d, d) - inner2) + 2 * std::abs(sa * dot(d, ei)) +
                             2 * std::abs(sb * dot(d, ej)) + 2 * std::abs(sa * sb) + sa * sa +
                             sb * sb;
      const double dr = roundings * epsilon * largest / (2 * r);
      auto force = [](double x) { return table().slope(x * x) * x; };
      const double h = 1e-3, stiffness = std::abs(force(r + h) - force(r - h)) / (2 * h);
      // A law's value is the sum of a polynomial, whose terms are larger than it near the steep
      // contact; and where the law ends, as large as at the begin of their part, a quarter of the
      // switch's range of r^2.
      const double begin =
          r > 40.68 ? std::sqrt(r * r - 0.25 * (54.24 * 54.24 - 40.68 * 40.68)) : r;
      const double terms = std::abs(force(begin)) + 0.5 * stiffness;
      sum.force += stiffness * dr + roundings * epsilon * terms;
      sum.energy += std::abs(force(r)) * dr +
                    roundings * epsilon * (std::abs(table()(begin * begin).energy) + 0.5 * terms);
    }
  return {sum.energy / (n * n), sum.force / (n * n)};
}

TEST(Single, IsTheSumInDoublesButForRounding) {
  Random random;
  for (int points = 1; points <= 9; ++points) {
    const std::string options = "-pair_points " + std::to_string(points);
    const auto exact = makeForce(options), single = makeForce(options + " -pair_precision single");
    for (double distance = 14.0; distance < 66.0; distance += 0.31) {
      const auto pair = pairAt(distance, random);
      double closest = exact->closest(pair[1].x - pair[0].x, pair[0].q, pair[1].q);
      if (closest < 12.0) continue;
      const Sum a = evaluate(*exact, pair), b = evaluate(*single, pair);
      const Rounding bound =
          rounding(points, pair[1].x - pair[0].x, axis1(pair[0].q), axis1(pair[1].q));
      const double unit = 2 * exact->forceUnit();
      EXPECT_NEAR(a.energy, b.energy, bound.energy + 1e-15) << points << " " << distance;
      EXPECT_LT(norm(a.force[0] - b.force[0]), bound.force + unit) << points << " " << distance;
      EXPECT_LT(norm(a.torque[0] - b.torque[0]), length * (bound.force + unit));
    }
  }
}

TEST(Single, ForcesAreTheGradientOfTheEnergy) {
  const auto force = makeForce("-pair_points 3 -pair_far_points 1 -pair_precision single");
  Random random;
  for (double distance : {30.0, 32.0, 34.5, 37.0, 39.0}) {  // no contact: differences are accurate
    const auto pair = pairAt(distance, random);
    const Sum sum = evaluate(*force, pair);
    ASSERT_GT(norm(sum.force[0]), 1e-5);
    // The energy's rounding over the interval, with 0.05 A (rad) for the smallest.
    const Rounding bound = rounding(3, pair[1].x - pair[0].x, axis1(pair[0].q), axis1(pair[1].q));
    const double allowed = 4 * bound.energy / 0.05 + 1e-5 * norm(sum.force[0]);
    for (const Vec3d& e : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
      const double slope = derivative(
          [&](double s) {
            auto moved = pair;
            moved[0].x += s * e;
            return evaluate(*force, moved).energy;
          },
          0.1);
      EXPECT_NEAR(slope, -dot(sum.force[0], e), allowed) << distance;
    }
  }
}

TEST(Single, ConservesMomentumAndAngularMomentumAsInDoubles) {
  const auto force = makeForce("-pair_points 5 -pair_precision single");
  Random random;
  for (double distance = 16.0; distance < 60.0; distance += 1.3) {
    const auto pair = pairAt(distance, random);
    const Sum sum = evaluate(*force, pair);
    const double size = norm(sum.torque[0]) + distance * norm(sum.force[0]);
    if (distance < 40) {
      ASSERT_GT(size, 1e-4);
    }
    EXPECT_EQ(norm(sum.force[0] + sum.force[1]), 0.0);
    EXPECT_LT(norm(sum.torque[0] + sum.torque[1] + cross(pair[1].x - pair[0].x, sum.force[1])),
              1e-12 * size + 100 * force->torqueUnit());
  }
}

TEST(Single, TheTableIsFiniteAndEndsAtTheCutoff) {
  const SingleTable single(table());
  const auto origin = static_cast<float>(single.origin());
  for (float s : {-1e-3f - origin, -origin, 0.0f, 1e30f, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_TRUE(std::isfinite(single(s).slope) && std::isfinite(single(s).energy)) << s;
  const double cutoff2 = 54.24 * 54.24;
  EXPECT_NEAR(single.origin() + single.cutoff2(), cutoff2, cutoff2 * 4 * epsilon);
  EXPECT_EQ(single.slope(single.cutoff2()), 0.0f);
  EXPECT_EQ(single(1e30f).energy, 0.0f);
  for (float r = 0.0f; r < 16.3f; r += 0.01f) EXPECT_LT(single.slope(r * r - origin), 0.0f) << r;
}

TEST(Single, LanesGiveTheBitsOfFloats) {
  const SingleTable single(table());
  const SingleTable::Kernel lanes(single);
  for (float r = 8.0f; r < 56.0f; r += 0.37f) {
    const Floats r2([&](auto k) { return (r + 0.01f * k) * (r + 0.01f * k) - 266.0f; });
    const auto many = lanes(r2);
    for (std::size_t k = 0; k < Floats::size(); ++k) {
      const float s = r2[k];
      EXPECT_EQ(many.energy[k], single(s).energy);
      EXPECT_EQ(many.slope[k], single(s).slope);
    }
  }
}

}  // namespace
}  // namespace nanoweft::test
#endif
