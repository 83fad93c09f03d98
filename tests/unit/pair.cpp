/// Every pair law: reference numbers, gradients, conservation, continuity; one set of tests for
/// all.
#include <gtest/gtest.h>

#include <functional>
#include <memory>

#include "helpers.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_kernel.hpp"
#include "nanoweft/force/surface_law.hpp"
#include "nanoweft/force/vdw.hpp"

namespace nanoweft::test {
namespace {

constexpr double length = 13.56;

VdwParameters parameters(bool smooth) {
  VdwParameters p;
  p.smooth = smooth;
  return p;
}

/// resolvePair with the number of points chosen at run time.
template <class Law>
PairResult<double> resolve(const Law& law, int points, const Vec3d& separation, const Quatd& qi,
                           const Quatd& qj) {
  const Vec3d ei = axis1(qi), ej = axis1(qj);
  const KernelUnits units{length, law.cutoff(), 1.0, 1.0, points};
  switch (points) {
    case 1:
      return resolvePair<true, 1>(law, units, separation, ei, ej);
    case 2:
      return resolvePair<true, 2>(law, units, separation, ei, ej);
    case 3:
      return resolvePair<true, 3>(law, units, separation, ei, ej);
    case 4:
      return resolvePair<true, 4>(law, units, separation, ei, ej);
    case 5:
      return resolvePair<true, 5>(law, units, separation, ei, ej);
    case 9:
      return resolvePair<true, 9>(law, units, separation, ei, ej);
    default:
      throw std::logic_error("number of points not instantiated");
  }
}

TEST(Vdw, SpliceAndMinimum) {
  const Vdw smooth(parameters(true)), kink(parameters(false));
  EXPECT_NEAR(smooth.spliceDistance(), 16.313684942742598, 1e-12);
  EXPECT_NEAR(kink.spliceDistance(), 17.343571, 1e-6);
  EXPECT_NEAR(smooth.restDistance(), 17.343571, 1e-6);
  const double r0 = smooth.restDistance();
  EXPECT_NEAR(smooth(r0 * r0).energy, -2.228463, 1e-6);
  EXPECT_NEAR(smooth(r0 * r0).slope, 0.0, 1e-14);
  auto slope = [&](double s) { return smooth((r0 + s) * (r0 + s)).energy; };
  const double h = 1e-3;
  EXPECT_NEAR((slope(h) - 2 * slope(0) + slope(-h)) / (h * h), 5.915, 1e-2);
}

TEST(Vdw, ReferenceCases) {
  const auto rows = readTable("pairs.csv");
  ASSERT_EQ(rows.size(), 240u);
  const PairTable laws[2] = {Vdw(parameters(false)).table(), Vdw(parameters(true)).table()};
  for (const auto& row : rows) {
    const Vec3d separation = vectorAt(row, 9) - vectorAt(row, 2);
    const auto p = resolve(laws[row[1] != 0], static_cast<int>(row[0]), separation,
                           quaternionAt(row, 5), quaternionAt(row, 12));
    const double force = norm(vectorAt(row, 17)),
                 torque = std::max(norm(vectorAt(row, 20)), norm(vectorAt(row, 23)));
    EXPECT_NEAR(p.energy, row[16], 1e-10 * std::max(1e-3, std::abs(row[16])));
    EXPECT_LT(norm(p.force - vectorAt(row, 17)), 1e-10 * std::max(1e-3, force));
    EXPECT_LT(norm(p.torqueI - vectorAt(row, 20)), 1e-10 * std::max(1e-2, torque));
    EXPECT_LT(norm(p.torqueJ - vectorAt(row, 23)), 1e-10 * std::max(1e-2, torque));
  }
}

/// A law and the distances between which pairs of it are drawn.
struct LawCase {
  std::string name;
  std::function<PairResult<double>(int, const Vec3d&, const Quatd&, const Quatd&)> resolve;
  double nearest, farthest;
};

template <class Law>
LawCase lawCase(std::string name, Law law, double nearest, double farthest) {
  auto shared = std::make_shared<Law>(std::move(law));
  return {std::move(name),
          [shared](int n, const Vec3d& d, const Quatd& a, const Quatd& b) {
            return resolve(*shared, n, d, a, b);
          },
          nearest, farthest};
}

PairTable surfaceTable(const std::string& name, const std::vector<double>& values,
                       const Switch& range) {
  for (const SurfaceLawType& type : surfaceLaws())
    if (type.name == name)
      return SurfaceLaw(type.profile(values, 6.78, range), range, 2 * 6.78, length * length)
          .table();
  throw std::logic_error("no law " + name);
}

std::vector<LawCase> allLaws() {
  VdwParameters general = parameters(true);
  general.alpha = 8.7, general.beta = 4.4;
  return {lawCase("vdw_smooth", Vdw(parameters(true)).table(), 10, 60),
          lawCase("vdw_kink", Vdw(parameters(false)).table(), 10, 60),
          lawCase("vdw_general", Vdw(general).table(), 10, 60),
          lawCase("hertz", Hertz(200, 6.78), 3, 14),
          lawCase("hamaker", surfaceTable("hamaker", {0.5, 3.0, 0.01}, {25, 35}), 10, 48),
          lawCase("hydrogen", surfaceTable("hydrogen", {0.02, 2.9, 0.3}, {8, 11}), 10, 24),
          lawCase("capillary", surfaceTable("capillary", {0.0045, 0.5, 400}, {6, 9.2}), 10, 22)};
}

class EveryLaw : public testing::TestWithParam<LawCase> {};

TEST_P(EveryLaw, ForceAndTorqueAreTheGradientOfTheEnergy) {
  const LawCase& law = GetParam();
  Random random;
  for (int points : {1, 2, 3, 5, 9})
    for (int k = 0; k < 8; ++k) {
      const Quatd qi = random.orientation(), qj = random.orientation();
      const Vec3d direction = random.vector(1.0);
      const double distance = law.nearest + (law.farthest - law.nearest) * k / 7.0;
      const Vec3d d = (distance / norm(direction)) * direction;
      const auto p = law.resolve(points, d, qi, qj);
      const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      for (const Vec3d& e : axes) {
        auto moved = [&](double s) { return law.resolve(points, d + s * e, qi, qj).energy; };
        auto turnedI = [&](double s) {
          return law.resolve(points, d, rotation(s * e) * qi, qj).energy;
        };
        auto turnedJ = [&](double s) {
          return law.resolve(points, d, qi, rotation(s * e) * qj).energy;
        };
        EXPECT_NEAR(derivative(moved, 1e-3), dot(p.force, e), 2e-6 * (1 + norm(p.force)));
        EXPECT_NEAR(derivative(turnedI, 1e-4), -dot(p.torqueI, e), 2e-6 * (1 + norm(p.torqueI)));
        EXPECT_NEAR(derivative(turnedJ, 1e-4), -dot(p.torqueJ, e), 2e-6 * (1 + norm(p.torqueJ)));
      }
    }
}

TEST_P(EveryLaw, ConservesAngularMomentumAndTurnsWithTheSpace) {
  const LawCase& law = GetParam();
  Random random;
  for (int k = 0; k < 30; ++k) {
    const Quatd qi = random.orientation(), qj = random.orientation(), turn = random.orientation();
    const Vec3d direction = random.vector(1.0);
    const Vec3d d =
        ((law.nearest + (law.farthest - law.nearest) * k / 40.0) / norm(direction)) * direction;
    const auto p = law.resolve(3, d, qi, qj);
    EXPECT_LT(norm(p.torqueI + p.torqueJ + cross(d, -p.force)),
              1e-12 * (1 + norm(p.torqueI) + norm(p.force) * norm(d)));
    const auto t = law.resolve(3, rotate(turn, d), turn * qi, turn * qj);
    EXPECT_NEAR(t.energy, p.energy, 1e-10 * (1 + std::abs(p.energy)));
    EXPECT_LT(norm(t.force - rotate(turn, p.force)), 1e-9 * (1 + norm(p.force)));
  }
}

TEST_P(EveryLaw, VanishesBeyondItsReachAndIsFiniteAtZeroDistance) {
  const LawCase& law = GetParam();
  Random random;
  const Quatd q = random.orientation();
  const auto far = law.resolve(3, Vec3d{54.24 + length, 0, 0}, q, q);
  EXPECT_EQ(far.energy, 0.0);
  EXPECT_EQ(norm(far.force), 0.0);
  const auto zero = law.resolve(3, Vec3d{0, 0, 0}, q, q);
  EXPECT_TRUE(std::isfinite(zero.energy));
  EXPECT_LT(norm(zero.force), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw, testing::ValuesIn(allLaws()),
                         [](const auto& info) { return info.param.name; });

TEST(Vdw, ForceIsContinuousWhereTheBranchesJoin) {
  for (bool smooth : {true, false}) {
    const Vdw law(parameters(smooth));
    for (double r : {law.spliceDistance(), 40.68, 54.24}) {
      const double below = r * (1 - 1e-9), above = r * (1 + 1e-9);
      const auto a = law(below * below), b = law(above * above);
      EXPECT_NEAR(a.energy, b.energy, 1e-5);
      EXPECT_NEAR(a.slope, b.slope, 1e-6);
    }
  }
}

TEST(PairTable, AgreesWithItsLaw) {
  for (bool smooth : {true, false}) {
    const Vdw law(parameters(smooth));
    const PairTable table = law.table();
    double worstForce = 0, worstEnergy = 0;
    for (double r = 5.0; r < 54.24; r += 0.00737) {
      const auto expected = law(r * r), found = table(r * r);
      // Relative to the size of the law's own two terms, whose difference it is.
      const double d = r / 6.78 - 2.0;
      const double size = r > law.spliceDistance()
                              ? 0.373 / std::pow(d, 4) + 0.00635 / std::pow(d, 9.5)
                              : std::abs(expected.energy) + 1.0;
      worstEnergy = std::max(worstEnergy, std::abs(found.energy - expected.energy) / size);
      worstForce = std::max(worstForce, std::abs(found.slope - expected.slope) * r * 2.75 / size);
      EXPECT_EQ(table.slope(r * r), found.slope);
    }
    EXPECT_LT(worstEnergy, 1e-11);
    EXPECT_LT(worstForce, 1e-11);
    EXPECT_EQ(table(54.3 * 54.3).slope, 0.0);
    EXPECT_EQ(table(1e30).energy, 0.0);
  }
}

TEST(PairTable, EndsWhereItsLawDoesWhateverTheRanges) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(0, 1);
  for (int k = 0; k < 1500; ++k) {
    const double inner = 3 + 40 * any(random), outer = inner * (1.05 + 4 * any(random)),
                 cutoff = outer * (1.02 + 0.6 * any(random) * any(random));
    if ((cutoff * cutoff - outer * outer) / (outer * outer - inner * inner) < 2.0 / 512) continue;
    const auto law = [&](double r) {
      const double x = std::max(0.0, (r - outer) / (cutoff - outer));
      return inner / (r * r) * (1 - x * x * x * (10 - 15 * x + 6 * x * x));
    };
    const PairTable table({inner, outer, cutoff}, law);
    double worst = 0;
    for (int n = 1; n < 200; ++n) {
      const double r = inner * 0.5 + (cutoff - inner * 0.5) * n / 200;
      worst = std::max(worst, std::abs(table.slope(r * r) - law(r)) / law(inner));
    }
    EXPECT_LT(worst, 1e-6) << inner << " " << outer << " " << cutoff;
    for (const double r2 : {cutoff * cutoff, 1.0000001 * cutoff * cutoff, 4 * cutoff * cutoff}) {
      EXPECT_EQ(table.slope(r2), 0.0) << inner << " " << outer << " " << cutoff;
      EXPECT_EQ(table(r2).energy, 0.0) << inner << " " << outer << " " << cutoff;
    }
  }
}

TEST(PairTable, RefusesWhatItCannotHold) {
  const auto flat = [](double) { return 1.0; };
  EXPECT_THROW(PairTable({16, 54.23, 54.24}, flat), InputError);  // a fifth of a part
  EXPECT_THROW(PairTable({16, 15, 54.24}, flat), InputError);
  EXPECT_THROW(PairTable({16, 40, 40}, flat), InputError);
  const PairTable table({16, 40, 54}, flat);
  EXPECT_THROW(table.nearPart(15), InputError);
}

TEST(PairTable, StaysFiniteWhateverComesIn) {
  const PairTable table = Vdw(parameters(true)).table();
  for (double s : {-1e-9, 0.0, 1e-300, 1e-3, 1e300})
    EXPECT_TRUE(std::isfinite(table(s).slope) && std::isfinite(table(s).energy)) << s;
  // Repulsive all the way to zero distance.
  for (double r = 0.0; r < 16.3; r += 0.01) EXPECT_LT(table(r * r).slope, 0.0) << r;
}

TEST(PairTable, LanesGiveTheBitsOfDoubles) {
  const PairTable law = Vdw(parameters(true)).table();
  const PairTable::Kernel lanes(law);
  for (double r = 8.0; r < 56.0; r += 0.37) {
    const auto one = law(r * r);
    // A different distance in each lane.
    const Lanes r2([&](auto k) { return (r + 0.01 * k) * (r + 0.01 * k); });
    const auto many = lanes(r2);
    EXPECT_EQ(many.energy[0], one.energy);
    for (std::size_t k = 0; k < Lanes::size(); ++k) {
      const double s = r2[k];
      EXPECT_EQ(many.energy[k], law(s).energy);
      EXPECT_EQ(many.slope[k], law(s).slope);
    }
  }
}

}  // namespace
}  // namespace nanoweft::test
