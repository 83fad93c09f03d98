/// Fibres that are at rest in another shape than straight (model.md 10).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

// Rigidities of the (10,10) tube, by hand.
constexpr double gigapascal = 6.241509074e-3, pi = std::numbers::pi;
constexpr double rf = 6.78, wall = 3.35, tubeLength = 13.56;
constexpr double moment = pi * wall * rf * (rf * rf + wall * wall / 4);
constexpr double EJ = 1029 * gigapascal * moment, GJp = 459 * gigapascal * 2 * moment;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

/// Helix of radius R around z whose pitch is 2 pi p, cut into `segments` of a length `T`.
struct Helix {
  double R, p, T;
  int segments;

  std::string options() const {
    const double square = R * R + p * p, slope = p / R;
    return "-scene fibre -fibre_shape rest -fibre_segments " + std::to_string(segments) +
           " -fibre_segment_length " + number(T) + " -fibre_rest_curvature 0," +
           number(R / square) + " -fibre_rest_twist " + number(p / square) +
           " -fibre_direction 1,0," + number(slope) + " -pair none -progress_interval 0 ";
  }
};

/// Extension over force of a spring of whole turns, its ends kept from turning.
double compliance(const Helix& helix) {
  const Folder folder;
  auto outcome = run(folder, helix.options() + "-ts_max_steps 0 -state_output in.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto before = readVectors(folder / "in.h5", "/state/position");
  auto around = [](const Vec3d& x) {
    return number(x.x - 1) + "," + number(x.y - 1) + "," + number(x.z - 1) + "," + number(x.x + 1) +
           "," + number(x.y + 1) + "," + number(x.z + 1);
  };
  const double force = 1e-4;
  outcome = run(folder, helix.options() +
                            "-relax_method fire -relax_force 1e-9 -ts_max_steps 2000000 -bc a,b "
                            "-a_region " +
                            around(before.front()) + " -a_fix 1,1,1 -a_fix_rotation -b_region " +
                            around(before.back()) + " -b_fix 1,1,0 -b_fix_rotation -b_force 0,0," +
                            number(force) + " -state_output out.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return (readVectors(folder / "out.h5", "/state/position").back().z - before.back().z) / force;
}

TEST(RestShape, AHelicalSpringHasTheStiffnessOfItsWireInTorsion) {
  // Five turns of 48 or 96 segments; the angle of the pitch is 3.6 degrees.
  const double R = 100, p = 6.4, turns = 5, angle = std::atan(p / R);
  const double wire = 2 * pi * std::hypot(R, p);
  const double exact = turns * 2 * pi * R * R * R / std::cos(angle) *
                       (std::pow(std::cos(angle), 2) / GJp + std::pow(std::sin(angle), 2) / EJ);
  double error[2];
  for (int k = 0; k < 2; ++k) {
    const int segments = 48 << k;
    error[k] =
        compliance({R, p, wire / segments, static_cast<int>(turns) * segments + 1}) / exact - 1;
  }
  EXPECT_LT(std::abs(error[0]), 0.02);
  EXPECT_LT(std::abs(error[1]), 0.01);
}

TEST(RestShape, AHelixLaidAtRestStaysAtRest) {
  const Folder folder;
  const auto outcome = run(folder, Helix{60, 20, tubeLength, 100}.options() +
                                       "-ts_max_steps 500 -energy_monitor ascii:e.csv "
                                       "-monitor_interval 100 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto energies = readCsv(folder / "e.csv");
  for (const double e : energies.at("total")) EXPECT_LT(e, 1e-18);
  // It winds around an axis along z, its radius that of the smooth curve within the chord's error.
  const auto x = readVectors(folder / "out.h5", "/state/position");
  EXPECT_NEAR(x[99].z, 99 * tubeLength * 20 / std::hypot(60, 20), 3.0);
}

/// A ring of 40 segments, cut open at its last bond and let go with damping; the distance of the
/// ends in segment lengths.
double gapOfCutRing(const std::string& rest) {
  const Folder folder;
  const std::string ring = "-fibre_segments 40 -fibre_closed -pair none -progress_interval 0 ";
  auto outcome = run(folder, "-scene fibre -fibre_bend 6.283185307179586 " + ring + rest +
                                 "-start_unchecked -ts_max_steps 0 -state_output in.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  std::vector<double> broken(40, 0.0);
  broken[39] = 1;
  setDataset(folder / "in.h5", "bond_broken", broken, 1);
  outcome = run(folder,
                "-scene file -scene_file in.h5 -scene_file_edited -pair none "
                "-progress_interval 0 -start_unchecked -damping_local 0.3 -ts_max_steps 60000 "
                "-state_output out.h5 " +
                    rest);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto x = readVectors(folder / "out.h5", "/state/position");
  return norm(x[39] - x[0]) / tubeLength;
}

TEST(RestShape, ACutRingOpensWhenItsFibreIsStraightAtRestAndStaysWhenItIsARing) {
  EXPECT_NEAR(gapOfCutRing(""), 39, 0.1);
  const double curvature = 2 * pi / 40 / tubeLength;
  EXPECT_NEAR(gapOfCutRing("-fibre_rest_curvature 0," + number(curvature) + " "), 1.0, 1e-3);
}

TEST(RestShape, AWovenShapeAtRestHasNoBendingAndKeepsItsCrimp) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-weave_fibres 4,4 -weave_segments 24 -weave_rest shaped -ts_max_steps 0 -energy_monitor "
          "ascii:e.csv");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto energies = readCsv(folder / "e.csv");
  EXPECT_LT(energies.at("bending")[0], 1e-15);
  EXPECT_LT(energies.at("torsion")[0], 1e-15);
}

TEST(RestShape, TowsWovenAtRestHaveNoEnergyInTheirBonds) {
  struct {
    const char* options;
    double stretch;
  } const cases[] = {{"-weave_filaments 4,1", 1e-12},
                     {"-weave_filaments 4,2", 1e-12},
                     {"-weave_pattern twill", 1e-12},
                     // Chords of a periodic tow are what is left of its period: of 2304 bonds,
                     // strained by less than 1e-4.
                     {"-weave_filaments 4,1 -weave_periodic", 0.14}};
  for (const auto& [options, stretch] : cases) {
    const Folder folder;
    const auto outcome = run(folder, std::string("-weave_fibres 4,4 -weave_segments 72 -pair none "
                                                 "-weave_rest shaped -ts_max_steps 0 "
                                                 "-energy_monitor ascii:e.csv ") +
                                         options);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto energies = readCsv(folder / "e.csv");
    EXPECT_LT(energies.at("stretch")[0], stretch) << options;
    for (const char* part : {"shear", "bending", "torsion"})
      EXPECT_LT(energies.at(part)[0], 1e-12) << part << " " << options;
  }
}

}  // namespace
}  // namespace nanoweft::test
