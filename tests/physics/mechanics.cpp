/// Beams and rods against the closed forms: the chain is exact at its nodes for small loads, since
/// a bond's energy is that of a cubic Hermite beam element (model.md 3).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

// Rigidities of the (10,10) tube from Table 1's inputs, by hand: E = 1029 GPa, G = 459 GPa.
constexpr double gigapascal = 6.241509074e-3, pi = std::numbers::pi;
constexpr double rf = 6.78, wall = 3.35, length = 13.56;
constexpr double area = 2 * pi * wall * rf, moment = pi * wall * rf * (rf * rf + wall * wall / 4);
constexpr double EJ = 1029 * gigapascal * moment, GJp = 459 * gigapascal * 2 * moment,
                 ES = 1029 * gigapascal * area;

/// A fibre along x with the first segment held, loaded at the last one, damped until it rests.
std::vector<double> settle(const Folder& folder, int segments, const std::string& load,
                           const char* dataset, int steps) {
  const double tip = (segments - 1) * length;
  auto region = [](double x) {
    return std::to_string(x - 1) + ",-100,-100," + std::to_string(x + 1) + ",100,100";
  };
  const auto outcome =
      run(folder, "-scene fibre -fibre_segments " + std::to_string(segments) +
                      " -pair none -damping_local 0.7 -ts_dt 20 -ts_max_steps " +
                      std::to_string(steps) + " -bc root,tip -root_region " + region(0) +
                      " -root_fix 1,1,1 -root_fix_rotation -tip_region " + region(tip) + " " +
                      load + " -state_output out.h5 -overwrite");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return readDataset(folder / "out.h5", dataset);
}

TEST(Mechanics, CantileverIsExactAtEveryNode) {
  for (int segments : {4, 11}) {
    const Folder folder;
    const double l = (segments - 1) * length,
                 load = 1e-6 * 3 * EJ / (l * l);  // tip deflection 1e-6 l
    char text[64];
    std::snprintf(text, sizeof text, "-tip_force 0,0,%.17g", load);
    const auto x = settle(folder, segments, text, "/state/position", 60000);
    for (int k = 1; k < segments; ++k) {
      const double s = k * length, expected = load * s * s * (3 * l - s) / (6 * EJ);
      EXPECT_NEAR(x[static_cast<std::size_t>(3 * k + 2)] / expected, 1.0, 1e-6)
          << "node " << k << " of " << segments;
    }
  }
}

TEST(Mechanics, TwistedRod) {
  const Folder folder;
  const int segments = 9;
  const double couple = 0.05 * GJp / ((segments - 1) * length);  // 0.05 rad at the end
  char text[64];
  std::snprintf(text, sizeof text, "-tip_torque %.17g,0,0", couple);
  const auto q = settle(folder, segments, text, "/state/orientation", 40000);
  const std::size_t last = 4 * (segments - 1);
  // Each of 8 bonds twists by B4 sin(t) = M.
  const double expected = 8 * std::asin(couple / (GJp / length));
  EXPECT_NEAR(2 * std::atan2(q[last + 1], q[last]), expected, 1e-9);
}

TEST(Mechanics, StretchedRod) {
  const Folder folder;
  const int segments = 9;
  const auto x = settle(folder, segments, "-tip_force 2,0,0", "/state/position", 40000);
  EXPECT_NEAR(x[3 * (segments - 1)] / ((segments - 1) * length * (1 + 2 / ES)), 1.0, 1e-10);
}

TEST(Mechanics, EndMomentBendsIntoACircularArc) {
  const Folder folder;
  const int segments = 13;
  const double angle = 0.01, l = (segments - 1) * length;
  char text[64];
  std::snprintf(text, sizeof text, "-tip_torque 0,%.17g,0", -EJ * angle / l);
  const auto x = settle(folder, segments, text, "/state/position", 100000);
  // Pure bending: every node on the circle of radius l/angle, to second order in the bond's turn.
  for (int k = 1; k < segments; ++k) {
    const double s = k * length / l * angle;
    EXPECT_NEAR(x[static_cast<std::size_t>(3 * k + 2)], l / angle * (1 - std::cos(s)), 2e-6 * l);
  }
}

