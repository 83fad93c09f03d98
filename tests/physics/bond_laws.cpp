/// Bonds that are more than elastic: internal viscosity (model.md 13) and plastic flow (14).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::pi;
constexpr int segments = 20;
constexpr double q = 2 * pi / segments;  ///< phase from a segment to the next

/// A closed fibre through a periodic box, each segment displaced and turned by one wave.
FibreInput wave(const Vec3d& displacement, const Vec3d& turn) {
  FibreInput fibre;
  for (int k = 0; k < segments; ++k) {
    fibre.position.push_back(Vec3d{(k + 0.5) * tube::length, 0, 0} +
                             std::sin(k * q) * displacement);
    fibre.orientation.push_back(rotation(std::cos(k * q) * Vec3d{0, turn.y, turn.z} +
                                         std::sin(k * q) * Vec3d{turn.x, 0, 0}));
  }
  fibre.closed = true;
  return fibre;
}

/// How fast the energy of a wave falls, over six periods of its frequency `w`.
double decayRate(const FibreInput& fibre, double w, const std::string& options) {
  const Folder folder;
  writeState(folder / "in.h5", {fibre},
             {{0, -500, -500}, {segments * tube::length, 500, 500}, {true, false, false}});
  const double period = 2 * pi / w;
  const int steps = static_cast<int>(std::ceil(period / 8));
  const auto outcome =
      run(folder,
          "-scene file -scene_file in.h5 -pair none -progress_interval 0 -energy_monitor "
          "ascii:energy.csv -monitor_interval " +
              std::to_string(steps) + " -ts_max_steps " + std::to_string(7 * steps) + " -ts_dt " +
              std::to_string(period / steps) + " " + options);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto energies = readCsv(folder / "energy.csv");
  const auto& total = energies.at("total");
  EXPECT_EQ(total.size(), 8u);
  for (std::size_t k = 0; k < total.size(); ++k)
    EXPECT_NEAR(total[k] + energies.at("damped")[k], total[0], 2e-3 * total[0]);
  return std::log(total[1] / total[7]) / (6 * period);
}

std::string each(double stretch, double shear, double bending, double torsion) {
  return "-fibre_retardation_each " + std::to_string(stretch) + "," + std::to_string(shear) + "," +
         std::to_string(bending) + "," + std::to_string(torsion);
}

TEST(InternalViscosity, ABendingModeDecaysAtItsClosedForm) {
  // The lower branch of the chain's bending waves.
  const double bend = 0.25 * tube::B2 + tube::B3 + 0.5 * tube::B4;
  const double ww = 2 * tube::B2 / (tube::length * tube::length) * (1 - std::cos(q)) / tube::mass;
  const double tt =
      (0.25 * tube::B2 * (2 + 2 * std::cos(q)) + bend * (2 - 2 * std::cos(q))) / tube::inertia;
  const double wt = tube::B2 / tube::length * std::sin(q) / std::sqrt(tube::mass * tube::inertia);
  const double square = 0.5 * (ww + tt) - std::hypot(0.5 * (ww - tt), wt);
  const double w = std::sqrt(square), time = 0.02 / w;
  // Turned as a segment of the wave's slope; what that misses of the mode dies out at once.
  const double height = 0.1;
  const FibreInput fibre = wave({0, 0, height}, {0, -height * q / tube::length, 0});
  EXPECT_NEAR(decayRate(fibre, w, "-fibre_retardation " + std::to_string(time)) / (time * square),
              1.0, 0.01);
  EXPECT_NEAR(decayRate(fibre, w, each(0, time, time, 0)) / (time * square), 1.0, 0.01);
}

TEST(InternalViscosity, StretchingAndTwistingModesDecayWithTheirOwnTimes) {
  const double sine = std::sin(0.5 * q);
  const double stretching = 4 * tube::B1 / tube::mass * sine * sine,
               twisting = 4 * tube::B4 / tube::inertia * sine * sine;
  const double time = 0.02 / std::sqrt(stretching), other = 0.02 / std::sqrt(twisting);
  EXPECT_NEAR(decayRate(wave({0.01, 0, 0}, {0, 0, 0}), std::sqrt(stretching), each(time, 0, 0, 0)) /
                  (time * stretching),
              1.0, 0.01);
  EXPECT_NEAR(decayRate(wave({0, 0, 0}, {1e-3, 0, 0}), std::sqrt(twisting), each(0, 0, 0, other)) /
                  (other * twisting),
              1.0, 0.01);
}

