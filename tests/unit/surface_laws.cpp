/// Surface laws: reference numbers, and crossed and parallel fibres with the points that the
/// program chooses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "helpers.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "pair_sum.hpp"

namespace nanoweft::test {
namespace {

constexpr double pi = std::numbers::pi;

PairForces read(const std::string& text) {
  petsc(PetscOptionsClear(nullptr));
  petsc(PetscOptionsInsertString(nullptr, text.c_str()));
  Options options;
  const Kinds kinds = readKinds(options, nanoUnits());
  PairForces pairs = readPairForces(options, nanoUnits(), kinds);
  options.refuseUnknown();
  petsc(PetscOptionsClear(nullptr));
  return pairs;
}

const std::string threeKinds =
    "-kinds cnt,thin,thick -cnt_pair_points 3 -thin_fibre_radius 3.39 -thin_fibre_density 2000 "
    "-thin_fibre_segment_length 6.78 -thin_pair_points 2 -thick_fibre_radius 20 "
    "-thick_fibre_density 2000 -thick_fibre_segment_length 30 -thick_pair_points 5 ";

TEST(SurfaceLaws, PairsOfThreeKindsAgreeWithFiftyDigits) {
  const PairForces laws[3] = {
      read(threeKinds + "-pair hamaker -hamaker_constant 0.5 -hamaker_gap 3 -hamaker_stiffness 2 "
                        "-pair_gap_switch 25 -pair_gap_cutoff 35"),
      read(threeKinds +
           "-pair hydrogen -hydrogen_energy 0.02 -hydrogen_gap 2.9 -hydrogen_stiffness 1 "
           "-pair_gap_switch 8 -pair_gap_cutoff 11"),
      read(threeKinds +
           "-pair capillary -capillary_tension 0.0045 -capillary_angle 0.5 -capillary_volume 400 "
           "-pair_gap_switch 6 -pair_gap_cutoff 9.2")};
  const auto rows = readTable("surface_pairs.csv");
  ASSERT_EQ(rows.size(), 60u);
  for (const auto& row : rows) {
    const int i = static_cast<int>(row[1]), j = static_cast<int>(row[2]);
    const auto& classes = laws[static_cast<std::size_t>(row[0])].classes();
    const auto found =
        std::ranges::find_if(classes, [&](const auto& c) { return c.between(i, j); });
    ASSERT_NE(found, classes.end());
    std::vector<Pose> segments{{vectorAt(row, 3), quaternionAt(row, 6)},
                               {vectorAt(row, 10), quaternionAt(row, 13)}};
    const bool swapped = found->first != i;
    if (swapped) std::swap(segments[0], segments[1]);
    const double energy = row[17], force = norm(vectorAt(row, 18)),
                 torque = std::max(norm(vectorAt(row, 21)), norm(vectorAt(row, 24)));
    const PairAction one =
        found->force->resolve(segments[1].x - segments[0].x, segments[0].q, segments[1].q);
    EXPECT_NEAR(one.energy, energy, 1e-10 * std::max(1e-3, std::abs(energy)));
    EXPECT_LT(norm((swapped ? -one.force : one.force) - vectorAt(row, 18)),
              1e-10 * std::max(1e-3, force));
    // In the run sums are multiples of units, which the stiffest pair decides for all kinds.
    const Sum sum = evaluate(*found->force, segments);
    const std::size_t first = swapped ? 1 : 0;
    EXPECT_NEAR(sum.energy, energy, 1e-10 * std::max(1e-3, std::abs(energy)));
    EXPECT_LT(norm(sum.force[first] - vectorAt(row, 18)),
              1e-10 * std::max(1e-3, force) + 2 * found->force->forceUnit());
    const double error = 1e-10 * std::max(1e-2, torque) + 2 * found->force->torqueUnit();
    EXPECT_LT(norm(sum.torque[first] - vectorAt(row, 21)), error);
    EXPECT_LT(norm(sum.torque[1 - first] - vectorAt(row, 24)), error);
  }
}

/// Energy of an endless fibre with the middle segment of another one, and the force on that.
/// `slide`: shifts of both along themselves, in segments.
struct Rows {
  const PairForce& force;
  double length;

