/// Bonds far from rest: stretched by 30 %, bent by a right angle, twisted by 170 degrees; and a rod
/// that keeps its many turns.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::pi;

const std::string fromFile = "-scene file -scene_file in.h5 -pair none -start_unchecked ";

/// Bonds of one kind all along: strain, bend about z between neighbours (chords lie half-way),
/// twist.
FibreInput strained(int segments, double strain, double bend, double twist) {
  FibreInput fibre;
  Vec3d x;
  for (int k = 0; k < segments; ++k) {
    const Quatd direction = rotation({0, 0, k * bend}), roll = rotation({k * twist, 0, 0});
    fibre.position.push_back(x);
    fibre.orientation.push_back(direction * roll);
    const double angle = (k + 0.5) * bend;
    x += (tube::length * (1 + strain)) * Vec3d{std::cos(angle), std::sin(angle), 0};
  }
  return fibre;
}

/// Energies, forces and torques of an open chain from the formulas.
void expectFormulas(const FibreInput& chain) {
  const Folder folder;
  writeState(folder / "in.h5", {chain});
  const auto outcome = run(folder, fromFile +
                                       "-ts_max_steps 0 -energy_monitor ascii:energy.csv "
                                       "-state_output out.h5 -state_forces");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::size_t n = chain.position.size();
  std::vector<Vec3d> force(n), torque(n);
  double stretch = 0, shear = 0, bending = 0, torsion = 0, sum = 0;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const auto b = tube::bond(chain.position[k], chain.orientation[k], chain.position[k + 1],
                              chain.orientation[k + 1]);
    stretch += b.stretch, shear += b.shear, bending += b.bending, torsion += b.torsion;
    sum += b.sum;
    force[k] += b.forceI;
    force[k + 1] -= b.forceI;
    torque[k] += b.torqueI;
    torque[k + 1] += b.torqueJ;
  }
  // Sums of terms as large as B2 = 19780 eV: some twenty roundings a bond.
  const double bound = static_cast<double>(n) * 20 * tube::B2 * 1.1e-16;
  const auto csv = readCsv(folder / "energy.csv");
  EXPECT_NEAR(csv.at("stretch").front(), stretch, bound);
  EXPECT_NEAR(csv.at("shear").front(), shear, bound);
  EXPECT_NEAR(csv.at("bending").front(), bending, bound);
  EXPECT_NEAR(csv.at("torsion").front(), torsion, bound);
  EXPECT_NEAR(csv.at("total").front(), sum, bound);
  const auto f = readVectors(folder / "out.h5", "/state/force"),
             t = readVectors(folder / "out.h5", "/state/torque");
  for (std::size_t k = 0; k < n; ++k) {
    EXPECT_LT(norm(f[k] - force[k]), bound) << "force on segment " << k;
    EXPECT_LT(norm(t[k] - torque[k]), bound) << "torque on segment " << k;
  }
}

TEST(LargeStrain, EnergiesForcesAndTorquesFollowTheFormulas) {
  const double right = pi / 2, nearlyHalf = 170 * pi / 180;
  for (int segments : {2, 6}) {
    expectFormulas(strained(segments, 0.3, 0, 0));
    expectFormulas(strained(segments, 0, right, 0));
    expectFormulas(strained(segments, 0, 0, nearlyHalf));
    expectFormulas(strained(segments, 0.3, right, nearlyHalf));
    expectFormulas(strained(segments, -0.3, -right, -nearlyHalf));
  }
}

TEST(LargeStrain, EnergiesOfTheThreeCasesInClosedForm) {
  // B1 (0.3 T)^2/2; a pure bend of angle b: B2 (1 - cos(b/2)) + (B3 + B4/2)(1 - cos b); B4 (1 - cos
  // t).
  const double bend = pi / 2, twist = 170 * pi / 180;
  const auto energy = [](const FibreInput& c) {
    return tube::bond(c.position[0], c.orientation[0], c.position[1], c.orientation[1]).sum;
  };
  EXPECT_NEAR(energy(strained(2, 0.3, 0, 0)), 0.5 * tube::B1 * std::pow(0.3 * tube::length, 2),
              1e-9);
  EXPECT_NEAR(
      energy(strained(2, 0, bend, 0)),
      tube::B2 * (1 - std::cos(bend / 2)) + (tube::B3 + tube::B4 / 2) * (1 - std::cos(bend)), 1e-9);
  EXPECT_NEAR(energy(strained(2, 0, 0, twist)), tube::B4 * (1 - std::cos(twist)), 1e-9);
}

