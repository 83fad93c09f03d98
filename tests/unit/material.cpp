/// Fibres from options, in both systems of units, and the defaults that follow from them.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/fibre/presets.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "nanoweft/force/quadrature.hpp"
#include "nanoweft/force/vdw.hpp"
#include "nanoweft/force/vdw_range.hpp"

namespace nanoweft::test {
namespace {

using std::numbers::pi;

/// Calls `read` with these options set.
template <class Read>
auto with(const std::string& text, const Read& read) {
  petsc(PetscOptionsClear(nullptr));
  petsc(PetscOptionsInsertString(nullptr, text.c_str()));
  Options options;
  auto result = read(options);
  petsc(PetscOptionsClear(nullptr));
  return result;
}

Fibre fibreOf(const std::string& text, const UnitSystem& units) {
  return with(text, [&](Options& options) { return readFibre(options, units); });
}

std::shared_ptr<PairForce> pairOf(const std::string& text, const UnitSystem& units) {
  return with(text, [&](Options& options) {
    const Fibre fibre = readFibre(options, units);
    return readPairForces(options, units, fibre).classes()[0].force;
  });
}

TEST(Fibre, DensityIsMassOverTheCrossSectionInBothSystems) {
  // A solid round fibre 5 um in radius of 1000 kg/m^3: 1000 pi r^2 2r = 7.853982e-13 kg a segment.
  const double kilograms = 1000 * pi * 25e-12 * 1e-5;
  const std::string preset = "-fibre_preset carbon_t300 -fibre_density 1000 -fibre_radius ";
  const Fibre si = fibreOf(preset + "5e-6", siUnits()), nano = fibreOf(preset + "5e4", nanoUnits());
  EXPECT_NEAR(si.mass / kilograms, 1.0, 1e-14);
  EXPECT_NEAR(nano.mass / nanoUnits().mass * codata::atomicMass / kilograms, 1.0, 1e-14);
  EXPECT_NEAR(nano.density() / nanoUnits().kilogramPerCubicMetre, 1000, 1e-9);
  // A tube's cross-section is 2 pi h rf.
  const Fibre tube = fibreOf("-fibre_density 2000 -fibre_radius 10 -fibre_wall 3", nanoUnits());
  EXPECT_NEAR(tube.mass / nanoUnits().mass * codata::atomicMass, 2000 * 2 * pi * 30e-20 * 20e-10,
              1e-38);
}

TEST(Fibre, AnotherCrossSectionNeedsAMassOrADensity) {
  for (const char* text :
       {"-fibre_radius 7", "-fibre_wall 3", "-fibre_wall 0",
        "-fibre_preset carbon_t300 -fibre_radius 5e4", "-fibre_preset carbon_t300 -fibre_wall 10"})
    EXPECT_THROW(fibreOf(text, nanoUnits()), InputError) << text;
  EXPECT_THROW(fibreOf("-fibre_density 2000 -fibre_segment_mass 2600", nanoUnits()), InputError);
  EXPECT_EQ(fibreOf("-fibre_radius 6.78 -fibre_wall 3.35", nanoUnits()).mass,
            cnt1010(nanoUnits()).mass);
  EXPECT_EQ(fibreOf("-fibre_radius 7 -fibre_segment_mass 2800", nanoUnits()).mass,
            2800 * nanoUnits().mass);
  // The message's own numbers are the right ones.
  try {
    fibreOf("-fibre_preset carbon_t300 -fibre_radius 5e-6", siUnits());
    FAIL();
  } catch (const InputError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("-fibre_density 1760 "), std::string::npos) << said;
    EXPECT_NE(said.find("-fibre_segment_mass 1.3823e-12 "), std::string::npos) << said;
  }
  petsc(PetscOptionsClear(nullptr));
}

TEST(Fibre, AThickTubeIsDescribedByItsName) {
  const std::string preset = "-fibre_preset mwcnt_50_20 ";
  const Fibre tube = fibreOf(preset, nanoUnits());
  EXPECT_EQ(tube.radius, 50);
  EXPECT_NEAR(tube.crossSection(), 2 * pi * 35 * 33.35, 1e-10);
  for (const char* text : {"-fibre_radius 60", "-fibre_wall 10", "-fibre_wall 0"}) {
    try {
      fibreOf(preset + text + " -fibre_density 2000", nanoUnits());
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("mwcnt_OUTER_INNER"), std::string::npos) << text;
    }
  }
  EXPECT_EQ(fibreOf(preset + "-fibre_radius 50", nanoUnits()).mass, tube.mass);
  const Fibre light = fibreOf(preset + "-fibre_density 1000", nanoUnits());
  EXPECT_NEAR(light.density() / nanoUnits().kilogramPerCubicMetre, 1000, 1e-9);
  const Fibre half = fibreOf(preset + "-fibre_segment_length 50", nanoUnits());
  EXPECT_NEAR(half.mass / tube.mass, 0.5, 1e-14);
  EXPECT_NEAR(half.inertia / tube.inertia, 0.5, 1e-14);
  petsc(PetscOptionsClear(nullptr));
}

