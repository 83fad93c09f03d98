/// What follows a break, and what long or reversed motion leaves of the conserved quantities.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::pi;

double imbalance(const std::map<std::string, std::vector<double>>& csv) {
  auto balance = [&](std::size_t i) {
    return csv.at("total")[i] + csv.at("damped")[i] + csv.at("broken")[i] - csv.at("external")[i];
  };
  double worst = 0;
  for (std::size_t k = 0; k < csv.at("step").size(); ++k)
    worst = std::max(worst, std::abs(balance(k) - balance(0)));
  return worst;
}

/// Velocity of mass k after the end of a chain of masses, stretched by u a bond, was let go at time
/// 0: w u times the integral of (2k+1) J_{2k+1}(x)/x up to x = 2wt, with w = sqrt(B1/m). It tends
/// to w u = strain sqrt(ES/rho), behind a front that moves one segment in each 1/w.
double recoilVelocity(int k, double time, double stretch) {
  const double w = std::sqrt(tube::B1 / tube::mass), end = 2 * w * time;
  const int n = 2 * std::max(20, static_cast<int>(20 * end));
  auto f = [&](double x) {
    return x == 0 ? (k == 0 ? 0.5 : 0.0) : std::cyl_bessel_j(2 * k + 1, x) / x;
  };
  double sum = f(0) + f(end);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * f(end * i / n);
  return w * stretch * (2 * k + 1) * sum * end / n / 3;
}

TEST(Recoil, FrontRunsWithTheSoundSpeedAfterABreakAt30PerCent) {
  // A chain held at both ends at a strain just below critical; one bond in the middle is just
  // beyond it. Its energy goes to the account of broken bonds, the rest is kept.
  const int half = 60;
  const double strain = 0.2999, over = 0.3001, stretch = strain * tube::length;
  FibreInput chain;
  double x = 0;
  for (int k = 0; k < 2 * half; ++k) {
    chain.position.push_back({x, 0, 0});
    chain.orientation.push_back({1, 0, 0, 0});
    x += tube::length * (1 + (k == half - 1 ? over : strain));
  }
  const double last = chain.position.back().x, time = 2800;  // the front is at segment 44 of 60
  BoxInput box;
  box.upper[0] = 3000;
  double errors[2], balance[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    writeState(folder / "in.h5", {chain}, box);
    const auto outcome =
        run(folder,
            "-scene file -scene_file in.h5 -start_unchecked -pair none -break_strain_mean 0.3 "
            "-break_strain_std 0 "
            "-bc left,right -left_region -1,-1,-1,1,1,1 -left_fix 1,1,1 -right_region " +
                std::to_string(last - 1) + ",-1,-1," + std::to_string(last + 1) +
                ",1,1 -right_fix 1,1,1 -ts_max_time " + std::to_string(time) +
                (k ? " -ts_dt 1" : " -ts_dt 2") +
                " -energy_monitor ascii:energy.csv -monitor_interval 1 -state_output out.h5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto broken = readDataset(folder / "out.h5", "/state/bond_broken");
    for (int b = 0; b < 2 * half; ++b)
      EXPECT_EQ(broken[static_cast<std::size_t>(b)], b == half - 1) << "bond " << b;
    const auto csv = readCsv(folder / "energy.csv");
    EXPECT_NEAR(csv.at("broken").back(), 0.5 * tube::B1 * std::pow(over * tube::length, 2), 1e-8);
    EXPECT_EQ(csv.at("broken").back(), csv.at("broken").front());
    balance[k] = imbalance(csv) / csv.at("total").front();
    const auto v = readVectors(folder / "out.h5", "/state/velocity");
    errors[k] = 0;
    for (int m = 0; m < half - 1; ++m) {
      const double expected = recoilVelocity(m, time, stretch);
      const auto right = static_cast<std::size_t>(half + m),
                 left = static_cast<std::size_t>(half - 1 - m);
      errors[k] =
          std::max({errors[k], std::abs(v[right].x - expected), std::abs(v[left].x + expected)});
      EXPECT_LT(std::hypot(v[right].y, v[right].z), 1e-12);
    }
    // The front, where the velocity passes a third of its final value, by the sound speed.
    const double speed = strain * std::sqrt(tube::ES / (tube::mass / tube::length)),
                 front = std::sqrt(tube::B1 / tube::mass) * time - 0.5;
    const auto m = static_cast<std::size_t>(front);
    const double part = front - static_cast<double>(m);
    EXPECT_NEAR(((1 - part) * v[half + m].x + part * v[half + m + 1].x) / speed, 1.0 / 3, 0.02);
  }
  // Verlet's phase error of the fastest part, w t (w dt)^2/24 with w = 0.031/fs, of 0.064 A/fs.
  EXPECT_LT(errors[0], 0.064 * 0.031 * time * 0.062 * 0.062 / 24);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.4);
  EXPECT_LT(balance[0], 1e-3);
  EXPECT_NEAR(balance[0] / balance[1], 4, 0.4);
}