TEST(InternalViscosity, ABentFibreThatFliesAndSpinsKeepsItsMomenta) {
  const Folder folder;
  const std::string fibre = "-pair none -progress_interval 0 -fibre_retardation 40 -ts_dt 4 ";
  auto outcome = run(folder,
                     "-scene fibre -fibre_segments 9 -fibre_bend 0.5 -ts_max_steps 0 -state_output "
                     "in.h5 " +
                         fibre);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  setMotion(
      folder / "in.h5",
      [](std::size_t row, const Vec3d&) {
        return Vec3d{1e-4, 2e-4 * static_cast<double>(row), -1e-4};
      },
      [](std::size_t, const Vec3d&) {
        return Vec3d{1e-5, -2e-5, 3e-5};
      });
  auto momenta = [&](const std::string& file) {
    const auto x = readVectors(folder / file, "/state/position"),
               v = readVectors(folder / file, "/state/velocity"),
               w = readVectors(folder / file, "/state/angular_velocity");
    std::pair<Vec3d, Vec3d> sum;
    for (std::size_t k = 0; k < x.size(); ++k) {
      sum.first += tube::mass * v[k];
      sum.second += tube::mass * cross(x[k], v[k]) + tube::inertia * w[k];
    }
    return sum;
  };
  outcome = run(folder,
                "-scene file -scene_file in.h5 -scene_file_edited -ts_max_steps 5000 "
                "-state_output out.h5 " +
                    fibre);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto [p, l] = momenta("in.h5");
  const auto [p1, l1] = momenta("out.h5");
  EXPECT_LT(norm(p1 - p), 1e-10 * norm(p));
  EXPECT_LT(norm(l1 - l), 1e-9 * norm(l));
}

TEST(InternalViscosity, ShortensTheStableStepAndIsCheckedWhenRead) {
  const Folder folder;
  const std::string fibre = "-scene fibre -fibre_segments 20 -pair none -ts_max_steps 1 ";
  expectRefused(run(folder, fibre + "-fibre_retardation 100 -ts_dt 20"), {"-ts_dt 20"});
  const auto outcome = run(folder, fibre + "-fibre_retardation 100 -ts_dt 10");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  expectRefused(run(folder, fibre + "-fibre_retardation -1"), {"-fibre_retardation"});
  expectRefused(run(folder, fibre + "-fibre_retardation_each 1,-1,1,1"),
                {"-fibre_retardation_each", "-1"});
  expectRefused(run(folder, fibre + "-fibre_retardation 1 -fibre_retardation_each 1,1,1,1"),
                {"-fibre_retardation", "one of the two"});
  expectRefused(run(folder, fibre + "-fibre_yield_strain 0"), {"-fibre_yield_strain"});
  expectRefused(run(folder, fibre + "-fibre_yield_curvature nan"), {"-fibre_yield_curvature"});
}

/// Angle between the first axes of the first and the last segment, summed along the fibre.
double angleOf(const std::string& file) {
  const auto all = readOrientations(file);
  double sum = 0;
  for (std::size_t k = 1; k < all.size(); ++k)
    sum += std::acos(std::clamp(dot(axis1(all[k - 1]), axis1(all[k])), -1.0, 1.0));
  return sum;
}