  PairAction crossed(double distance, double slideA, double slideB) const {
    PairAction sum;
    const int half = count();
    const Quatd a{1, 0, 0, 0}, b = rotation({0, 0, 0.5 * pi});
    for (int i = -half; i <= half; ++i)
      for (int j = -half; j <= half; ++j) {
        const PairAction one =
            force.resolve({-(i + slideA) * length, (j + slideB) * length, distance}, a, b);
        sum.energy += one.energy;
        sum.force += one.force;
      }
    return sum;
  }
  /// Energy per length of two parallel ones.
  double parallel(double distance, double slide) const {
    double sum = 0;
    const Quatd along{1, 0, 0, 0};
    for (int k = -count(); k <= count(); ++k)
      sum += force.resolve({(k + slide) * length, 0, distance}, along, along).energy;
    return sum / length;
  }
  int count() const { return static_cast<int>(std::sqrt(2 * force.cutoff() * 60) / length) + 3; }
};

/// Fibres of 60 A in segments of 30 A.
const std::string fibre = "-fibre_radius 60 -fibre_density 2000 -fibre_segment_length 30 ";
const double radius = 60;

const std::string hydrogen = fibre + "-pair hydrogen -hydrogen_energy 0.02 -hydrogen_gap 2.9 ";
const std::string hamaker =
    fibre + "-pair hamaker -hamaker_constant 0.5 -hamaker_gap 3 -pair_gap_cutoff 36 ";

double hydrogenEnergy(double gap, double stiffness) {
  const double s = 2.9 / gap;
  return gap > 2.9 ? 0.02 * (5 * std::pow(s, 12) - 6 * std::pow(s, 10))
                   : -0.02 + 0.5 * stiffness * (gap - 2.9) * (gap - 2.9);
}
double hamakerEnergy(double gap, double stiffness) {
  const double s = 3 / gap;
  return gap > 3 ? -0.5 / (12 * pi * gap * gap) * (1 - std::pow(s, 6) / 4)
                 : -0.5 / (16 * pi * 9) + 0.5 * stiffness * (gap - 3) * (gap - 3);
}

/// Two fibres crossed at a right angle attract each other by 2 pi R e, wherever they are along
/// themselves.
void expectDerjaguin(const std::string& options, const std::function<double(double)>& energy,
                     std::initializer_list<double> gaps) {
  const PairForces pairs = read(options);
  const Rows rows{*pairs.classes()[0].force, 30};
  const double pullOff = 2 * pi * radius * std::abs(energy(*gaps.begin()));
  for (const double gap : gaps)
    for (const double slide : {0.0, 0.013, 0.27}) {
      const Vec3d force = rows.crossed(2 * radius + gap, slide, 1.7 * slide).force;
      // `force` acts on the lower fibre.
      EXPECT_NEAR(-force.z, 2 * pi * radius * energy(gap), 0.015 * pullOff) << gap;
      EXPECT_LT(std::hypot(force.x, force.y), 0.015 * pullOff) << gap;
    }
}

TEST(SurfaceLaws, CrossedFibresHaveDerjaguinsForceWithThePointsThatTheProgramChooses) {
  expectDerjaguin(hamaker, [](double g) { return hamakerEnergy(g, 0.5 / (pi * 81)); },
                  {3.0, 2.2, 4.0, 8.0});
  expectDerjaguin(hamaker + "-hamaker_stiffness 0.05",
                  [](double g) { return hamakerEnergy(g, 0.05); }, {3.0, 2.8, 4.0});
  expectDerjaguin(hydrogen, [](double g) { return hydrogenEnergy(g, 2.4 / (2.9 * 2.9)); },
                  {2.9, 2.6, 3.3, 5.0});
  expectDerjaguin(hydrogen + "-hydrogen_stiffness 2", [](double g) { return hydrogenEnergy(g, 2); },
                  {2.9, 2.8, 3.3});
}

TEST(SurfaceLaws, HydrogenBondsEndWhereTheManualSays) {
  EXPECT_NEAR(read(hydrogen).classes()[0].force->cutoff(), 2 * radius + 3.75 * 2.9, 1e-9);
}

TEST(SurfaceLaws, ABridgePullsCrossedFibresAsMeasured) {
  const double tension = 0.0045, volume = 20000, angle = 0.5;
  const PairForces pairs = read(fibre +
                                "-pair capillary -capillary_tension 0.0045 -capillary_angle 0.5 "
                                "-capillary_volume 20000");
  const PairForce& law = *pairs.classes()[0].force;
  EXPECT_NEAR(law.cutoff(), 2 * radius + 1.25 * std::cbrt(volume), 1e-9);
  const Rows rows{law, 30};
  const double pull = 4 * pi * tension * std::cos(angle) * radius, b = volume / (pi * radius);
  auto energy = [&](double g) { return -pull * (std::sqrt(g * g + b) - g); };
  for (const double gap : {0.0, 3.0, 10.0, 20.0})
    for (const double slide : {0.0, 0.27}) {
      const PairAction found = rows.crossed(2 * radius + gap, slide, 1.7 * slide);
      EXPECT_NEAR(found.force.z, pull * (1 - gap / std::sqrt(gap * gap + b)), 0.03 * pull) << gap;
      EXPECT_NEAR(found.energy, energy(gap), 0.01 * std::abs(energy(0))) << gap;
    }
  // While it is switched off, against 2 pi d w(d).
  for (const double gap : {26.0, 28.0, 30.0, 32.0})
    for (const double slide : {0.0, 0.27}) {
      const double d = 2 * radius + gap;
      const double w = law.average(1, {0, 0, d}, {1, 0, 0}, {1, 0, 0}).energy / (30 * 30);
      EXPECT_NEAR(rows.crossed(d, slide, 1.7 * slide).force.z, -2 * pi * d * w, 0.07 * pull) << gap;
    }
}

/// int e(g + s^2/(2 d)) ds of e = g^-n, in units of sqrt(2 pi d).
double power(double g, int n) {
  return std::pow(g, 0.5 - n) * std::exp(std::lgamma(n - 0.5) - std::lgamma(n));
}

TEST(SurfaceLaws, ParallelFibresHaveDerjaguinsAdhesion) {
  // Derjaguin holds for gaps far below the radius: to a share of gap/(2 R) here.
  const std::string thick = "-fibre_radius 3000 -fibre_density 2000 -fibre_segment_length 400 ";
  const double both = std::sqrt(2 * pi * 6000) * 3000 / 6000;
  struct Case {
    std::string law;
    double gap, adhesion;
  };
  const Case cases[] = {
      {"-pair hydrogen -hydrogen_energy 0.02 -hydrogen_gap 2.9 -pair_gap_cutoff 15", 2.9,
       0.02 * both *
           (5 * std::pow(2.9, 12) * power(2.9, 12) - 6 * std::pow(2.9, 10) * power(2.9, 10))},
      // Cut off at 400 A: a share of 1e-3 of the adhesion lies beyond.
      {"-pair hamaker -hamaker_constant 0.5 -hamaker_gap 3 -pair_gap_cutoff 400", 3,
       -0.5 / (12 * pi) * both * (power(3, 2) - std::pow(3.0, 6) / 4 * power(3, 8))}};
  for (const Case& c : cases) {
    const PairForces pairs = read(thick + c.law);
    const Rows rows{*pairs.classes()[0].force, 400};
    for (const double slide : {0.0, 0.013, 0.27})
      EXPECT_NEAR(rows.parallel(6000 + c.gap, slide) / c.adhesion, 1.0, 3e-3) << c.law;
  }
}

TEST(SurfaceLaws, LawsWithCommasBetweenAddAndEachHasItsOwnPoints) {
  const std::string wet =
      "-capillary_tension 0.0045 -capillary_volume 400 -capillary_angle 0.5 -pair ";
  const PairForces sum = read(wet + "capillary,vdw"), one = read("-pair vdw"),
                   other = read(wet + "capillary");
  ASSERT_EQ(sum.classes().size(), 2u);
  const auto &vdw = sum.classes()[0], &capillary = sum.classes()[1];
  EXPECT_EQ(vdw.force->description(), one.classes()[0].force->description());
  EXPECT_EQ(vdw.force->points().near, one.classes()[0].force->points().near);
  EXPECT_EQ(capillary.force->points().near, other.classes()[0].force->points().near);
  EXPECT_TRUE(vdw.widest);
  EXPECT_FALSE(capillary.widest);
  EXPECT_EQ(sum.between(0, 0), vdw.force.get());
  EXPECT_DOUBLE_EQ(*sum.restDistance(0, 0), *one.restDistance(0, 0));
  EXPECT_TRUE(sum.keepsApart(0, 0));
  EXPECT_FALSE(other.keepsApart(0, 0));
  Random random;
  const auto pair = pairAt(18, random);
  EXPECT_NEAR(evaluate(*capillary.force, pair).energy,
              evaluate(*other.classes()[0].force, pair).energy, 1e-14);
}

TEST(SurfaceLaws, BetweenKindsConstantsHaveGeometricAndGapsArithmeticMeans) {
  const PairForces pairs = read(
      "-kinds a,b -pair hamaker -pair_gap_cutoff 40 -a_a_hamaker_constant 0.4 "
      "-b_b_hamaker_constant 0.9 -a_a_hamaker_gap 3 -b_b_hamaker_gap 4");
  const std::string between = pairs.between(0, 1)->description();
  EXPECT_NE(between.find("constant 0.6 eV, gap 3.5 A"), std::string::npos) << between;
}

}  // namespace
}  // namespace nanoweft::test