TEST(Fibre, AnUnknownPresetIsRefused) {
  EXPECT_THROW(fibreOf("-fibre_preset carbon_t1000", nanoUnits()), InputError);
  petsc(PetscOptionsClear(nullptr));
}

TEST(Fibre, TheUsualStepBelongsToThePresetAsItIs) {
  EXPECT_EQ(fibreOf("", nanoUnits()).step, 20.0);
  EXPECT_NEAR(fibreOf("", siUnits()).step, 20e-15, 1e-29);
  EXPECT_EQ(fibreOf("-fibre_segment_length 13.56 -fibre_young 1029", nanoUnits()).step, 20.0);
  for (const char* text : {"-fibre_segment_length 6.78", "-fibre_young 500",
                           "-fibre_segment_mass 1000", "-fibre_preset carbon_t300"})
    EXPECT_EQ(fibreOf(text, nanoUnits()).step, 0.0) << text;
}

TEST(PairDefaults, OfTheTube) {
  const auto pair = pairOf("", nanoUnits());
  EXPECT_EQ(pair->points().near, 5);
  EXPECT_EQ(pair->points().far, 1);
  EXPECT_DOUBLE_EQ(pair->points().from, 27.12);
  EXPECT_EQ(pair->cutoff(), 4 * 13.56);
  EXPECT_EQ(pair->exclude(), 20);
  EXPECT_EQ(pair->restDistance(), 17.343571 / 6.78 * 6.78);
  const auto si = pairOf("", siUnits());
  EXPECT_NEAR(si->cutoff() / 54.24e-10, 1.0, 1e-14);
  EXPECT_NEAR(si->restDistance() / 17.343571e-10, 1.0, 1e-14);
  EXPECT_EQ(si->points().near, 5);
  EXPECT_NEAR(si->points().from / 27.12e-10, 1.0, 1e-14);
  EXPECT_NEAR(si->contactStiffness() / (pair->contactStiffness() * codata::electronvolt * 1e20),
              1.0, 1e-14);
}

TEST(PairDefaults, PointsAndExclusionFollowTheSegmentLength) {
  struct Case {
    const char* length;
    int near, far, exclude;
  };
  for (const Case& c : {Case{"6.78", 3, 1, 40}, Case{"4.52", 2, 1, 60}, Case{"13.56", 5, 1, 20},
                        Case{"27.12", 9, 2, 10}, Case{"20", 8, 1, 14}}) {
    const auto pair = pairOf(std::string("-fibre_segment_length ") + c.length, nanoUnits());
    EXPECT_EQ(pair->points().near, c.near) << c.length;
    EXPECT_EQ(pair->points().far, c.far) << c.length;
    EXPECT_EQ(pair->exclude(), c.exclude) << c.length;
    EXPECT_EQ(pair->cutoff(), 4 * 13.56);
  }
  // Points that are given are those of all pairs.
  EXPECT_EQ(pairOf("-pair_points 7", nanoUnits())->points().far, 7);
}

TEST(PairDefaults, TheGapDoesNotGrowWithTheTube) {
  // Twice the radius: rest and cutoff 13.56 A further out, the same well.
  const auto thin = pairOf("", nanoUnits()),
             thick = pairOf("-fibre_radius 13.56 -fibre_density 2273", nanoUnits());
  EXPECT_NEAR(thick->restDistance() - thin->restDistance(), 13.56, 1e-12);
  EXPECT_NEAR(thick->cutoff() - thin->cutoff(), 13.56, 1e-12);
  VdwParameters p, q;
  q.radius = 13.56;
  q.switchFrom += 13.56;
  q.cutoff += 13.56;
  const Vdw one(p), other(q);
  for (double r : {15.0, 16.5, 17.3, 20.0, 30.0, 45.0, 54.0}) {
    const auto a = one(r * r), b = other((r + 13.56) * (r + 13.56));
    EXPECT_NEAR(a.energy, b.energy, 1e-11 * std::abs(a.energy) + 1e-14);
  }
}