TEST(PlasticFlow, AWireThatIsBentAndLetGoKeepsWhatIsBeyondItsElasticAngle) {
  const Folder folder;
  const double bent = 2.4, bonds = 12, yield = 0.008 * tube::length;
  const std::string options =
      "-scene fibre -pair none -fibre_yield_curvature 0.008 -progress_interval 0 ";
  // Two segments have one mode: what they keep is exact.
  auto outcome = run(folder, options +
                                 "-fibre_segments 2 -fibre_bend 0.2 -damping_local 0.3 -ts_dt 10 "
                                 "-ts_max_steps 4000 -state_output two.h5 -energy_monitor "
                                 "ascii:energy.csv");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NEAR(angleOf(folder / "two.h5"), 0.2 - yield, 1e-9);
  const auto energies = readCsv(folder / "energy.csv");
  EXPECT_NEAR(energies.at("damped").back(), energies.at("total").front(),
              1e-3 * energies.at("total").front());
  EXPECT_LT(energies.at("total").back(), 1e-9);
  // Viscosity keeps a whole wire from swinging back beyond its rest.
  outcome = run(folder, options +
                            "-fibre_segments 13 -fibre_bend 2.4 -fibre_retardation 1000 "
                            "-damping_local 0.2 -ts_dt 1 -ts_max_steps 60000 -state_output w.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NEAR(angleOf(folder / "w.h5") / (bent - bonds * yield), 1.0, 0.03);
}

TEST(PlasticFlow, AWireThatIsStretchedTooFarStaysLonger) {
  for (const double strain : {0.05, -0.05, 0.015}) {
    const Folder folder;
    FibreInput fibre = straightFibre({0, 0, 0}, {1, 0, 0}, 2);
    fibre.position[1].x = tube::length * (1 + strain);
    writeState(folder / "in.h5", {fibre});
    const auto outcome =
        run(folder,
            "-scene file -scene_file in.h5 -start_unchecked -pair none -damping_local 0.3 "
            "-fibre_yield_strain 0.02 -ts_dt 10 -ts_max_steps 3000 -progress_interval 0 "
            "-state_output out.h5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const double kept = std::copysign(std::max(std::abs(strain) - 0.02, 0.0), strain);
    const auto x = readVectors(folder / "out.h5", "/state/position");
    EXPECT_NEAR((x[1].x - x[0].x) / (tube::length * (1 + kept)), 1.0, 1e-10);
    EXPECT_NEAR(readDataset(folder / "out.h5", "/state/rest_extension")[0], kept * tube::length,
                1e-12);
  }
}

TEST(PlasticFlow, ABondThatHasFlowedTooFarIsReported) {
  for (const auto& [strain, reported] : {std::pair{0.4, false}, std::pair{0.6, true}})
    for (const int ranks : {1, 2}) {
      const Folder folder;
      FibreInput fibre = straightFibre({0, 0, 0}, {1, 0, 0}, 3);
      fibre.position[2].x += tube::length * strain;
      writeState(folder / "in.h5", {straightFibre({0, 500, 0}, {1, 0, 0}, 3), fibre});
      const auto outcome = run(folder,
                               "-scene file -scene_file in.h5 -start_unchecked -pair none "
                               "-fibre_yield_strain 0.02 -ts_dt 10 -ts_max_steps 100",
                               ranks);
      ASSERT_EQ(outcome.status, 0) << outcome.output;
      EXPECT_EQ(
          outcome.output.find("fibre 1 flows, and its bond behind segment 1") != std::string::npos,
          reported)
          << outcome.output;
    }
}

/// Two segments, the second of which is turned about an axis across the first.
std::string hinge(const std::string& options) {
  return "-scene fibre -fibre_segments 2 -pair none -bc root,tip -root_region -1,-1,-1,1,1,1 "
         "-root_fix 1,1,1 -root_fix_rotation -tip_region 12,-1,-1,14,1,1 -tip_axis 0,0,1 -ts_dt 10 "
         "-monitor_interval 100 -energy_monitor ascii:e.csv -progress_interval 0 " +
         options;
}

TEST(PlasticFlow, AFoldStopsShortOfPi) {
  const Folder folder;
  const auto outcome = run(folder, hinge("-tip_spin 4e-5 -tip_centre 6.78,6,0 "
                                         "-fibre_yield_curvature 0.01 -ts_max_steps 9500"));
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(says(outcome, "at 3 rad it stops to flow")) << outcome.output;
  const auto damped = readCsv(folder / "e.csv").at("damped");
  EXPECT_GT(damped.back(), 500);
  for (std::size_t k = 1; k < damped.size(); ++k)
    ASSERT_GE(damped[k], damped[k - 1] - 1e-6 * damped.back()) << k;
}

TEST(PlasticFlow, NeverGivesEnergy) {
  const Folder folder;
  ASSERT_EQ(run(folder, hinge("-fibre_twist 0.5 -tip_spin 1e-5 -tip_centre 6.78,0,0 "
                              "-fibre_yield_curvature 0.004 -ts_max_steps 8000"))
                .status,
            0);
  const auto damped = readCsv(folder / "e.csv").at("damped");
  EXPECT_GT(damped.back(), 1);
  for (std::size_t k = 1; k < damped.size(); ++k)
    ASSERT_GE(damped[k], damped[k - 1] - 1e-6 * damped.back()) << k;
}

TEST(PlasticFlow, AFibreThatIsCurvedAtRestFlowsFromThatShape) {
  const Folder folder;
  const double rest = 0.005 * tube::length, yield = 0.002 * tube::length;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 2 -pair none -fibre_rest_curvature 0.005,0 "
          "-fibre_yield_curvature 0.002 -damping_local 0.3 -ts_dt 10 -ts_max_steps 3000 "
          "-progress_interval 0 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NEAR(angleOf(folder / "out.h5"), rest - (rest - yield), 1e-9);
}

}  // namespace
}  // namespace nanoweft::test
