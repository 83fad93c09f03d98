/// Thin tubes that kink (model.md 12): a bent fibre carries its critical moment and no more.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

constexpr double gigapascal = 6.241509074e-3, pi = std::numbers::pi;
constexpr double rf = 6.78, wall = 3.35, T = 13.56;
constexpr double moment = pi * wall * rf * (rf * rf + wall * wall / 4);
/// Stiffness of a bond in antisymmetric bending.
constexpr double K = 1029 * gigapascal * moment / T;

/// Angle between the clamped first and the last of 12 segments under a couple at the end, after
/// 20000 damped steps.
double angleUnder(double couple, const std::string& more = "") {
  const Folder folder;
  char text[64];
  std::snprintf(text, sizeof text, "-tip_torque 0,0,%.17g", couple);
  const auto outcome =
      run(folder,
          std::string("-scene fibre -fibre_segments 12 -fibre_kink_curvature 0.003636 -pair none "
                      "-damping_local 0.7 -ts_dt 20 -ts_max_steps 20000 -bc root,tip -root_region "
                      "-1,-9,-9,1,9,9 -root_fix 1,1,1 -root_fix_rotation -tip_region "
                      "148,-9,-9,150,9,9 -progress_interval 0 -state_output out.h5 ") +
              more + text);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto q = readOrientations(folder / "out.h5");
  return std::acos(dot(axis1(q.front()), axis1(q.back())));
}

TEST(Kinks, ABentTubeFoldsAtItsCriticalCurvature) {
  // (10,10) tubes kink at a radius of 275 A: 0.0493 rad a bond.
  const double angle = 2 * std::sin(0.5 * 0.003636 * T), width = 0.1 * angle;
  const double critical = K * (angle + 0.5 * width);
  const double below = 0.9 * K * angle;
  EXPECT_NEAR(angleUnder(below), 11 * std::asin(below / K), 1e-3);
  EXPECT_LT(angleUnder(0.98 * critical), 11 * (angle + width));
  // Some bond gives way, and the rest of the tube is no more bent than before.
  EXPECT_GT(angleUnder(1.05 * critical), 1.5);
}

TEST(Kinks, BeyondThemAPartOfTheStiffnessIsLeft) {
  const double angle = 2 * std::sin(0.5 * 0.003636 * T), width = 0.1 * angle, left = 0.3;
  const double couple = 1.2 * K * angle;
  // The turn a of each bond. Its direction halves it, which its shear, 12 K strong, does not like.
  double low = 0, high = 0.3;
  for (int k = 0; k < 60; ++k) {
    const double a = 0.5 * (low + high), theta = 2 * std::sin(0.5 * a);
    const double kinked = (1 - left) * (theta - angle - 0.5 * width) / theta;
    const double moment =
        K * (std::sin(a) * (1 - kinked) + 6 * (1 - std::cos(0.5 * a)) * std::sin(0.5 * a));
    (moment < couple ? low : high) = a;
  }
  ASSERT_GT(2 * std::sin(0.5 * low), angle + width);
  EXPECT_NEAR(angleUnder(couple, "-fibre_kink_stiffness 0.3 "), 11 * low, 1e-3);
}

}  // namespace
}  // namespace nanoweft::test
