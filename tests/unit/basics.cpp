/// Units, random numbers, exact sums, rotations, periodic boxes, hash map.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "helpers.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/index_map.hpp"
#include "nanoweft/base/normal_lanes.hpp"
#include "nanoweft/base/petsc_names.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/fibre/presets.hpp"
#include "nanoweft/force/bond_list.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft::test {
namespace {

TEST(PetscNames, AreThoseOfItsOwnOptionsAndNotAllThatBeginSo) {
  for (const char* own : {"log_view", "draw_pause", "draw_save", "options_left"})
    EXPECT_TRUE(belongsToPetsc(own)) << own;
  for (const char* other : {"dm_nonsense", "draw_", "draw_nonsense", "weave_fibres"})
    EXPECT_FALSE(belongsToPetsc(other)) << other;
  EXPECT_TRUE(beginsPetscOptions("draw"));
  EXPECT_FALSE(beginsPetscOptions("drawn"));
}

TEST(Units, CodataConversions) {
  EXPECT_NEAR(nanoUnits().mass, 103.642697, 1e-6);         // eV fs^2/A^2 per amu
  EXPECT_NEAR(nanoUnits().gigapascal, 6.241509e-3, 1e-9);  // eV/A^3 per GPa
  // 1 eV in J follows from both systems' masses and lengths.
  EXPECT_NEAR(nanoUnits().mass * codata::electronvolt * 1e-10, codata::atomicMass, 1e-36);
}

TEST(Material, TableOneOfThePaper) {
  const Fibre f = cnt1010(nanoUnits());
  EXPECT_NEAR(f.crossSection(), 142.7, 0.05);
  EXPECT_NEAR(f.secondMoment(), 3480, 0.5);
  EXPECT_NEAR(f.bond.stretch, 67.59, 0.005);
  EXPECT_NEAR(f.bond.shear, 19780, 5);
  EXPECT_NEAR(f.bond.bending, -4032, 0.5);
  EXPECT_NEAR(f.bond.torsion, 1471, 0.5);
  EXPECT_NEAR(f.inertia / nanoUnits().mass, 1.218e5, 50);
  EXPECT_NEAR(f.bendingRigidity(), 22352, 1);
  EXPECT_NEAR(f.torsionalRigidity(), 19941, 1);
}

TEST(Material, SameTubeInSiUnits) {
  const Fibre nano = cnt1010(nanoUnits()), si = cnt1010(siUnits());
  const double e = codata::electronvolt;
  EXPECT_NEAR(si.bond.stretch / (nano.bond.stretch * e / 1e-20), 1.0, 1e-12);
  EXPECT_NEAR(si.bond.shear / (nano.bond.shear * e), 1.0, 1e-12);
  EXPECT_NEAR(si.mass / (nano.mass * e * 1e-10), 1.0, 1e-12);
}

TEST(Material, SolidRoundFibre) {
  Fibre f;
  f.radius = 2.0, f.wall = 0, f.young = 3.0, f.shear = 1.0, f.mass = 5.0, f.length = 4.0;
  f.derive();
  const double pi = std::numbers::pi;
  EXPECT_NEAR(f.crossSection(), 4 * pi, 1e-12);
  EXPECT_NEAR(f.secondMoment(), 4 * pi, 1e-12);
  EXPECT_NEAR(f.inertia, 10.0, 1e-12);
  EXPECT_NEAR(f.bond.stretch, 3 * 4 * pi / 4, 1e-12);
  EXPECT_NEAR(0.25 * f.bond.shear + f.bond.bending + 0.5 * f.bond.torsion, 3 * pi, 1e-12);  // EJ/T
}

TEST(Random, PhiloxKnownAnswers) {
  // From the authors' Random123 distribution (kat_vectors, philox4x32 10 rounds).
  using Counter = std::array<std::uint32_t, 4>;
  using Key = std::array<std::uint32_t, 2>;
  const auto zero = philox(Counter{}, Key{});
  EXPECT_EQ(zero, (Counter{0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u}));
  const auto ones = philox(Counter{~0u, ~0u, ~0u, ~0u}, Key{~0u, ~0u});
  EXPECT_EQ(ones, (Counter{0x408f276du, 0x41c83b0eu, 0xa20bc7c6u, 0x6d5451fdu}));
  const auto pi = philox(Counter{0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u},
                         Key{0xa4093822u, 0x299f31d0u});
  EXPECT_EQ(pi, (Counter{0xd16cfe09u, 0x94fdccebu, 0x5001e420u, 0x24126ea1u}));
}

TEST(Random, NormalMoments) {
  double sum = 0, square = 0, fourth = 0;
  constexpr int n = 200000;
  for (int k = 0; k < n; ++k) {
    const double x =
        normalDraw(7, Purpose::breakage, k / 1000, static_cast<std::uint32_t>(k % 1000));
    sum += x, square += x * x, fourth += x * x * x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 5 / std::sqrt(n));
  EXPECT_NEAR(square / n, 1.0, 5 * std::sqrt(2.0 / n));
  EXPECT_NEAR(fourth / n, 3.0, 5 * std::sqrt(96.0 / n));
}

TEST(Random, NormalNumbersOfLanesAreThoseOfTheirCounters) {
  constexpr std::uint64_t seed = 0x123456789abcdefull;
  constexpr int groups = 20000;
  double sum = 0, square = 0, fourth = 0, mixed = 0;
  for (int g = 0; g < groups; ++g) {
    std::int64_t fibre[laneCount];
    std::int32_t index[laneCount];
    for (int k = 0; k < laneCount; ++k) fibre[k] = 77'777'777'777ll * g - k, index[k] = g % 100 + k;
    const Vec3<Lanes> normal = normalTriples(seed, Purpose::heatSpin, fibre, index);
    for (std::size_t k = 0; k < laneCount; ++k) {
      const double x[3] = {normal.x[k], normal.y[k], normal.z[k]};
      for (const double v : x) sum += v, square += v * v, fourth += v * v * v * v;
      mixed += x[0] * x[0] * x[1] * x[1] - 1;
      if (g >= 100) continue;
      const auto bits =
          randomBits(seed, Purpose::heatSpin, fibre[k], static_cast<std::uint32_t>(index[k]));
      const double u = (static_cast<std::int32_t>(bits[0]) + 0x1p31 + 0.5) * 0x1p-32;
      EXPECT_NEAR(std::hypot(x[0], x[1]), std::sqrt(-2 * std::log(u)), 1e-10);
      // Four times the angle forgets in which quarter of the circle it was.
      const double part = (static_cast<std::int32_t>(bits[1] << 2) + 2.0) * 0x1p-32;
      EXPECT_NEAR(std::cos(4 * std::atan2(x[1], x[0])), std::cos(2 * std::numbers::pi * part),
                  1e-9);
    }
  }
  constexpr double n = 3.0 * groups * laneCount;
  EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n));
  EXPECT_NEAR(square / n, 1, 5 * std::sqrt(2 / n));
  EXPECT_NEAR(fourth / n, 3, 5 * std::sqrt(96 / n));
  EXPECT_NEAR(mixed / n, 0, 5 * std::sqrt(8 / (3 * n)));
}