TEST(Recoil, CascadeBreaksEachBondOnceAndIsAudited) {
  // Equal critical strains of 0.2; grips and all segments between them part with 4e-4/fs, so that
  // there is no time for a first break to relieve the other bonds (Mott's fragmentation).
  const double critical = 0.2, rate = 4e-4,
               least = 0.5 * tube::B1 * std::pow(critical * tube::length, 2);
  const double middle = 29.5 * tube::length;
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 60)});
    setMotion(
        folder / "in.h5",
        [&](std::size_t, const Vec3d& x) {
          return Vec3d{rate * (x.x - middle), 0, 0};
        },
        [](std::size_t, const Vec3d&) { return Vec3d{}; });
    const auto outcome = run(
        folder,
        std::string("-scene file -scene_file in.h5 -start_unchecked -scene_perturb 0.1 -pair none "
                    "-break_strain_mean 0.2 -break_strain_std 0 -tension_rate 4e-4 -tension_ramp 0 "
                    "-tension_grip 14 -tension_width 17 -tension_max_strain 1 -energy_monitor "
                    "ascii:energy.csv -stress_monitor ascii:stress.csv -monitor_interval 1 "
                    "-state_output out.h5 ") +
            (k ? "-ts_dt 0.25" : "-ts_dt 1"));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto csv = readCsv(folder / "energy.csv"), stress = readCsv(folder / "stress.csv");
    const auto& count = stress.at("broken_bonds");
    const auto& released = csv.at("broken");
    EXPECT_TRUE(std::ranges::is_sorted(count));
    EXPECT_GT(count.back(), 8);
    double final = 0;
    for (double b : readDataset(folder / "out.h5", "/state/bond_broken")) final += b;
    EXPECT_EQ(final, count.back());
    for (std::size_t s = 1; s < count.size(); ++s) {
      // Each break frees what its bond held: at least the energy at the critical strain, and no
      // more than what it has grown to within a step.
      const double broke = count[s] - count[s - 1], freed = released[s] - released[s - 1];
      EXPECT_GE(freed, broke * least * (1 - 1e-12));
      EXPECT_LE(freed, broke * least * 1.05);
    }
    errors[k] = imbalance(csv) / csv.at("external").back();
  }
  EXPECT_LT(errors[0], 0.01);
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

/// Total angular momentum about the origin.
Vec3d angularMomentum(const std::string& file) {
  const auto x = readVectors(file, "/state/position"), v = readVectors(file, "/state/velocity"),
             w = readVectors(file, "/state/angular_velocity");
  Vec3d sum;
  for (std::size_t i = 0; i < x.size(); ++i)
    sum += tube::mass * cross(x[i], v[i]) + tube::inertia * w[i];
  return sum;
}

double worstNorm(const std::vector<Quatd>& orientations) {
  double worst = 0;
  for (const Quatd& q : orientations)
    worst = std::max(worst, std::abs(std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z) - 1));
  return worst;
}