/// Released from rest, a single bond swings through its rest state after `quarter`. Verlet gets
/// there with an error of second order in the step, and the energy balance has one of second order.
void expectSwing(const FibreInput& start, double quarter) {
  double amplitude[2], imbalance[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    writeState(folder / "in.h5", {start});
    const int steps = 200 << k;
    char dt[64];
    std::snprintf(dt, sizeof dt, "-ts_dt %.17g -ts_max_steps %d ", quarter / steps, steps);
    const auto outcome =
        run(folder, fromFile + dt + "-energy_monitor ascii:energy.csv -monitor_interval 1");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto csv = readCsv(folder / "energy.csv");
    const auto& total = csv.at("total");
    // The elastic energy is quadratic near rest: its root is the distance from rest.
    const double left = csv.at("stretch").back() + csv.at("shear").back() +
                        csv.at("bending").back() + csv.at("torsion").back();
    amplitude[k] = std::sqrt(left / total.front());
    imbalance[k] = 0;
    for (double e : total) imbalance[k] = std::max(imbalance[k], std::abs(e / total.front() - 1));
  }
  // A hundredth of a radian of phase a step or so: its square, over 24, times the phase.
  EXPECT_LT(amplitude[0], 1e-3);
  EXPECT_NEAR(amplitude[0] / amplitude[1], 4, 0.2);
  EXPECT_LT(imbalance[0], 1e-3);
  EXPECT_NEAR(imbalance[0] / imbalance[1], 4, 0.2);
}

TEST(LargeStrain, StretchedBondSwingsThroughRest) {
  expectSwing(strained(2, 0.3, 0, 0), pi / 2 / std::sqrt(2 * tube::B1 / tube::mass));
}

TEST(LargeStrain, TwistedBondSwingsThroughRestAsAPendulum) {
  const double angle = 170 * pi / 180;
  expectSwing(strained(2, 0, 0, angle),
              std::comp_ellint_1(std::sin(angle / 2)) / std::sqrt(2 * tube::B4 / tube::inertia));
}

TEST(LargeStrain, BentBondSwingsThroughRest) {
  // Both ends turn by a against the chord: I a'^2 + U(a) = U(pi/4), with U from the closed form.
  const auto energy = [](double a) {
    return tube::B2 * (1 - std::cos(a)) + (tube::B3 + tube::B4 / 2) * (1 - std::cos(2 * a));
  };
  const double most = pi / 4;
  double quarter = 0;
  const int n = 2000;  // midpoint rule after a = most sin(s), which takes out the root's zero
  for (int k = 0; k < n; ++k) {
    const double s = (k + 0.5) / n * pi / 2, a = most * std::sin(s);
    quarter +=
        most * std::cos(s) / std::sqrt((energy(most) - energy(a)) / tube::inertia) * pi / 2 / n;
  }
  expectSwing(strained(2, 0, pi / 2, 0), quarter);
}

TEST(LargeStrain, StretchedChainSwingsThroughRestInItsNormalModes) {
  // Released at 30 % strain, a free chain of n masses moves along its axis in its modes
  // cos(pi m (k + 1/2)/n) with frequencies 2 sqrt(B1/m) sin(pi m/(2n)).
  const int n = 6;
  const FibreInput start = strained(n, 0.3, 0, 0);
  const double time = 400;
  auto expected = [&](int k) {
    const double middle = 0.5 * (n - 1);
    double u = 0;
    for (int m = 1; m < n; ++m) {
      double share = 0;
      for (int j = 0; j < n; ++j)
        share += 2.0 / n * 0.3 * tube::length * (j - middle) * std::cos(pi * m * (j + 0.5) / n);
      u += share * std::cos(pi * m * (k + 0.5) / n) *
           std::cos(2 * std::sqrt(tube::B1 / tube::mass) * std::sin(pi * m / (2.0 * n)) * time);
    }
    return tube::length * (k - middle) + u;
  };
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    writeState(folder / "in.h5", {start});
    const auto outcome = run(folder, fromFile + (k ? "-ts_dt 0.5" : "-ts_dt 1") +
                                         " -ts_max_time 400 -state_output out.h5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto x = readVectors(folder / "out.h5", "/state/position");
    double centre = 0;
    for (const Vec3d& p : x) centre += p.x / n;
    errors[k] = 0;
    for (int j = 0; j < n; ++j)
      errors[k] =
          std::max(errors[k], std::abs(x[static_cast<std::size_t>(j)].x - centre - expected(j)));
  }
  // Phase error of Verlet: w t (w dt)^2/24 of an amplitude of 10 A, w = 0.03/fs at most.
  EXPECT_LT(errors[0], 10 * 0.03 * time * 0.03 * 0.03 / 24);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.2);
}