TEST(Random, CriticalStrainsPerBondOrFibre) {
  BreakageLaw law;
  EXPECT_NE(law.criticalStrain(3, 0, 100), law.criticalStrain(3, 1, 100));
  law.perFibre = true;
  EXPECT_EQ(law.criticalStrain(3, 0, 100), law.criticalStrain(3, 1, 100));
  EXPECT_NE(law.criticalStrain(3, 0, 100), law.criticalStrain(4, 0, 100));
}

TEST(ExactSum, DoesNotDependOnOrder) {
  Random random;
  std::vector<double> terms;
  for (int k = 0; k < 10000; ++k)
    terms.push_back(random.normal(1.0) * std::pow(10.0, random.normal(1.0)));
  const SumUnit unit(10.0);
  auto sum = [&] {
    ExactSum s;
    for (double t : terms) s.add(t, unit);
    return s.value(unit);
  };
  const double first = sum();
  std::shuffle(terms.begin(), terms.end(), random.engine);
  EXPECT_EQ(sum(), first);
  // Split in two and merged.
  ExactSum a, b;
  for (std::size_t k = 0; k < terms.size(); ++k) (k % 3 ? a : b).add(terms[k], unit);
  a.merge(b);
  EXPECT_EQ(a.value(unit), first);
}

TEST(ExactSum, KeepsSmallTermsBesideLargeOnes) {
  const SumUnit unit(1.0);
  ExactSum s;
  s.add(1e5, unit);
  s.add(1e-12, unit);
  s.add(-1e5, unit);
  EXPECT_NEAR(s.value(unit), 1e-12, 1e-21);
  s.add(std::nan(""), unit);
  EXPECT_TRUE(std::isnan(s.value(unit)));
}