TEST(Recoil, SpinningFibreKeepsAngularMomentumOverAMillionSteps) {
  // Four segments about all three axes, 0.06 rad a step: 1.6e4 turns, with the fibre stretched and
  // bent by the spin.
  const Folder folder;
  const Vec3d spin{0.002, 0.001, 0.003};
  writeState(folder / "in.h5", {straightFibre({-1.5 * tube::length, 0, 0}, {1, 0, 0}, 4)});
  setMotion(
      folder / "in.h5", [&](std::size_t, const Vec3d& x) { return cross(spin, x); },
      [&](std::size_t, const Vec3d&) { return spin; });
  const Vec3d before = angularMomentum(folder / "in.h5");
  const auto outcome = run(folder,
                           "-scene file -scene_file in.h5 -start_unchecked -pair none -ts_dt 16 "
                           "-ts_max_steps 1000000 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // A million roundings, all to the same side.
  EXPECT_LT(norm(angularMomentum(folder / "out.h5") - before), 1e6 * 1.1e-16 * norm(before));
  EXPECT_LT(worstNorm(readOrientations(folder / "out.h5")), 1e-14);
}

TEST(Recoil, FastSpinAboutTheAxisTurnsAsFarAsItShould) {
  // 0.9 rad in a step, the most that is not called unstable being 1; 16 fs times the velocity gives
  // the double 0.9 exactly.
  const Folder folder;
  const double angle = 0.9;
  const long steps = 1000000;
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 3)});
  setMotion(
      folder / "in.h5", [](std::size_t, const Vec3d&) { return Vec3d{}; },
      [&](std::size_t, const Vec3d&) {
        return Vec3d{angle / 16, 0, 0};
      });
  const auto start = readOrientations(folder / "in.h5").front();
  const auto outcome = run(folder,
                           "-scene file -scene_file in.h5 -start_unchecked -pair none -ts_dt 16 "
                           "-ts_max_steps 1000000 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto turned = static_cast<double>(
      std::remainder(static_cast<long double>(angle) * steps, 2 * std::numbers::pi_v<long double>));
  const Quatd expected = rotation({turned, 0, 0}) * start;
  const auto q = readOrientations(folder / "out.h5");
  for (const Quatd& o : q) {
    const double cosine = o.w * expected.w + o.x * expected.x + o.y * expected.y + o.z * expected.z;
    const Quatd between = Quatd{o.w, -o.x, -o.y, -o.z} * expected;
    const double off = 2 * std::hypot(between.x, between.y, between.z);
    // A rounding of each step's rotation, every time the same.
    EXPECT_LT(off, steps * 2.2e-16 * 2) << cosine;
  }
  EXPECT_LT(worstNorm(q), 1e-14);
  const auto w = readVectors(folder / "out.h5", "/state/angular_velocity");
  for (const Vec3d& a : w) EXPECT_NEAR(a.x / (angle / 16), 1, 1e-9);
}

/// Runs `scene` for some steps, turns all motion around and runs as many steps: the largest
/// distance from the start, of positions in A and of axes.
double wayBack(const std::string& scene, int steps, const std::string& options) {
  const Folder folder;
  auto outcome = run(folder, scene + " -ts_max_steps 0 -state_output in.h5 " + options);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const std::string go = "-scene file -ts_max_steps " + std::to_string(steps) + " " + options;
  outcome = run(folder, go + " -scene_file in.h5 -state_output there.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  reverseMotion(folder / "there.h5");
  outcome = run(folder, go + " -scene_file there.h5 -state_output back.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  double worst = 0, moved = 0;
  const auto a = readDataset(folder / "in.h5", "/state/position"),
             b = readDataset(folder / "back.h5", "/state/position"),
             c = readDataset(folder / "there.h5", "/state/position");
  for (std::size_t k = 0; k < a.size(); ++k) {
    worst = std::max(worst, std::abs(a[k] - b[k]));
    moved = std::max(moved, std::abs(a[k] - c[k]));
  }
  EXPECT_GT(moved, 1);  // so that there is a way back
  const auto q = readOrientations(folder / "in.h5"), r = readOrientations(folder / "back.h5");
  for (std::size_t k = 0; k < q.size(); ++k) {
    const Quatd d = Quatd{q[k].w, -q[k].x, -q[k].y, -q[k].z} * r[k];
    worst = std::max(worst, 2 * std::hypot(d.x, d.y, d.z));
  }
  return worst;
}

// Verlet is reversible, its sums of floating-point numbers are not: each step leaves a rounding of
// 1e-14 A (of positions of 100 A), and what separates from then on grows with time.

TEST(Recoil, FibreComesBackWhenTimeIsReversed) {
  // Regular motion: separations grow in proportion to the 2 x 5000 steps at most, 1e-14 A each.
  EXPECT_LT(wayBack("-scene fibre -fibre_segments 24 -fibre_bend 0.3 -fibre_strain 0.01", 5000,
                    "-pair none -ts_dt 16"),
            1e-10);
}

TEST(Recoil, WeaveComesBackWhenTimeIsReversed) {
  // Contacts make it chaotic, so that separations grow exponentially in the end; over 2 x 500 steps
  // of 12 fs, a collision or two a contact, they grow less than tenfold beyond 1e-11 A.
  EXPECT_LT(wayBack("-weave_fibres 4,4 -weave_segments 24", 500, "-ts_dt 12"), 1e-10);
}

}  // namespace
}  // namespace nanoweft::test
