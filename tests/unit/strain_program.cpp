/// The course of a tension test of several legs.
#include <gtest/gtest.h>

#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/motion/strain_program.hpp"

namespace nanoweft::test {
namespace {

TEST(StrainProgram, LegsEndAtTheirStrainsAtRestOneAfterTheOther) {
  StrainProgram p({0.02, 1e-6, -0.01, 2e-6, 0, 1e-6}, 1000.0);
  p.begin(500, 0);
  // Way over rate, and one ramp, for each leg.
  const double first = 500 + 0.02 / 1e-6 + 1000, second = first + 0.03 / 2e-6 + 1000,
               third = second + 0.01 / 1e-6 + 1000;
  EXPECT_NEAR(p.end(), third, 1e-8);
  for (const auto& [time, strain] : {std::pair{0.0, 0.0},
                                     {500.0, 0.0},
                                     {first, 0.02},
                                     {second, -0.01},
                                     {third, 0.0},
                                     {third + 1e6, 0.0}}) {
    EXPECT_NEAR(p.strain(time), strain, 1e-15) << time;
    EXPECT_NEAR(p.rate(time), 0, 1e-14) << time;
  }
  EXPECT_NEAR(p.rate(first - 2000), 1e-6, 1e-20);
  EXPECT_NEAR(p.rate(first + 2000), -2e-6, 1e-20);
  EXPECT_NEAR(p.rate(1000), 0.5e-6, 1e-20);
}

TEST(StrainProgram, TheRateIsTheDerivativeOfTheStrain) {
  // The second leg is too short to reach its rate, the last one begins where it ends.
  for (const auto ramp :
       {std::optional<double>(3000.0), std::optional<double>(0.0), std::optional<double>()}) {
    StrainProgram p({0.02, 1e-6, 0.0195, 1e-6, 0.03, 4e-6}, ramp);
    p.begin(0, 0.001);
    const double h = 0.5;
    double jumps = 0;
    for (double t = -100.25; t < p.end() + 100; t += 10) {
      const double slope = (p.strain(t + h) - p.strain(t - h)) / (2 * h);
      // Only without a ramp the rate jumps, at the ends of the legs.
      if (std::abs(slope - p.rate(t)) > 1e-9) ++jumps;
      EXPECT_LE(std::abs(slope), 4e-6 * (1 + 1e-9));
    }
    EXPECT_LE(jumps, ramp == 0.0 ? 4 : 0);
    EXPECT_EQ(p.strain(p.end()), 0.03);
  }
}

TEST(StrainProgram, WhatIsNoProgramIsRefused) {
  for (const std::vector<double>& pairs :
       std::vector<std::vector<double>>{{0.02},
                                        {0.02, 1e-6, 0.01},
                                        {0.02, 0},
                                        {0.02, -1e-6},
                                        {-1, 1e-6},
                                        {0.02, 1e-6, 0.02, 1e-6}})
    EXPECT_THROW(StrainProgram(pairs, {}), InputError) << pairs.size();
  StrainProgram p({0.02, 1e-6}, {});
  EXPECT_THROW(p.begin(0, 0.02), InputError);
}

}  // namespace
}  // namespace nanoweft::test