TEST(LargeStrain, BentAndTwistedChainKeepsItsEnergyToSecondOrder) {
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    writeState(folder / "in.h5", {strained(5, 0.3, pi / 2, 170 * pi / 180)});
    const auto outcome =
        run(folder, fromFile + (k ? "-ts_dt 0.25" : "-ts_dt 0.5") +
                        " -ts_max_time 1000 -energy_monitor ascii:energy.csv -monitor_interval 1");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto total = readCsv(folder / "energy.csv").at("total");
    errors[k] = 0;
    for (double e : total) errors[k] = std::max(errors[k], std::abs(e / total.front() - 1));
  }
  EXPECT_LT(errors[0], 1e-3);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2, 0.35);
}

/// Angle of the twist from one segment to the next, between -pi and pi.
double twistBetween(const Quatd& a, const Quatd& b) {
  const Quatd q = Quatd{a.w, -a.x, -a.y, -a.z} * b;
  return 2 * std::atan2(q.w < 0 ? -q.x : q.x, std::abs(q.w));
}

TEST(LargeStrain, RodHeldAtBothEndsKeepsTenTurns) {
  // 100 bonds, 0.2 pi rad each on average: at first 0.72 rad in one half and the rest in the other.
  // At 5 % strain it does not buckle: B4 sin(0.2 pi) = 865 eV is below 2 sqrt(EJ ES 0.05) = 2020
  // eV.
  const Folder folder;
  const int bonds = 100;
  const double angle = 0.2 * pi;
  FibreInput rod;
  double twist = 0;
  for (int k = 0; k <= bonds; ++k) {
    rod.position.push_back({1.05 * tube::length * k, 0, 0});
    rod.orientation.push_back(rotation({twist, 0, 0}));
    twist += k < bonds / 2 ? 0.72 : 2 * angle - 0.72;
  }
  BoxInput box;
  box.upper[0] = 2000;
  writeState(folder / "in.h5", {rod}, box);
  const std::string held =
      "-bc left,right -left_region -1,-1,-1,1,1,1 -left_fix 1,1,1 -left_fix_rotation "
      "-right_region 1423,-1,-1,1425,1,1 -right_fix 1,1,1 -right_fix_rotation ";
  auto turns = [&](const std::string& file) {
    const auto q = readOrientations(file);
    double sum = 0;
    for (std::size_t k = 0; k + 1 < q.size(); ++k) sum += twistBetween(q[k], q[k + 1]);
    return sum;
  };
  // First undamped: torsional waves and noise across the axis let no turn slip.
  auto outcome = run(
      folder, fromFile + held + "-scene_perturb 0.02 -ts_max_steps 20000 -state_output free.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NEAR(turns(folder / "free.h5"), bonds * angle, 0.05);
  // Then damped to rest, where every bond bears the couple B4 sin(0.2 pi).
  outcome = run(folder, "-scene file -scene_file free.h5 -pair none " + held +
                            "-damping_local 0.7 -ts_max_steps 100000 -state_output out.h5 "
                            "-state_forces -energy_monitor ascii:energy.csv");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NEAR(turns(folder / "out.h5"), bonds * angle, 1e-9);
  const auto torque = readVectors(folder / "out.h5", "/state/torque");
  const double couple = tube::B4 * std::sin(angle);
  EXPECT_NEAR(torque.front().x / couple, 1, 1e-6);
  EXPECT_NEAR(torque.back().x / couple, -1, 1e-6);
  EXPECT_NEAR(readCsv(folder / "energy.csv").at("torsion").back() /
                  (bonds * tube::B4 * (1 - std::cos(angle))),
              1, 1e-6);
}

}  // namespace
}  // namespace nanoweft::test
