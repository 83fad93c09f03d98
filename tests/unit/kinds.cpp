/// Several kinds of fibre: options with prefixes, and the pair forces between kinds.
#include "nanoweft/fibre/kinds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "helpers.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "pair_sum.hpp"

namespace nanoweft::test {

namespace {

struct Read {
  Kinds kinds;
  PairForces pairs;
  Breakage breakage;
};

Read readAll(const std::string& text) {
  petsc(PetscOptionsClear(nullptr));
  petsc(PetscOptionsInsertString(nullptr, text.c_str()));
  Options options;
  Read read;
  read.kinds = readKinds(options, nanoUnits());
  read.pairs = readPairForces(options, nanoUnits(), read.kinds);
  read.breakage = readBreakageOf(read.kinds, options, nanoUnits(), 1);
  options.refuseUnknown();
  petsc(PetscOptionsClear(nullptr));
  return read;
}

std::string problemWith(const std::string& text) {
  try {
    readAll(text);
    return "";
  } catch (const InputError& problem) {
    petsc(PetscOptionsClear(nullptr));
    return problem.what();
  }
}

const std::string three =
    "-kinds cnt,thin,thick -cnt_pair_points 3 -thin_fibre_radius 3.39 -thin_fibre_density 2000 "
    "-thin_fibre_segment_length 6.78 -thin_pair_points 2 -thick_fibre_radius 20 "
    "-thick_fibre_density 2000 -thick_fibre_segment_length 30 -thick_pair_points 5 ";

}  // namespace

TEST(Kinds, AnOptionForAllMayServeSome) {
  const Read kinks =
      readAll("-kinds a,b -fibre_kink_stiffness 0.1 -a_fibre_kink_curvature 0.0036 -pair none");
  EXPECT_TRUE(kinks.kinds[0].kinks());
  EXPECT_FALSE(kinks.kinds[1].kinks());
  const Read soft =
      readAll("-kinds a,b -fibre_young 500 -a_fibre_bond_stiffness 60,20,-4,1.5 -pair none");
  EXPECT_DOUBLE_EQ(soft.kinds[0].bond.stretch, 60);
  EXPECT_FALSE(soft.kinds[0].elastic);
  EXPECT_DOUBLE_EQ(soft.kinds[1].young, 500 * nanoUnits().gigapascal);
  readAll(
      "-kinds a,b -pair_points 4 -a_a_pair contact -a_b_pair contact -a_a_contact_modulus 20 "
      "-a_b_contact_modulus 20");
  const std::string problem =
      problemWith("-kinds a,b -a_fibre_kink_stiffness 0.1 -b_fibre_kink_curvature 0.0036");
  EXPECT_NE(problem.find("-a_fibre_kink_stiffness"), std::string::npos) << problem;
}

TEST(Kinds, PairsOfThreeKindsAgreeWithFiftyDigits) {
  const Read read = readAll(three + "-pair_gap_switch 27.12 -pair_gap_cutoff 40.68");
  const auto rows = readTable("pairs_of_kinds.csv");
  ASSERT_EQ(rows.size(), 60u);
  for (const auto& row : rows) {
    const int kinds[2] = {static_cast<int>(row[0]), static_cast<int>(row[1])};
    const PairForces::Class* found = nullptr;
    for (const auto& c : read.pairs.classes())
      if ((c.first == kinds[0] && c.second == kinds[1]) ||
          (c.first == kinds[1] && c.second == kinds[0]))
        found = &c;
    ASSERT_TRUE(found);
    const bool swapped = found->first != kinds[0];
    std::vector<Pose> segments{{vectorAt(row, 2), quaternionAt(row, 5)},
                               {vectorAt(row, 9), quaternionAt(row, 12)}};
    if (swapped) std::swap(segments[0], segments[1]);
    const Sum sum = evaluate(*found->force, segments);
    const std::size_t i = swapped ? 1 : 0, j = 1 - i;
    const double energy = row[16], force = norm(vectorAt(row, 17)),
                 torque = std::max(norm(vectorAt(row, 20)), norm(vectorAt(row, 23)));
    EXPECT_NEAR(sum.energy, energy, 1e-10 * std::max(1e-3, std::abs(energy)));
    EXPECT_LT(norm(sum.force[i] - vectorAt(row, 17)), 1e-10 * std::max(1e-3, force));
    EXPECT_LT(norm(sum.force[i] + sum.force[j]), 1e-15);
    // All kinds share the units of the integer sums, which the stiffest pair decides.
    const double error = std::max(1e-10 * std::max(1e-2, torque), 2 * found->force->torqueUnit());
    EXPECT_LT(norm(sum.torque[i] - vectorAt(row, 20)), error);
    EXPECT_LT(norm(sum.torque[j] - vectorAt(row, 23)), error);
    // One pair by itself, as observers see it.
    const Vec3d separation = segments[1].x - segments[0].x;
    const PairAction one = found->force->resolve(separation, segments[0].q, segments[1].q);
    EXPECT_NEAR(one.energy, energy, 1e-10 * std::max(1e-3, std::abs(energy)));
    const Vec3d onFirst = swapped ? -vectorAt(row, 17) : vectorAt(row, 17);
    EXPECT_LT(norm(one.force - onFirst), 1e-10 * std::max(1e-3, force));
  }
}

TEST(Kinds, AKindNamedTwiceAsTheSameFibreHasTheSameForcesWithinAndBetween) {
  const Read read = readAll("-kinds a,b -pair_points 3");
  Random random;
  for (int k = 0; k < 10; ++k) {
    const auto pair = pairAt(15 + 3.0 * k, random);
    const Sum within = evaluate(*read.pairs.between(0, 0), pair),
              between = evaluate(*read.pairs.between(0, 1), pair);
    EXPECT_NEAR(within.energy, between.energy, 1e-13 * std::abs(within.energy));
    EXPECT_LT(norm(within.force[0] - between.force[0]), 1e-12 * (1 + norm(within.force[0])));
    EXPECT_LT(norm(within.torque[1] - between.torque[1]), 1e-12 * (1 + norm(within.torque[1])));
  }
}

TEST(Kinds, APrefixedOptionHoldsForItsKindAndOthersForAll) {
  const Read read = readAll(
      "-kinds a,b,c -fibre_young 500 -b_fibre_young 200 -a_break_strain_mean 0.1 "
      "-b_c_vdw_epsilon 0.05 -vdw_epsilon 0.06");
  const double gigapascal = nanoUnits().gigapascal;
  EXPECT_DOUBLE_EQ(read.kinds[0].young / gigapascal, 500);
  EXPECT_DOUBLE_EQ(read.kinds[1].young / gigapascal, 200);
  EXPECT_DOUBLE_EQ(read.kinds[2].young / gigapascal, 500);
  EXPECT_TRUE(read.breakage[0]);
  EXPECT_FALSE(read.breakage[1]);
  EXPECT_TRUE(std::isinf(read.breakage.criticalStrain(1, 3, 4, 10)));
  EXPECT_NE(read.pairs.between(1, 2)->description().find("eps 0.05 "), std::string::npos);
  EXPECT_NE(read.pairs.between(0, 2)->description().find("eps 0.06 "), std::string::npos);
}

TEST(Kinds, LawsBetweenKindsAreMeansOfTheirOwn) {
  const Read read = readAll(
      "-kinds a,b -a_a_vdw_epsilon 0.04 -b_b_vdw_epsilon 0.09 -a_a_vdw_length 6 "
      "-b_b_vdw_length 8");
  const std::string between = read.pairs.between(0, 1)->description();
  EXPECT_NE(between.find("eps 0.06 "), std::string::npos) << between;
  EXPECT_NE(between.find("lambda 7 "), std::string::npos) << between;
}

TEST(Kinds, TheStiffnessOfSurfacesBetweenThemIsThatOfTheirLawUnlessBothHaveOneOfTheirOwn) {
  // 120 gamma/s^2 with the mean gap 4.5, A/(pi g^4) with the mean gap 4; not the means of the two.
  auto between = [](const std::string& laws) {
    return readAll("-kinds a,b " + laws).pairs.between(0, 1)->description();
  };
  const std::string hydrogen =
      "-pair hydrogen -hydrogen_energy 0.01 -a_a_hydrogen_gap 3 -b_b_hydrogen_gap 6 ";
  EXPECT_NE(between(hydrogen).find("stiffness 0.059259 "), std::string::npos);
  EXPECT_NE(between(hydrogen + "-a_a_hydrogen_stiffness 0.5").find("stiffness 0.059259 "),
            std::string::npos);
  EXPECT_NE(between(hydrogen + "-a_a_hydrogen_stiffness 0.4 -b_b_hydrogen_stiffness 0.9")
                .find("stiffness 0.6 "),
            std::string::npos);
  EXPECT_NE(between("-pair hamaker -hamaker_constant 0.4 -pair_gap_cutoff 60 -a_a_hamaker_gap 3 "
                    "-b_b_hamaker_gap 5")
                .find("stiffness 0.00049736 "),
            std::string::npos);
}

TEST(Kinds, FrictionThatBothHaveHoldsBetweenThem) {
  const Read read = readAll(
      "-kinds a,b -pair contact -contact_modulus 20 -a_a_contact_friction 0.5 "
      "-b_b_contact_friction 0.5 -contact_restitution 0.7");
  const std::string between = read.pairs.between(0, 1)->description();
  EXPECT_NE(between.find("friction 0.5, "), std::string::npos) << between;
  EXPECT_NE(between.find("restitution 0.7"), std::string::npos) << between;
}

TEST(Kinds, WhatIsChosenWithinBothKindsHoldsBetweenThem) {
  const Read kink = readAll("-kinds a,b -a_a_vdw_splice kink -b_b_vdw_splice kink");
  EXPECT_NE(kink.pairs.between(0, 1)->description().find("vdw kink"), std::string::npos);
  // Within the kinds K is a 10th and a 1000th of what follows from the modulus.
  const std::string amyloid = "-kinds a,b -fibre_preset amyloid ";
  const Read usual = readAll(amyloid), soft = readAll(amyloid +
                                                      "-a_a_hertz_stiffness 0.0015189 "
                                                      "-b_b_hertz_stiffness 0.000015189");
  const Quatd along{1, 0, 0, 0};
  auto energy = [&](const Read& read) {
    return read.pairs.between(0, 1)->average(8, {0, 0, 76}, axis1(along), axis1(along)).energy;
  };
  EXPECT_NEAR(energy(soft) / energy(usual), 0.01, 1e-6);
}

TEST(Kinds, AKindWithoutPairLawHasNoForcesWithAnother) {
  const Read read = readAll("-kinds a,b -b_b_pair none");
  EXPECT_TRUE(read.pairs.between(0, 0));
  EXPECT_FALSE(read.pairs.between(0, 1));
  EXPECT_FALSE(read.pairs.between(1, 1));
}

TEST(Kinds, PointsOfAKindMayBeGivenWhereOneOfItsPairsHasNoLaw) {
  const Read read = readAll("-kinds a,b -b_b_pair none -a_pair_points 7");
  EXPECT_TRUE(read.pairs.between(0, 0));
  EXPECT_FALSE(read.pairs.between(0, 1));
}

TEST(Kinds, TheFirstSegmentIsThatOfTheLongerKind) {
  const Read read = readAll(three);
  for (const auto& c : read.pairs.classes())
    EXPECT_GE(read.kinds[c.first].length, read.kinds[c.second].length);
  EXPECT_EQ(read.pairs.classes().size(), 6u);
}

TEST(Kinds, HertzBetweenKindsIsTheForceOfHertzAtATenthOfTheThinnerRadius) {
  const Read read = readAll(
      "-kinds a,b -pair hertz -fibre_radius 20 -b_fibre_radius 60 -fibre_density 1000 "
      "-fibre_transverse_young 10 -b_fibre_transverse_young 40 -fibre_poisson 0.2 "
      "-fibre_segment_length 1 -b_fibre_segment_length 1 -pair_points 1");
  const double gigapascal = nanoUnits().gigapascal;
  const double compliance = (1 - 0.04) / (10 * gigapascal) + (1 - 0.04) / (40 * gigapascal);
  const double overlap = 2, radius = std::sqrt(20.0 * 60.0), r = 80 - overlap;
  const double force = 4.0 / 3.0 / compliance * std::sqrt(radius) * std::pow(overlap, 1.5);
  // Two crossed lines with w per length squared repel each other with 2 pi r w(r).
  const Quatd along{1, 0, 0, 0};
  const double w =
      read.pairs.between(0, 1)->average(1, {0, 0, r}, axis1(along), axis1(along)).energy;
  EXPECT_NEAR(2 * std::numbers::pi * r * w / force, r / 80, 1e-12);
}

TEST(Kinds, WhatCannotBeMeantIsRefusedWithTheRemedy) {
  const struct {
    const char *options, *says;
  } cases[] = {
      {"-kinds a,a", "stands there twice"},
      {"-kinds a,A", "stands there twice"},
      {"-kinds a,dm", "options of PETSc"},
      {"-kinds a_b", "cannot name a kind"},
      {"-kinds 7", "cannot name a kind"},
      {"-kinds a,b -b_fibre_radius 9", "kind b: -fibre_radius 9 changes"},
      {"-kinds a,b -c_fibre_radius 9", "unknown option -c_fibre_radius"},
      {"-kinds a,b -b_a_vdw_epsilon 1", "unknown option -b_a_vdw_epsilon"},
      {"-kinds a,b -b_b_pair hertz", "different pair laws: give -a_b_pair"},
      {"-kinds a,b -b_fibre_preset amyloid", "different pair laws: give -a_b_pair"},
      {"-kinds a,b -pair_cutoff 50", "-pair_gap_cutoff"},
      {"-kinds a,b -a_b_pair_gap_cutoff 20",
       "-a_b_pair_gap_cutoff 20: must lie beyond -a_b_pair_gap"},
      {"-kinds a,b -a_b_pair_gap_switch 1",
       "-a_b_pair_gap_switch 1: must lie beyond the gap at rest"},
      {"-kinds a,b -a_b_vdw_beta 12", "-a_b_vdw_beta 12: must be below -a_b_vdw_alpha"},
      {"-kinds a,b -b_b_vdw_alpha 9", "kinds a and b have different exponents"},
      {"-kinds a,b -hertz_stiffness 9", "-hertz_stiffness is not used by this run"},
      {"-kinds a,b -b_b_pair none -b_pair_points 7",
       "-b_pair_points is not used by this run: -pair is none"},
      {"-kinds a,b -b_fibre_young x", "-b_fibre_young"},
      {"-pair_cutoff 50 -pair_gap_cutoff 40", "give one of the two"},
  };
  for (const auto& c : cases)
    EXPECT_NE(problemWith(c.options).find(c.says), std::string::npos)
        << c.options << ": " << problemWith(c.options);
}

}  // namespace nanoweft::test
