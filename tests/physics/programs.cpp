/// Tension tests that turn round: loading and unloading, compression, stages, the lateral strain
/// (model.md 16).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using Table = std::map<std::string, std::vector<double>>;

const std::string tubeOf20 =
    "-scene fibre -fibre_segments 20 -pair none -progress_interval 0 -tension_grip 14 "
    "-tension_width 20 -tension_thickness 10 -ts_dt 15 -monitor_interval 50 -stress_monitor "
    "ascii:s.csv -energy_monitor ascii:e.csv ";
// Two segments are held at each end, so 17 bonds stretch by what a gage of 19 T - 28 does.
const double bondPerGage = (19 * tube::length - 28) / (17 * tube::length);

double stressAt(const Table& s, std::size_t k) {
  return 0.5 * (s.at("stress_left_GPa")[k] + s.at("stress_right_GPa")[k]);
}

/// The table's row where the strain is largest.
std::size_t turn(const Table& s) {
  const auto& strain = s.at("strain");
  return static_cast<std::size_t>(std::ranges::max_element(strain) - strain.begin());
}

TEST(TensionProgram, ALoopOfAnElasticTubeCloses) {
  const Folder folder;
  const auto outcome = run(folder, tubeOf20 + "-tension_program 0.01,5e-7,-0.01,5e-7,0,5e-7");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Table s = readCsv(folder / "s.csv"), e = readCsv(folder / "e.csv");
  EXPECT_EQ(s.at("strain").back(), 0);
  EXPECT_NEAR(*std::ranges::max_element(s.at("strain")), 0.01, 1e-6);
  EXPECT_NEAR(*std::ranges::min_element(s.at("strain")), -0.01, 1e-6);
  // The same line up and down, through tension and compression.
  const double modulus = tube::ES / (20 * 10) * bondPerGage / tube::gigapascal;
  for (std::size_t k = 0; k < s.at("step").size(); ++k)
    EXPECT_NEAR(stressAt(s, k), modulus * s.at("strain")[k], 0.005 * modulus * 0.01) << k;
  // The grips bring in what the tube holds, and take it out again.
  const double most = *std::ranges::max_element(e.at("external"));
  EXPECT_GT(most, 0.9 * 0.5 * 17 * tube::B1 * std::pow(0.01 * bondPerGage * tube::length, 2));
  EXPECT_LT(std::abs(e.at("external").back()), 1e-3 * most);
  EXPECT_NEAR(e.at("external").back(), e.at("total").back(), 1e-5 * most);
}

TEST(TensionProgram, AFibreThatYieldsKeepsTheStrainBeyondIt) {
  const Folder folder;
  const auto outcome = run(folder, tubeOf20 +
                                       "-fibre_yield_strain 0.005 -tension_program "
                                       "0.02,5e-7,0.013,5e-7");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Table s = readCsv(folder / "s.csv"), e = readCsv(folder / "e.csv");
  std::size_t k = turn(s);
  while (k + 1 < s.at("step").size() && stressAt(s, k) > 0) ++k;
  const double above = stressAt(s, k - 1), below = stressAt(s, k);
  ASSERT_LE(below, 0);
  const double residual =
      (above * s.at("strain")[k] - below * s.at("strain")[k - 1]) / (above - below) * bondPerGage;
  EXPECT_NEAR(residual, 0.02 * bondPerGage - 0.005, 2e-4);
  EXPECT_GT(e.at("external").back(), 0.9 * e.at("damped").back());
}

TEST(TensionProgram, TheLateralStrainOfAnArchFallsInTensionAndRisesInCompression) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 24 -fibre_shape rest -fibre_rest_curvature 0.0096,0 -pair "
          "none -progress_interval 0 -tension_axis z -tension_grip 14 -tension_width 20 "
          "-tension_thickness 10 -ts_dt 15 -monitor_interval 50 -tension_program "
          "0.05,1e-6,-0.05,1e-6 -tension_lateral -stress_monitor ascii:s.csv");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Table s = readCsv(folder / "s.csv");
  const auto& lateral = s.at("lateral_strain");
  EXPECT_EQ(lateral.front(), 0);
  EXPECT_NEAR(lateral[turn(s)], -0.17, 0.02);
  EXPECT_NEAR(lateral.back(), 0.15, 0.02);
}

