/// What a number means must not depend on how finely a fibre is cut, nor on the system of units.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "support/program.hpp"

namespace nanoweft::test {
namespace {

constexpr double radius = 6.78;

FibreInput straight(const Vec3d& start, double length, int segments) {
  FibreInput fibre;
  for (int k = 0; k < segments; ++k) {
    fibre.position.push_back(start + Vec3d{k * length, 0, 0});
    fibre.orientation.push_back({1, 0, 0, 0});
  }
  return fibre;
}

std::string evaluated(double length) {
  char text[200];
  std::snprintf(text, sizeof text,
                "-scene file -scene_file in.h5 -fibre_segment_length %.17g -ts_max_steps 0 "
                "-start_unchecked -pair_points 9 -energy_monitor ascii:energy.csv ",
                length);
  return text;
}

TEST(SegmentLength, AdhesionPerLengthIsOneNumber) {
  // Two endless tubes at the smooth law's best distance: the integral of the law, with its range,
  // is -0.19365 eV/A (-0.193731 without a cutoff).
  const double whole = 40 * 13.56;
  for (double length : {0.5 * radius, radius, 2 * radius, 4 * radius}) {
    const Folder folder;
    const int segments = static_cast<int>(std::lround(whole / length));
    FibreInput a = straight({0, 0, 0}, length, segments),
               b = straight({0.3 * length, 17.0716, 0}, length, segments);
    a.closed = b.closed = true;
    BoxInput box;
    box.lower = {0, -200, -200}, box.upper = {whole, 200, 200}, box.periodic = {true, false, false};
    writeState(folder / "in.h5", {a, b}, box);
    const auto outcome = run(folder, evaluated(length));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const double energy = readCsv(folder / "energy.csv").at("pair").front();
    EXPECT_NEAR(energy / whole / -0.19365, 1.0, 1e-4) << length;
  }
}

TEST(SegmentLength, TheExclusionIsAnArcLength) {
  // Two places 20 A apart on one fibre (its bonds are not what this is about): they interact from
  // 271.2 A of arc on, 40 segments of rf, and not 39.
  for (int places : {39, 40}) {
    const Folder folder;
    FibreInput fibre = straight({0, 0, 0}, 60, 41);
    fibre.position[static_cast<std::size_t>(places)] = {0, 20, 0};
    BoxInput box;
    box.lower = {-1000, -1000, -1000}, box.upper = {6000, 6000, 1000};
    writeState(folder / "in.h5", {fibre}, box);
    const auto outcome = run(folder, evaluated(radius));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const double energy = readCsv(folder / "energy.csv").at("pair").front();
    if (places < 40)
      EXPECT_EQ(energy, 0.0);
    else
      EXPECT_LT(energy, -0.01);
  }
}

TEST(SegmentLength, ViscousDampingPerLengthIsOneNumber) {
  // Two endless tubes slide along each other without bonds' help: the power is g_line v^2, with
  // g_line from the pairs that have points within the cutoff: one per place up to 54.24 A and T to
  // each side.
  double power[2];
  int which = 0;
  for (double length : {2 * radius, radius}) {
    const Folder folder;
    const double whole = 40 * 13.56;
    const int segments = static_cast<int>(std::lround(whole / length));
    FibreInput a = straight({0, 0, 0}, length, segments),
               b = straight({0, 40, 0}, length, segments);
    a.closed = b.closed = true;
    BoxInput box;
    box.lower = {0, -200, -200}, box.upper = {whole, 200, 200}, box.periodic = {true, false, false};
    writeState(folder / "in.h5", {a, b}, box);
    const auto outcome = run(
        folder,
        "-scene file -scene_file in.h5 -fibre_segment_length " + std::to_string(length) +
            " -ts_dt 2 -ts_max_steps 100 -energy_monitor ascii:energy.csv -monitor_interval 100 "
            "-damping_viscous 0.001 -bc slide,hold -hold_region -1,-1,-1,1000,1,1 -hold_fix 1,1,1 "
            "-hold_fix_rotation -slide_region -1,39,-1,1000,41,1 -slide_velocity 0.001,0,0 "
            "-slide_fix_rotation");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    power[which++] = readCsv(folder / "energy.csv").at("damped").back();
  }
  EXPECT_GT(power[0], 0.0);
  // At 40 A the cutoff leaves +-36.6 A along: 7 places of 13.56 A with their points, or 13 of 6.78
  // A.
  EXPECT_NEAR(power[1] / power[0], 1.0, 0.15);
}

TEST(Units, SiAndNanoGiveTheSamePhysics) {
  constexpr double joule = 1.602176634e-19;
  for (const std::string preset : {"-weave_fibres 4,4 -weave_segments 24",
                                   "-weave_fibres 4,4 -weave_segments 40 "
                                   "-fibre_preset carbon_t300"}) {
    const Folder folder;
    for (const std::string units : {"nano", "si"}) {
      const auto outcome = run(folder, "-units " + units + " -scene weave " + preset +
                                           " -ts_max_steps 50 -monitor_interval 50 "
                                           "-progress_interval 0 -energy_monitor ascii:" +
                                           units + ".csv");
      ASSERT_EQ(outcome.status, 0) << outcome.output;
    }
    const auto nano = readCsv(folder / "nano.csv"), si = readCsv(folder / "si.csv");
    double size = 0;
    for (const char* part : {"stretch", "shear", "bending", "pair"})
      size = std::max(size, std::abs(nano.at(part)[0]));
    for (const char* part : {"stretch", "shear", "bending", "torsion", "pair", "total"})
      EXPECT_NEAR(si.at(part)[0] / joule, nano.at(part)[0], 1e-9 * size) << preset << part;
    // The default step too is the same, so is what it leads to.
    EXPECT_NEAR(si.at("time_s")[1] * 1e15 / nano.at("time_fs")[1], 1.0, 1e-6) << preset;
    EXPECT_NEAR(si.at("kinetic")[1] / joule / nano.at("kinetic")[1], 1.0, 1e-4) << preset;
  }
}

TEST(Units, TheSheetIsAsThickAsItsFibres) {
  // A bond stretched by 1 %: stress = E S strain/(width x thickness).
  auto stress = [](const std::string& options) {
    const Folder folder;
    const auto outcome =
        run(folder,
            "-scene fibre -fibre_segments 40 -fibre_strain 0.01 -pair none -tension_rate 1 "
            "-ts_max_steps 0 -stress_monitor ascii:stress.csv " +
                options);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return readCsv(folder / "stress.csv").at("virial_xx_GPa").front();
  };
  // The tube: 17.1 A, as the paper divides by; S = 142.714 A^2.
  EXPECT_NEAR(stress("-tension_width 20"), 1029 * 142.7136 * 0.01 / (20 * 17.1), 0.05);
  EXPECT_NEAR(stress("-units si -tension_width 20e-10"), 1029 * 142.7136 * 0.01 / (20 * 17.1),
              0.05);
  // A carbon fibre: 7 um; S = pi 3.5^2 um^2.
  EXPECT_NEAR(stress("-units si -fibre_preset carbon_t300 -tension_width 20e-6"),
              230 * std::numbers::pi * 3.5 * 3.5 * 0.01 / (20 * 7.0), 0.005);
}

TEST(Units, CrossedCarbonFibresPressAsHertzSays) {
  // Two long fibres crossed a tenth of a radius deep; by default 8 points on a segment.
  const Folder folder;
  const double micro = 1e4, rf = 3.5 * micro, distance = 1.9 * rf;
  FibreInput a, b;
  for (int k = -5; k <= 5; ++k) {
    a.position.push_back({k * 2 * rf, 0, 0});
    a.orientation.push_back({1, 0, 0, 0});
    b.position.push_back({0.2 * rf, k * 2 * rf + 0.3 * rf, distance});
    b.orientation.push_back({std::sqrt(0.5), 0, 0, std::sqrt(0.5)});
  }
  BoxInput box;
  box.lower = {-60 * rf, -60 * rf, -60 * rf}, box.upper = {60 * rf, 60 * rf, 60 * rf};
  writeState(folder / "in.h5", {a, b}, box);
  const auto outcome = run(folder,
                           "-fibre_preset carbon_t300 -scene file -scene_file in.h5 "
                           "-ts_max_steps 0 -state_output out.h5 "
                           "-state_forces");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto force = readDataset(folder / "out.h5", "/state/force");
  double up = 0;
  for (std::size_t k = 11; k < 22; ++k) up += force[3 * k + 2];
  const double gigapascal = 1.0 / 160.2176634,
               reduced = 15 * gigapascal / (2 * (1 - 0.07142857 * 0.07142857));
  const double hertz = 4.0 / 3.0 * reduced * std::sqrt(rf) * std::pow(0.1 * rf, 1.5);
  // 5 % for the distance below 2 rf, and a few more for the points.
  EXPECT_NEAR(up / hertz, 0.95, 0.06);
}

}  // namespace
}  // namespace nanoweft::test
