/// Critical strains: their distributions, and that strength belongs to a length.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/fibre/breakage_law.hpp"
#include "nanoweft/fibre/presets.hpp"

namespace nanoweft::test {
namespace {

constexpr double diameter = 13.56;

/// Largest distance of the draws' distribution from `cumulative`, times the root of their number:
/// below 1.63 for 99 of 100 seeds when they belong to it.
double kolmogorov(std::vector<double> draws, const std::function<double(double)>& cumulative) {
  std::ranges::sort(draws);
  const auto n = static_cast<double>(draws.size());
  double distance = 0;
  for (std::size_t k = 0; k < draws.size(); ++k) {
    const double p = cumulative(draws[k]), below = static_cast<double>(k) / n;
    distance = std::max({distance, p - below, below + 1.0 / n - p});
  }
  return distance * std::sqrt(n);
}

double normalTail(double x) {
  return 0.5 * std::erfc(x / std::numbers::sqrt2);
}

BreakageLaw lawFor(double length) {
  BreakageLaw law;
  law.bondLength = length;
  law.diameters = length / diameter;
  law.seed = 11;
  return law;
}

std::vector<double> draw(const BreakageLaw& law, int fibres, int bonds) {
  std::vector<double> strains;
  for (int f = 0; f < fibres; ++f)
    for (int k = 0; k < bonds; ++k) strains.push_back(law.criticalStrain(f, k, bonds + 1));
  return strains;
}

TEST(BreakageLaw, TheNormalQuantileInvertsTheTail) {
  for (double logTail = -600; logTail < -1e-3; logTail *= 0.9) {
    const double x = normalQuantileOfTail(logTail);
    // One unit in the last place of x changes the tail by about x^2 of these.
    EXPECT_NEAR(std::log(normalTail(x)), logTail, 1e-13 * std::max(1.0, std::abs(logTail)));
  }
  EXPECT_NEAR(normalQuantileOfTail(-std::numbers::ln2), 0.0, 1e-15);
  // Close to one: x = -5 has the tail 1 - 2.866515718791939e-7.
  EXPECT_NEAR(normalQuantileOfTail(std::log1p(-2.866515718791939e-7)), -5.0, 1e-9);
  EXPECT_TRUE(std::isfinite(normalQuantileOfTail(-1e9)));
}

TEST(BreakageLaw, ABondOfTwoRadiiIsDrawnAsEver) {
  BreakageLaw law = lawFor(diameter);
  law.seed = 5;
  // Box and Muller's number of (5, breakage, fibre, index), as all results so far have it.
  for (int k = 0; k < 100; ++k)
    EXPECT_EQ(law.criticalStrain(3, k, 100),
              0.3 + 0.05 * normalDraw(5, Purpose::breakage, 3, static_cast<std::uint32_t>(k)));
}

TEST(BreakageLaw, ABondHasTheDistributionOfTheWeakestOfItsDiameters) {
  for (double length : {0.5, 1.0, 2.0, 3.7}) {
    const BreakageLaw law = lawFor(length * diameter);
    const double distance = kolmogorov(draw(law, 200, 100), [&](double strain) {
      return 1.0 - std::pow(normalTail((strain - 0.3) / 0.05), length);
    });
    EXPECT_LT(distance, 1.63) << length;
  }
}

TEST(BreakageLaw, KnowsTheShareOfDrawsWithoutStrength) {
  for (const double length : {1.0, 2.5}) {
    BreakageLaw law = lawFor(length * diameter);
    law.deviation = 0.15;  // a half of the mean
    int below = 0;
    const auto strains = draw(law, 200, 100);
    for (const double strain : strains) below += strain < 0;
    const double share = law.shareWithoutStrength(), n = static_cast<double>(strains.size());
    EXPECT_NEAR(below / n, share, 4 * std::sqrt(share / n)) << length;
    EXPECT_NEAR(share, 1.0 - std::pow(normalTail(-2.0), length), 1e-12);
  }
  EXPECT_LT(lawFor(diameter).shareWithoutStrength(), 1e-8);
}

TEST(BreakageLaw, AFibreIsAsStrongHoweverFinelyItIsCut) {
  // 40 diameters cut into bonds of rf, 2 rf and 4 rf: the weakest has one and the same law.
  const int fibres = 4000;
  for (double length : {0.5, 1.0, 2.0}) {
    const BreakageLaw law = lawFor(length * diameter);
    const int bonds = static_cast<int>(std::lround(40 / length));
    std::vector<double> weakest;
    for (int f = 0; f < fibres; ++f) {
      double least = 1e9;
      for (int k = 0; k < bonds; ++k) least = std::min(least, law.criticalStrain(f, k, bonds + 1));
      weakest.push_back(least);
    }
    EXPECT_LT(kolmogorov(weakest,
                         [](double strain) {
                           return 1.0 - std::pow(normalTail((strain - 0.3) / 0.05), 40.0);
                         }),
              1.63)
        << length;
  }
}

TEST(BreakageLaw, WeibullsLawByTheLengthOfTheBond) {
  for (double length : {0.5, 1.0, 2.0}) {
    BreakageLaw law = lawFor(length * diameter);
    law.weibull = true;
    law.shape = 5, law.strain0 = 0.015, law.length0 = 20 * diameter;
    EXPECT_LT(kolmogorov(draw(law, 200, 100),
                         [&](double strain) {
                           return -std::expm1(-length / 20 * std::pow(strain / 0.015, 5));
                         }),
              1.63)
        << length;
    // One draw a fibre: by the length of the fibre.
    law.perFibre = true;
    std::vector<double> fibres;
    for (int f = 0; f < 20000; ++f) fibres.push_back(law.criticalStrain(f, 7, 100));
    EXPECT_LT(kolmogorov(fibres,
                         [&](double strain) {
                           return -std::expm1(-100 * length / 20 * std::pow(strain / 0.015, 5));
                         }),
              1.63)
        << length;
  }
}

TEST(BreakageLaw, AFibresOwnStrainScattersAlongIt) {
  BreakageLaw law = lawFor(diameter);
  law.perFibre = true;
  const double whole = law.criticalStrain(2, 0, 100);
  EXPECT_EQ(law.criticalStrain(2, 50, 100), whole);
  EXPECT_EQ(whole, 0.3 + 0.05 * normalDraw(11, Purpose::breakage, 2, 0xffffffffu));
  law.scatter = 0.02;
  std::vector<double> along;
  for (int k = 0; k < 20000; ++k) along.push_back(law.criticalStrain(2, k, 20001) / whole - 1.0);
  EXPECT_LT(kolmogorov(along, [](double x) { return 1.0 - normalTail(x / 0.02); }), 1.63);
}

TEST(BreakageLaw, OptionsOfOneLawAreRefusedWithTheOther) {
  auto read = [](const char* text, const Fibre& fibre) {
    petsc(PetscOptionsClear(nullptr));
    petsc(PetscOptionsInsertString(nullptr, text));
    Options options;
    const auto law = readBreakage(options, nanoUnits(), fibre, 1);
    petsc(PetscOptionsClear(nullptr));
    return law;
  };
  const Fibre tube = cnt1010(nanoUnits());
  EXPECT_FALSE(read("", tube));
  EXPECT_EQ(read("-break_per fibre", tube)->scatter, 0.01);
  EXPECT_EQ(read("-break_law weibull", tube)->length0, 13.56);
  const auto weibull = read(
      "-break_law weibull -break_weibull_shape 4 -break_weibull_strain 0.02 -break_weibull_length "
      "100",
      tube);
  EXPECT_EQ(weibull->shape, 4);
  EXPECT_EQ(weibull->strain0, 0.02);
  EXPECT_EQ(weibull->length0, 100);
  const auto normal = read("-break_strain_mean 0.2 -break_strain_std 0.03", tube);
  EXPECT_EQ(normal->mean, 0.2);
  EXPECT_EQ(normal->deviation, 0.03);
  EXPECT_THROW(read("-break_law weibull -break_strain_mean 0.2", tube), InputError);
  EXPECT_THROW(read("-break_weibull_shape 4", tube), InputError);
  EXPECT_THROW(read("-break_scatter 0.1", tube), InputError);
  petsc(PetscOptionsClear(nullptr));
}

}  // namespace
}  // namespace nanoweft::test