TEST(TensionProgram, AStageWithARateBelowZeroUnloads) {
  const Folder folder;
  auto outcome = run(folder, tubeOf20 +
                                 "-tension_rate 5e-7 -tension_ramp 5000 -tension_max_strain 0.004 "
                                 "-state_output one.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const double reached = readCsv(folder / "s.csv").at("strain").back();
  const std::string stage =
      "-scene file -scene_file one.h5 -pair none -progress_interval 0 -ts_dt 15 -monitor_interval "
      "50 -stress_monitor ascii:t.csv -overwrite ";
  outcome = run(folder, stage + "-tension_rate -5e-7 -tension_ramp 5000 -tension_max_strain 0");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Table back = readCsv(folder / "t.csv");
  EXPECT_EQ(back.at("strain").front(), reached);
  EXPECT_NEAR(back.at("strain").back(), 0, 1e-5);
  EXPECT_LE(back.at("strain").back(), 0);
  // A program goes on from there as well.
  outcome = run(folder, stage + "-tension_program 0.002,5e-7");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(readCsv(folder / "t.csv").at("strain").front(), reached);
  EXPECT_EQ(readCsv(folder / "t.csv").at("strain").back(), 0.002);
  // What was not measured at the start of the test cannot be told later.
  expectRefused(run(folder, stage + "-tension_program 0.002,5e-7 -tension_lateral"),
                {"-tension_lateral", "one.h5", "-tension_new"});
}

TEST(Tension, SaysWhichFibresTheGripsHold) {
  const auto at = [](double y, double x, int segments) {
    return straightFibre({x * tube::length, y, 0}, {1, 0, 0}, segments);
  };
  const Folder folder;
  writeState(folder / "in.h5", {at(0, 0, 40), at(40, 0, 40), at(80, 0, 20), at(120, 0, 39),
                                at(160, 0, 35), at(200, 20, 20), at(240, 10, 20)});
  for (const int ranks : {1, 3}) {
    const auto outcome = run(folder,
                             "-scene file -scene_file in.h5 -pair none -tension_rate 1e-7 "
                             "-tension_grip 50 -ts_dt 15 -ts_max_steps 1",
                             ranks);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(
        outcome.output.find("grips hold fibres: 3 both, 2 the left one only, 1 the right one\n"),
        std::string::npos)
        << outcome.output;
  }
}

TEST(Tension, HoldsTheSameSegmentsInAllUnitsWhereAGripEndsAtOne) {
  // The default grips are five segments long. Twenty bonds are free, which the gage is long.
  const struct {
    const char *preset, *radius, *rate;
    double young;
  } fibres[] = {{"carbon_t300", "3.5e-6", "5e4", 230}, {"nylon_ef", "3e-7", "8e4", 2.8}};
  for (const auto& f : fibres) {
    const Folder folder;
    const double side = 2 * std::atof(f.radius);
    char section[80];
    std::snprintf(section, sizeof section, "-tension_width %g -tension_thickness %g", side, side);
    const auto outcome =
        run(folder, std::string("-units si -scene fibre -fibre_segments 31 -progress_interval 0 "
                                "-fibre_preset ") +
                        f.preset + " -tension_program 0.002," + f.rate +
                        " -stress_monitor ascii:s.csv " + section);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("innermost segments"), std::string::npos) << outcome.output;
    const auto table = readCsv(folder / "s.csv");
    const double stress =
        0.5 * (table.at("stress_left_GPa").back() + table.at("stress_right_GPa").back());
    EXPECT_NEAR(stress / table.at("strain").back() / (f.young * std::numbers::pi / 4), 1.0, 0.01)
        << f.preset;
  }
}

const std::string twoKinds =
    "-scene file -scene_file in.h5 -kinds a,b -a_fibre_segment_length 10 -b_fibre_segment_length "
    "20 -pair none -tension_rate 1e-7 -tension_width 10 -tension_thickness 10 -tension_grip 40 "
    "-ts_dt 5 -ts_max_steps 1";