TEST(Mechanics, WhatIsFreeFliesStraightAndSpinsEvenly) {
  const Folder folder;
  const Vec3d v{1e-3, -2e-3, 5e-4}, w{1e-3, 2e-3, -1e-3};
  const FibreInput fibre = straightFibre({0, 0, 0}, {1.0 / 3, 2.0 / 3, 2.0 / 3}, 8),
                   lone = straightFibre({0, 400, 0}, {0, 0, 1}, 1);
  writeState(folder / "in.h5", {fibre, lone});
  setMotion(
      folder / "in.h5", [&](std::size_t, const Vec3d&) { return v; },
      [&](std::size_t row, const Vec3d&) { return row == 8 ? w : Vec3d{}; });
  const auto outcome = run(folder,
                           "-scene file -scene_file in.h5 -pair none -ts_dt 10 -ts_max_steps 100 "
                           "-energy_monitor ascii:energy.csv -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto before = readVectors(folder / "in.h5", "/state/position"),
             after = readVectors(folder / "out.h5", "/state/position");
  const auto turned = readOrientations(folder / "out.h5"),
             unturned = readOrientations(folder / "in.h5");
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_LT(norm(after[i] - before[i] - 1000.0 * v), 1e-9) << i;
    const Quatd expected = i == 8 ? rotation(1000.0 * w) * unturned[i] : unturned[i];
    const Quatd& q = turned[i];
    EXPECT_NEAR(std::abs(q.w * expected.w + q.x * expected.x + q.y * expected.y + q.z * expected.z),
                1, 1e-12)
        << i;
    EXPECT_LT(norm(Vec3d{q.x, q.y, q.z} - Vec3d{expected.x, expected.y, expected.z}), 1e-9) << i;
  }
  const auto energy = readCsv(folder / "energy.csv");
  EXPECT_NEAR(energy.at("kinetic").back() / (9 * 0.5 * tube::mass * dot(v, v)), 1, 1e-12);
  EXPECT_NEAR(energy.at("rotational").back() / (0.5 * tube::inertia * dot(w, w)), 1, 1e-12);
}

TEST(Mechanics, PeriodicClosedFibreIsUnstrained) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 40 -fibre_closed -domain_lower 0,-200,-200 -domain_upper "
          "542.4,200,200 "
          "-domain_periodic 1,0,0 -ts_max_steps 200 -energy_monitor ascii:energy.csv",
          2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_LT(readCsv(folder / "energy.csv").at("total").back(), 1e-18);
}

TEST(Mechanics, RingHasTheEnergyOfAClosedElastica) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 200 -fibre_closed -fibre_bend 6.283185307179586 -pair none "
          "-ts_max_steps 0 -energy_monitor ascii:energy.csv");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const double l = 200 * length;
  EXPECT_NEAR(readCsv(folder / "energy.csv").at("total").front() / (2 * pi * pi * EJ / l), 1.0,
              2e-4);
}

TEST(Mechanics, StepLimitOfAFreeChain) {
  // 2/0.04135 fs, the bending-shear branch's highest frequency: printed and enforced.
  const Folder folder;
  const auto accepted =
      run(folder, "-scene fibre -fibre_segments 60 -pair none -ts_dt 47.5 -ts_max_steps 1");
  EXPECT_EQ(accepted.status, 0) << accepted.output;
  EXPECT_NE(accepted.output.find("48.37 for a free chain"), std::string::npos) << accepted.output;
  const auto refused =
      run(folder, "-scene fibre -fibre_segments 60 -pair none -ts_dt 49.5 -ts_max_steps 1");
  EXPECT_EQ(refused.status, 1) << refused.output;
}

}  // namespace
}  // namespace nanoweft::test