TEST(PairDefaults, CrossedHertzFibresPressAsHertzSaysAtATenthOfARadius) {
  // F = 2 pi r w(r) for crossed fibres, w = u/(2 rf)^2.
  const double radius = 3.5e-6, young = 15e9, poisson = 0.07, overlap = 0.1 * radius;
  const ContactSide side{radius, young, poisson};
  const double K = hertzStiffness(side, side), r = 2 * radius - overlap;
  const Hertz law(K, radius);
  const double force = 2 * pi * r * law(r * r).energy / (4 * radius * radius);
  const double reduced = young / (2 * (1 - poisson * poisson));
  // r is 5 % below 2 rf, which the formula leaves out.
  EXPECT_NEAR(force / (4.0 / 3.0 * reduced * std::sqrt(radius) * std::pow(overlap, 1.5)), 0.95,
              1e-12);
}

TEST(PairDefaults, CarbonFibresTouchByTheirTransverseModulus) {
  const auto si = pairOf("-fibre_preset carbon_t300", siUnits()),
             nano = pairOf("-fibre_preset carbon_t300", nanoUnits());
  EXPECT_NEAR(si->restDistance(), 7e-6, 1e-20);
  EXPECT_NEAR(nano->restDistance(), 7e4, 1e-8);
  // 1 J/m^2.5 = 1/e * 1e-25 eV/A^2.5; u'' = 3.75 K sqrt(overlap).
  EXPECT_NEAR(si->contactStiffness() / (nano->contactStiffness() * codata::electronvolt * 1e20),
              1.0, 1e-12);
  EXPECT_EQ(si->points().near, nano->points().near);
}

TEST(ForceError, TheEstimateFallsWithPointsAndMeetsTheBundles) {
  const Fibre tube = cnt1010(nanoUnits());
  auto error = [&](const char* text) {
    return expectedForceErrors(*pairOf(text, nanoUnits()), tube).value().bundle;
  };
  const double three = error("-pair_points 3"), five = error("-pair_points 5"), usual = error(""),
               nine = error("-pair_points 9");
  EXPECT_GT(three, 10 * five);
  EXPECT_GT(five, nine);
  EXPECT_LT(usual, 0.01);
  // The same numbers in metres.
  const Fibre si = cnt1010(siUnits());
  EXPECT_NEAR(expectedForceErrors(*pairOf("", siUnits()), si).value().bundle / usual, 1.0, 1e-6);
}

TEST(ForceError, WhereTheEstimateWouldTakeMinutesThereIsNone) {
  const Fibre tube = cnt1010(nanoUnits());
  for (const char* text : {"-pair_cutoff 1e9", "-vdw_length 1e9"})
    EXPECT_FALSE(expectedForceErrors(*pairOf(text, nanoUnits()), tube)) << text;
}

TEST(ForceError, AnAccuracyThatIsAskedForChoosesThePoints) {
  const Fibre tube = cnt1010(nanoUnits());
  int before = 0;
  for (const double accuracy : {0.2, 0.05, 0.02}) {
    const auto pair = pairOf("-pair_accuracy " + std::to_string(accuracy), nanoUnits());
    const ForceErrors errors = expectedForceErrors(*pair, tube).value();
    EXPECT_LE(errors.larger(), 0.5 * accuracy);
    EXPECT_GT(errors.larger(), 0.02 * accuracy);
    EXPECT_GE(pair->points().near.i, before);
    EXPECT_TRUE(pair->points().split());
    before = pair->points().near.i;
  }
  EXPECT_GT(before, 5);
  const auto hertz = pairOf("-pair hertz -pair_accuracy 0.05", nanoUnits());
  EXPECT_LE(expectedForceErrors(*hertz, tube).value().larger(), 0.025);
  EXPECT_FALSE(hertz->points().split());
}