TEST(Rotation, MatchesRodriguesForSmallAndLargeAngles) {
  Random random;
  for (double angle : {1e-9, 1e-3, 0.19, 0.21, 1.0, 3.0}) {
    const Vec3d v = random.vector(1.0);
    const Vec3d axis = (1.0 / norm(v)) * v;
    const Quatd q = rotation(angle * axis);
    const Vec3d x = random.vector(1.0), turned = rotate(q, x);
    const Vec3d expected = std::cos(angle) * x + std::sin(angle) * cross(axis, x) +
                           ((1 - std::cos(angle)) * dot(axis, x)) * axis;
    EXPECT_NEAR(norm(turned - expected), 0.0, 1e-14 * norm(x) * 10);
    EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1.0, 1e-15 * 4);
  }
}

TEST(Rotation, QuaternionFromAxesInverts) {
  Random random;
  for (int k = 0; k < 100; ++k) {
    const Quatd q = random.orientation(), p = quaternionFromAxes(axis1(q), axis2(q), axis3(q));
    EXPECT_NEAR(std::abs(q.w * p.w + q.x * p.x + q.y * p.y + q.z * p.z), 1.0, 1e-14);
  }
}

TEST(Box, WrapsAndCounts) {
  Box box;
  box.lower = {-1, 0, 0}, box.upper = {3, 1, 1}, box.periodic = {true, false, true};
  double x[3] = {-9.5, 7.0, 1.0};
  std::int32_t image[3] = {0, 0, 0};
  box.wrap(x, image);
  EXPECT_DOUBLE_EQ(x[0], 2.5);
  EXPECT_EQ(image[0], -3);
  EXPECT_EQ(x[1], 7.0);
  EXPECT_DOUBLE_EQ(x[2], 0.0);  // the upper face is the lower face
  EXPECT_EQ(image[2], 1);
  double tiny[3] = {-1 - 1e-18, 0, -1e-18};
  box.wrap(tiny, image);
  EXPECT_LT(tiny[2], 1.0);
  EXPECT_GE(tiny[2], 0.0);
}

TEST(Box, MinimumImageIsExactlyAntisymmetric) {
  Box box;
  box.lower = {0, 0, 0}, box.upper = {7.3, 5.1, 1}, box.periodic = {true, true, false};
  const MinimumImage nearest(box);
  Random random;
  for (int k = 0; k < 1000; ++k) {
    const Vec3d a = random.vector(5.0), b = random.vector(5.0);
    const Vec3d ab = nearest(b - a), ba = nearest(a - b);
    EXPECT_EQ(ab.x, -ba.x);
    EXPECT_EQ(ab.y, -ba.y);
    EXPECT_EQ(ab.z, -ba.z);
    EXPECT_LE(std::abs(ab.x), 7.3 / 2 + 1e-12);
    EXPECT_EQ(ab.z, b.z - a.z);
  }
}

TEST(IndexMap, FindsWhatWasPutIn) {
  IndexMap map(2);
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(map.insert(std::int64_t{977} * k, k), k);
  EXPECT_EQ(map.insert(977, 5), 1);
  for (int k = 0; k < 1000; ++k) EXPECT_EQ(map.at(std::int64_t{977} * k), k);
  EXPECT_EQ(map.at(5), -1);
}

TEST(IndexMap, FindsTheSameAsAnArrayAndHashed) {
  for (std::int64_t spacing : {1, 3, 1000}) {
    const std::int64_t first = 1'000'000'000'000;
    IndexMap map(100, first, first + 99 * spacing);
    for (int k = 0; k < 100; k += 2) EXPECT_EQ(map.insert(first + spacing * k, k), k);
    EXPECT_EQ(map.insert(first + 2 * spacing, 7), 2);
    for (int k = 0; k < 100; ++k) EXPECT_EQ(map.at(first + spacing * k), k % 2 ? -1 : k);
    for (std::int64_t key : {std::int64_t{0}, first - 1, first + 100 * spacing})
      EXPECT_EQ(map.at(key), -1);
  }
}

}  // namespace
}  // namespace nanoweft::test