TEST(Tension, WarnsOfTheKindThatItsGageFitsWorst) {
  // Grips of 40 A end at segments of 10 A of one kind, and between those of 20 A of the other one,
  // whose innermost held segments are 340 A from each other, not 310.
  const Folder folder;
  std::vector<double> kind;
  std::vector<FibreInput> fibres(2);
  for (const int k : {0, 1}) {
    const double length = 10 * (k + 1);
    const int segments = 40 / (k + 1);
    for (int n = 0; n < segments; ++n) {
      fibres[static_cast<std::size_t>(k)].position.push_back({(n + 0.5) * length, 100.0 * k, 0});
      fibres[static_cast<std::size_t>(k)].orientation.push_back({1, 0, 0, 0});
      kind.push_back(k);
    }
  }
  writeState(folder / "in.h5", fibres);
  setDataset(folder / "in.h5", "kind", kind, 1);
  for (const int ranks : {1, 2}) {
    const auto outcome = run(folder, twoKinds, ranks);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("340 A from each other in one kind"), std::string::npos)
        << outcome.output;
  }
}

TEST(Tension, FibresAcrossThePullDoNotSayHowItsGageFits) {
  // Grips of 40 A end at segments of the fibre that both hold; one of another kind lies across in
  // either grip, 360 A apart.
  const Folder folder;
  std::vector<double> kind;
  std::vector<FibreInput> fibres(3);
  for (int n = 0; n < 40; ++n) {
    fibres[0].position.push_back({(n + 0.5) * 10, 0, 0});
    fibres[0].orientation.push_back({1, 0, 0, 0});
    kind.push_back(0);
  }
  for (const std::size_t k : {1u, 2u})
    for (int n = 0; n < 4; ++n) {
      fibres[k].position.push_back({k == 1 ? 20.0 : 380.0, 20.0 * n, 50});
      fibres[k].orientation.push_back({std::sqrt(0.5), 0, 0, std::sqrt(0.5)});
      kind.push_back(1);
    }
  writeState(folder / "in.h5", fibres);
  setDataset(folder / "in.h5", "kind", kind, 1);
  for (const int ranks : {1, 3}) {
    const auto outcome = run(folder, twoKinds, ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("360 A from each other"), std::string::npos) << outcome.output;
  }
}

TEST(Tension, WarnsWhereGripsEndBetweenSegmentsOfAShortGage) {
  const Folder folder;
  const auto outcome = run(folder,
                           "-scene fibre -fibre_segments 21 -pair none -tension_rate 1e-7 "
                           "-tension_width 10 -tension_grip 60 -ts_dt 15 -ts_max_steps 1",
                           2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // Four segments further apart at each end: (271.2 - 2 x 54.24)/(271.2 - 2 x 60).
  EXPECT_NE(outcome.output.find("hold are 162.72 A from each other"), std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("it is 7.6 % too large"), std::string::npos) << outcome.output;
}

TEST(TensionPrograms, SayWhichLegsAreTooShortForTheirRate) {
  const Folder folder;
  const auto outcome = run(folder,
                           "-scene fibre -fibre_segments 31 -pair none -tension_width 10 "
                           "-tension_program 0.005,1e-6,-0.01,1e-6 -ts_max_steps 1");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // Ramps of 0.01 of strain: sqrt(0.005/0.01) of the rate is reached in the first leg.
  EXPECT_NE(outcome.output.find("0.005 at 1e-06 (7.07e-07 at most"), std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("then -0.01 at 1e-06 1/fs"), std::string::npos) << outcome.output;
}

TEST(TensionRamps, EndWithinAStepWithTheStrainThatTheGripsHave) {
  for (const double ramp : {10.0, 150.0, 200.0}) {
    const Folder folder;
    const auto outcome =
        run(folder,
            "-scene weave -weave_fibres 4,4 -weave_segments 16 -tension_rate 2e-5 -tension_grip "
            "20 -ts_dt 20 -ts_max_steps 20 -tension_thickness 10 -monitor_interval 1 "
            "-stress_monitor ascii:s.csv -state_output out.h5 -snapshot_file snap "
            "-snapshot_interval 20 -tension_ramp " +
                std::to_string(ramp));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    auto wide = [](const std::string& file) {
      double low = 1e9, high = -1e9;
      for (const Vec3d& x : readVectors(file, "/state/position"))
        low = std::min(low, x.x), high = std::max(high, x.x);
      return high - low;
    };
    const double before = wide(folder / "snap_0000000000.h5"), after = wide(folder / "out.h5"),
                 gage = before - 40;
    EXPECT_NEAR((after - before) / gage, readCsv(folder / "s.csv").at("strain").back(), 1e-12)
        << ramp;
  }
}

}  // namespace
}  // namespace nanoweft::test