TEST(Range, LosesThatMuchOfABundlesCohesion) {
  const double rest = 17.343571;
  auto lost = [&](double switchFrom, double cutoff) {
    VdwParameters law;
    law.switchFrom = switchFrom;
    law.cutoff = cutoff;
    return cohesionLost(law, rest);
  };
  // Integrals along endless tubes by scipy.integrate.quad, against no cutoff at all; a law that
  // reaches through the bundle lacks 5.4e-5 of that.
  EXPECT_NEAR(lost(40.68, 54.24), 0.004062, 6e-5);
  EXPECT_NEAR(lost(27.12, 33.9), 0.017450, 6e-5);
  EXPECT_NEAR(lost(31.64, 40.68), 0.009003, 6e-5);
  EXPECT_EQ(lost(200, 1e9), 0);
  // Thick fibres, to which the law is narrow.
  VdwParameters thick;
  thick.radius = 1000;
  thick.switchFrom = 2027.12;
  thick.cutoff = 2040.68;
  EXPECT_NEAR(cohesionLost(thick, 2003.783571), 0.00020267, 2e-6);
}

TEST(Range, AnAccuracyThatIsAskedForChoosesIt) {
  auto lost = [](double cutoff) {
    VdwParameters law;
    law.cutoff = cutoff;
    law.switchFrom = 13.56 + (cutoff - 13.56) * 2 / 3;
    return cohesionLost(law, 17.343571);
  };
  for (const double accuracy : {0.2, 0.1, 0.05, 0.02, 0.01}) {
    const double cutoff =
        pairOf("-pair_accuracy " + std::to_string(accuracy), nanoUnits())->cutoff();
    EXPECT_LE(lost(cutoff), accuracy / 5) << accuracy;
    // It goes farther by at most two lambda at a time.
    if (accuracy < 0.2) {
      EXPECT_GT(lost(cutoff - 2 * 6.78), accuracy / 5) << accuracy;
    }
  }
  const auto given = pairOf("-pair_accuracy 0.1 -pair_switch 30 -pair_cutoff 44", nanoUnits());
  EXPECT_EQ(given->cutoff(), 44);
  // A law that falls so slowly has no range.
  EXPECT_THROW(pairOf("-pair_accuracy 0.1 -vdw_beta 1", nanoUnits()), InputError);
  // One of the two given: the other has its default.
  EXPECT_EQ(pairOf("-pair_accuracy 0.1 -pair_cutoff 60", nanoUnits())->cutoff(), 60);
}

TEST(PairOptions, ReachTheLawsThatTheyAreOf) {
  const auto says = [](const std::string& options, const std::string& words) {
    const std::string text = pairOf(options, nanoUnits())->description();
    EXPECT_NE(text.find(words), std::string::npos) << options << ": " << text;
  };
  says("-vdw_a 0.03", " A 0.03,");
  says("-vdw_b 1.2", " B 1.2,");
  says("-vdw_stiffness 150", " k 150 ");
  says("-vdw_epsilon 0.08", " eps 0.08 ");
  const std::string contact = "-pair contact -contact_modulus 20 ";
  says(contact + "-contact_points 3", "3 points along");
  says(contact + "-contact_friction 0.2",
       "friction 0.2, tangential stiffness 0.2857, restitution 1");
  says(contact + "-contact_friction 0.2 -contact_tangential 0.5 -contact_restitution 0.7",
       "friction 0.2, tangential stiffness 0.5, restitution 0.7");
}

TEST(ForceError, AnAccuracyTakesSinglePrecisionWhereThatPays) {
  auto single = [](const std::string& options) {
    return pairOf(options, nanoUnits())->description().ends_with(", single precision");
  };
  EXPECT_EQ(single("-pair_accuracy 0.05"), singlePrecisionPays());
  EXPECT_FALSE(single("-pair_accuracy 0.05 -pair_precision double"));
  EXPECT_FALSE(single(""));
  if (!singlePrecisionPays()) return;
  EXPECT_TRUE(single("-pair_precision single -pair_points 9"));
  // More points are always counted in doubles.
  EXPECT_THROW(single("-pair_precision single -pair_points 10"), InputError);
}

TEST(ForceError, PointsTooCoarseForTheLawAreNamed) {
  const Fibre tube = cnt1010(nanoUnits());
  auto warnings = [&](const char* text) {
    return pointWarnings(*pairOf(text, nanoUnits()), tube, tube, nanoUnits());
  };
  EXPECT_TRUE(warnings("").empty());
  EXPECT_TRUE(warnings("-pair_points 2").empty());  // 6.78 A apart, 0.8 of 11.45 A is 9.16 A
  ASSERT_EQ(warnings("-pair_points 1").size(), 1u);
  EXPECT_NE(warnings("-pair_points 1")[0].find("take 2 at least"), std::string::npos);
}

}  // namespace
}  // namespace nanoweft::test
