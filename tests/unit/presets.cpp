/// Fibres by name: tubes against numbers from their unit cells, one fibre in both systems of
/// units, names that are refused.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/fibre/presets.hpp"

namespace nanoweft::test {
namespace {

using std::numbers::pi;

Fibre nano(const std::string& name) {
  return presetFibre(name, nanoUnits());
}

double amu(const Fibre& f) {
  return f.mass / nanoUnits().mass;
}

/// A tube of one shell with this radius.
Fibre shell(double radius) {
  return nano(format("mwcnt_%.17g_%.17g", radius, radius));
}

void expectSame(const Fibre& a, const Fibre& b) {
  EXPECT_EQ(a.radius, b.radius);
  EXPECT_EQ(a.wall, b.wall);
  EXPECT_EQ(a.middle, b.middle);
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.length, b.length);
  EXPECT_EQ(a.inertia, b.inertia);
  EXPECT_EQ(a.sheet, b.sheet);
  EXPECT_EQ(a.step, b.step);
  EXPECT_EQ(a.law, b.law);
  EXPECT_EQ(a.bond.stretch, b.bond.stretch);
  EXPECT_EQ(a.bond.shear, b.bond.shear);
  EXPECT_EQ(a.bond.bending, b.bond.bending);
  EXPECT_EQ(a.bond.torsion, b.bond.torsion);
}

TEST(Presets, ThePapersTubeHasThePapersNumbers) {
  const Fibre tube = nano("cnt_10_10");
  expectSame(tube, cnt1010(nanoUnits()));
  EXPECT_EQ(tube.preset, "cnt_10_10");
  EXPECT_EQ(tube.radius, 6.78);
  EXPECT_EQ(tube.wall, 3.35);
  EXPECT_EQ(tube.length, 13.56);
  EXPECT_EQ(tube.mass, 2649.0 * nanoUnits().amu);
  EXPECT_EQ(tube.sheet, 17.1);
  EXPECT_EQ(tube.step, 20.0);
}

TEST(Presets, TheFormulaAgreesWithThePaperWithinItsRounding) {
  // (20,20) is twice as wide as (10,10); a segment has four times its mass.
  const Fibre twice = nano("cnt_20_20");
  EXPECT_NEAR(twice.radius / 2, 6.78, 0.005);
  EXPECT_NEAR(amu(twice) / 4, 2649, 0.5);
}

TEST(Presets, TubesWeighWhatTheAtomsOfTheirUnitCellsWeigh) {
  // A cell of (n,n) is sqrt(3) a long, one of (n,0) 3 a; both have 4 n atoms of 12.011 amu.
  struct Case {
    const char* name;
    double radius, amuPerAngstrom;
  };
  for (const Case& c : {Case{"cnt_5_5", 3.3923876120037493, 97.60104269157769},
                        Case{"cnt_20_0", 7.834383603943665, 225.39995308468212}}) {
    const Fibre tube = nano(c.name);
    EXPECT_NEAR(tube.radius / c.radius, 1, 1e-13) << c.name;
    EXPECT_NEAR(amu(tube) / tube.length / c.amuPerAngstrom, 1, 1e-13) << c.name;
    EXPECT_EQ(tube.length, tube.diameter()) << c.name;
    EXPECT_EQ(tube.wall, 3.35) << c.name;
    EXPECT_NEAR(tube.sheet - tube.diameter(), 17.1 - 13.56, 1e-14) << c.name;
    EXPECT_EQ(tube.step, 0) << c.name;
    EXPECT_EQ(tube.law, "vdw") << c.name;
  }
}

TEST(Presets, AThickTubeOfOneShellIsASingleWalledOne) {
  for (const char* name : {"cnt_5_5", "cnt_20_0", "cnt_17_4"}) {
    const Fibre single = nano(name);
    expectSame(shell(single.radius), single);
  }
}

TEST(Presets, AThickTubeIsAHollowCylinder) {
  const Fibre tube = nano("mwcnt_50_20");
  const double out = 50 + 1.675, in = 20 - 1.675, o2 = out * out, i2 = in * in;
  EXPECT_EQ(tube.radius, 50);
  EXPECT_NEAR(tube.crossSection() / (pi * (o2 - i2)), 1, 1e-13);
  EXPECT_NEAR(tube.secondMoment() / (pi / 4 * (o2 * o2 - i2 * i2)), 1, 1e-13);
  EXPECT_NEAR(tube.inertia / (tube.mass * (o2 + i2) / 2), 1, 1e-13);
  EXPECT_NEAR(tube.density() / nano("cnt_5_5").density(), 1, 1e-13);
}

TEST(Presets, AThickTubeWeighsWhatItsShellsWeigh) {
  double perLength = 0;
  for (int k = 0; k <= 9; ++k) {
    const Fibre one = shell(20 + 3.35 * k);
    perLength += one.mass / one.length;
  }
  const Fibre tube = nano("mwcnt_50.15_20");
  EXPECT_NEAR(tube.mass / tube.length / perLength, 1, 1e-13);
}

TEST(Presets, AFibreIsTheSameInBothSystemsOfUnits) {
  const double joule = codata::electronvolt, metre = 1e-10, pascal = joule * 1e30;
  for (const char* name : {"cnt_10_10", "cnt_5_5", "mwcnt_50_20", "carbon_t300", "glass_e",
                           "amyloid", "collagen", "cellulose_nf", "nylon_ef"}) {
    const Fibre a = nano(name), b = presetFibre(name, siUnits());
    auto same = [&](double inNano, double unit, double inSi) {
      EXPECT_NEAR(inSi, inNano * unit, 1e-13 * std::abs(inSi)) << name;
    };
    same(a.radius, metre, b.radius);
    same(a.wall, metre, b.wall);
    same(a.middle, metre, b.middle);
    same(a.length, metre, b.length);
    same(a.sheet, metre, b.sheet);
    same(a.strength.length, metre, b.strength.length);
    same(a.step, 1e-15, b.step);
    same(a.young, pascal, b.young);
    same(a.shear, pascal, b.shear);
    same(a.transverse, pascal, b.transverse);
    same(a.mass, joule * 1e-10, b.mass);
    same(a.inertia, joule * 1e-30, b.inertia);
    same(a.density() / nanoUnits().kilogramPerCubicMetre, 1, b.density());
    same(a.bond.stretch, joule * 1e20, b.bond.stretch);
    same(a.bond.shear, joule, b.bond.shear);
    same(a.bond.bending, joule, b.bond.bending);
    same(a.bond.torsion, joule, b.bond.torsion);
    EXPECT_EQ(a.preset, name);
    EXPECT_EQ(a.law, b.law) << name;
    EXPECT_EQ(a.poisson, b.poisson) << name;
    EXPECT_EQ(a.strength.mean, b.strength.mean) << name;
  }
}

TEST(Presets, SolidFibresHaveTheNumbersOfTheirSources) {
  struct Case {
    const char* name;
    double diameter, young, density, strength;  // m, Pa, kg/m^3, Pa
  };
  for (const Case& c :
       {Case{"carbon_t300", 7e-6, 230e9, 1760, 3.45e9}, Case{"glass_e", 13e-6, 72e9, 2570, 2e9},
        Case{"amyloid", 8e-9, 3.3e9, 1350, 0.6e9}, Case{"collagen", 410e-9, 0.29e9, 1170, 0.1e9},
        Case{"cellulose_nf", 14.2e-9, 145e9, 1600, 2e9},
        Case{"nylon_ef", 600e-9, 2.8e9, 1140, 78e6}}) {
    const Fibre f = presetFibre(c.name, siUnits());
    EXPECT_NEAR(f.diameter() / c.diameter, 1, 1e-13) << c.name;
    EXPECT_EQ(f.length, f.diameter()) << c.name;
    EXPECT_NEAR(f.young / c.young, 1, 1e-13) << c.name;
    EXPECT_NEAR(f.density() / c.density, 1, 1e-13) << c.name;
    EXPECT_NEAR(f.strength.mean * f.young / c.strength, 1, 1e-13) << c.name;
    EXPECT_NEAR(f.strength.strain * f.young / c.strength, 1, 1e-13) << c.name;
    EXPECT_EQ(f.law, "hertz") << c.name;
    EXPECT_GT(f.transverse, 0) << c.name;
    EXPECT_LE(f.transverse, f.young) << c.name;
  }
}

TEST(Presets, NamesThatCannotBeAreRefusedWithWhatThereIs) {
  struct Case {
    const char *name, *said;
  };
  for (const Case& c : {Case{"", "there are cnt_N_M"},
                        Case{"glass", "there are cnt_N_M"},
                        Case{"glass", "glass_e"},
                        Case{"CNT_5_5", "there are cnt_N_M"},
                        Case{"cnt_5", "there are cnt_N_M"},
                        Case{"cnt_5_", "there are cnt_N_M"},
                        Case{"cnt_5_5_5", "there are cnt_N_M"},
                        Case{"cnt_5_5 ", "there are cnt_N_M"},
                        Case{"cnt_5.5_5", "there are cnt_N_M"},
                        Case{"cnt_99999999999_0", "there are cnt_N_M"},
                        Case{"mwcnt_50", "there are cnt_N_M"},
                        Case{"cnt_0_0", "N >= M >= 0"},
                        Case{"cnt_5_10", "N >= M >= 0"},
                        Case{"cnt_5_-2", "N >= M >= 0"},
                        Case{"cnt_201_0", "200 >= N"},
                        Case{"cnt_4_0", "radius above 1.675 A"},
                        Case{"mwcnt_20_50", "OUTER > INNER"},
                        Case{"mwcnt_50_1.6", "INNER > 1.675"},
                        Case{"mwcnt_50_-20", "INNER > 1.675"},
                        Case{"mwcnt_50_49", "apart by 3 A"},
                        Case{"mwcnt_5000_20", "1000 >= OUTER"},
                        Case{"mwcnt_nan_20", "OUTER > INNER"},
                        Case{"mwcnt_inf_inf", "1000 >= OUTER"}}) {
    try {
      nano(c.name);
      ADD_FAILURE() << c.name;
    } catch (const InputError& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find(c.said), std::string::npos) << said;
      EXPECT_NE(said.find(std::string("fibre preset ") + c.name), std::string::npos) << said;
      EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
  }
}

}  // namespace
}  // namespace nanoweft::test
