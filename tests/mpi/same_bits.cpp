/// The same run gives the same bytes for any number of ranks and threads.
#include <gtest/gtest.h>

#include <algorithm>

#include "nanoweft/base/floats.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

/// Files of a run that must not depend on how it was distributed.
void expectSameFiles(const std::string& options, const std::vector<std::string>& files,
                     const std::vector<std::pair<int, int>>& layouts) {
  const Folder reference;
  // Without -threads all, threads rest where there are fewer cores.
  const std::string all = options + " -threads all";
  auto outcome = run(reference, all, 1, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const auto& [ranks, threads] : layouts) {
    const Folder folder;
    outcome = run(folder, all, ranks, threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    for (const std::string& file : files)
      EXPECT_TRUE(readFile(folder / file) == readFile(reference / file))
          << file << " on " << ranks << " x " << threads;
  }
}

const std::string outputs =
    " -state_output out.h5 -state_forces -energy_monitor ascii:energy.csv -monitor_interval 50";
const std::string frames = " -snapshot_file frame -snapshot_interval 200";
const std::vector<std::pair<int, int>> allLayouts{{1, 2}, {2, 1}, {2, 2}, {4, 1}, {4, 2}};

TEST(SameBits, OpenWeave) {
  expectSameFiles(
      "-weave_fibres 6,6 -weave_segments 36 -damping_local 0.4 -scene_perturb 0.1 -ts_max_steps "
      "400" +
          outputs + frames,
      {"out.h5", "energy.csv", "frame.xdmf", "frame_0000000400.h5"}, allLayouts);
}

TEST(SameBits, PeriodicWeaveOnMoreRanks) {
  expectSameFiles(
      "-weave_fibres 6,6 -weave_segments 36 -weave_periodic -scene_perturb 0.2 -ts_max_steps 300 "
      "-pair_far_points 1" +
          outputs + frames,
      {"out.h5", "energy.csv", "frame_0000000200.h5"}, {{2, 1}, {3, 1}, {8, 1}});
}

TEST(SameBits, SinglePrecision) {
  if (!singlePays) {  // not offered without AVX-512
    const auto refused = run(Folder(), "-pair_precision single -ts_max_steps 1", 1);
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.output.find("AVX-512"), std::string::npos) << refused.output;
    return;
  }
  expectSameFiles(
      "-weave_fibres 6,6 -weave_segments 36 -weave_periodic -scene_perturb 0.2 -ts_max_steps 300 "
      "-pair_far_points 1 -pair_precision single" +
          outputs,
      {"out.h5", "energy.csv"}, {{1, 2}, {2, 1}, {4, 1}});
}

/// Ends on one side that suddenly move by an angstrom a step: pairs are missing that no rank has
/// foreseen, some ranks have computed theirs by then, and bonds break in what is computed again.
TEST(SameBits, SegmentsFasterThanForeseen) {
  const std::string options =
      "-weave_fibres 6,6 -weave_segments 36 -ts_dt 15 -ts_max_steps 40 -bc pull -pull_region "
      "400,-1000,-1000,1000,1000,1000 -pull_velocity 0.07,0.02,0 -break_strain_mean 0.3 "
      "-break_strain_std 0.1 -monitor_interval 20 -state_output out.h5 -state_forces "
      "-energy_monitor ascii:energy.csv";
  expectSameFiles(options + " -agreement late", {"out.h5", "energy.csv"}, {{2, 1}, {2, 2}, {4, 1}});
  const auto logged = run(Folder(), options + " -agreement late -log_view", 2);
  EXPECT_NE(logged.output.find("NwRepeat"), std::string::npos) << logged.output;
}

/// A pair missing from a list, or looked at too late, would show. Fibres that meet end to
/// end feel each other as soon as their segments are in reach.
TEST(SameBits, WhateverTheSkin) {
  const Folder scene;
  writeState(scene / "in.h5", {straightFibre({-209.16, 0, 0}, {1, 0, 0}, 12),
                               straightFibre({60, 0, 0}, {1, 0, 0}, 12)});
  setMotion(
      scene / "in.h5",
      [](std::size_t row, const Vec3d&) {
        return Vec3d{row < 12 ? 0.005 : -0.005, 0, 0};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const std::string weave =
                        "-weave_fibres 6,6 -weave_segments 48 -scene_perturb 0.3 -ts_max_steps "
                        "800",
                    meeting = "-scene file -scene_file " + scene / "in.h5" + " -ts_max_steps 1000";
  for (const std::string& options : {weave, meeting}) {
    const Folder reference;
    auto outcome = run(reference, options + outputs + " -pair_skin 0.7", 1, 1);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto pair = readCsv(reference / "energy.csv").at("pair");
    EXPECT_NE(*std::ranges::min_element(pair), 0) << "nothing has met";
    const std::pair<const char*, int> others[] = {{"", 1},
                                                  {" -pair_skin 0.4", 3},
                                                  {" -pair_skin 2", 1},
                                                  {" -pair_skin 6", 3},
                                                  {" -pair_skin 20", 3}};
    for (const auto& [skin, ranks] : others) {
      const Folder folder;
      outcome = run(folder, options + outputs + skin, ranks, 2);
      ASSERT_EQ(outcome.status, 0) << outcome.output;
      for (const char* file : {"out.h5", "energy.csv"})
        EXPECT_TRUE(readFile(folder / file) == readFile(reference / file))
            << options << skin << ": " << file << " on " << ranks << " ranks";
    }
  }
}

TEST(SameBits, ASkinThinnerThanWhatSegmentsMoveInAStep) {
  // Two fibres end on, whose last points meet within the first steps.
  const Folder scene;
  writeState(scene / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 12),
                               straightFibre({11 * 13.56 + 24.52, 0, 0}, {1, 0, 0}, 12)});
  setMotion(
      scene / "in.h5",
      [](std::size_t row, const Vec3d&) {
        return Vec3d{row < 12 ? 0.005 : -0.005, 0, 0};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const std::string options = "-scene file -scene_file " + scene / "in.h5" +
                              " -pair hertz -pair_points 5 -ts_dt 20 -ts_max_steps 20 "
                              "-monitor_interval 1 -energy_monitor ascii:energy.csv -pair_skin ";
  const Folder wide, thin;
  auto outcome = run(wide, options + "2", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(thin, options + "0.1", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto pair = readCsv(wide / "energy.csv").at("pair");
  EXPECT_EQ(pair[0], 0);
  EXPECT_GT(pair[3], 0);
  EXPECT_TRUE(readFile(wide / "energy.csv") == readFile(thin / "energy.csv"));
}

TEST(SameBits, SegmentsThatTurnTowardsEachOtherMeetInTime) {
  // Their centres hardly move. A restart draws its pairs anew, when the ends are near already.
  const Folder scene;
  writeState(scene / "in.h5",
             {straightFibre({0, 0, 0}, {0, 1, 0}, 1), straightFibre({34, 0, 0}, {0, 1, 0}, 1)});
  setMotion(
      scene / "in.h5", [](std::size_t, const Vec3d&) { return Vec3d{}; },
      [](std::size_t, const Vec3d&) {
        return Vec3d{0, 0, 4e-4};
      });
  const std::string options = "-scene file -scene_file " + scene / "in.h5" + outputs +
                              " -ts_dt 20 -checkpoint_file c.h5 -ts_max_steps ";
  const Folder whole, pieces;
  auto outcome = run(whole, options + "400", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, options + "150", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, options + "400 -restart c.h5", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(pieces / "out.h5") == readFile(whole / "out.h5"));
}

TEST(SameBits, TensionWithBreakage) {
  expectSameFiles(
      "-weave_fibres 4,4 -weave_segments 32 -damping_local 0.4 -tension_rate 2e-5 -tension_ramp "
      "2000 -tension_grip 40 "
      "-tension_max_strain 0.45 -break_strain_mean 0.12 -break_strain_std 0.03 -ts_dt 15 "
      "-stress_monitor ascii:stress.csv" +
          outputs + frames,
      {"out.h5", "energy.csv", "stress.csv", "frame_0000000200.h5", "frame_0000001400.h5"},
      {{1, 2}, {2, 1}, {4, 1}});
}

TEST(SameBits, GroupsThatTurnAndTheirTable) {
  expectSameFiles(
      "-weave_fibres 4,4 -weave_segments 24 -ts_max_steps 150 -bc left,right -left_region "
      "-1000,-1000,-1000,10,1000,1000 -left_fix 0,1,1 -left_force -0.02,0,0 -right_region "
      "180,-1000,-1000,1000,1000,1000 -right_spin 1e-5 -right_axis 1,0,0 -right_centre 0,100,0 "
      "-right_ramp 2000 -group_monitor ascii:groups.csv" +
          outputs,
      {"out.h5", "energy.csv", "groups.csv"}, {{1, 2}, {2, 2}, {4, 1}});
}

TEST(SameBits, ViscousDamping) {
  expectSameFiles(
      "-weave_fibres 4,4 -weave_segments 24 -damping_viscous 20 -damping_viscous_angular 500 "
      "-ts_max_steps 200" +
          outputs,
      {"out.h5", "energy.csv"}, {{2, 1}, {4, 1}});
}

TEST(SameBits, LawsThatAdd) {
  expectSameFiles(
      "-weave_fibres 4,4 -weave_segments 24 -pair vdw,hertz,capillary -capillary_tension 0.0045 "
      "-capillary_volume 400 -damping_viscous 20 -scene_perturb 0.2 -ts_max_steps 100" +
          outputs,
      {"out.h5", "energy.csv"}, {{1, 2}, {3, 1}});
}

TEST(SameBits, Fire) {
  // With loads, held components, a step that follows the stable limit, and an end by force.
  expectSameFiles(
      "-weave_fibres 4,4 -weave_segments 24 -scene_perturb 0.1 -relax_method fire -relax_force 1 "
      "-ts_limit_interval 50 -ts_max_steps 5000 -bc edge,pull -edge_region "
      "-1000,-1000,-1000,10,1000,1000 -edge_fix 1,0,1 -edge_fix_rotation -pull_region "
      "180,-1000,-1000,1000,1000,1000 -pull_force 0.05,0,0 -pull_torque 0,0,0.01" +
          outputs,
      {"out.h5", "energy.csv"}, allLayouts);
}

TEST(SameBits, FireOnAPeriodicWeave) {
  expectSameFiles(
      "-weave_fibres 6,6 -weave_segments 36 -weave_periodic -scene_perturb 0.2 -relax_method fire "
      "-ts_max_steps 300" +
          outputs,
      {"out.h5", "energy.csv"}, {{2, 1}, {3, 1}, {8, 1}});
}

TEST(SameBits, StepChosenByTheStableLimit) {
  // In si units; the limit is an iteration over sums of all ranks.
  expectSameFiles(
      "-units si -scene fibre -fibre_preset carbon_t300 -fibre_segments 60 -fibre_bend 1 "
      "-fibre_strain 0.01 -pair none -ts_max_steps 300" +
          outputs,
      {"out.h5", "energy.csv"}, {{3, 1}, {4, 1}});
}

TEST(SameBits, FibresWithoutPairForces) {
  expectSameFiles(
      "-scene fibre -fibre_segments 40 -fibre_bend 2 -fibre_twist 1 -pair none -ts_max_steps 500" +
          outputs,
      {"out.h5", "energy.csv"}, {{2, 1}, {4, 2}});
}

TEST(SameBits, RanksMayBeEmpty) {
  // Two segments on four ranks.
  expectSameFiles("-scene fibre -fibre_segments 2 -fibre_strain 0.01 -ts_max_steps 100" + outputs,
                  {"out.h5", "energy.csv"}, {{4, 1}});
}

TEST(SameBits, AnyImageOfAPositionIsAccepted) {
  // A state given outside the periodic box is the same state.
  const Folder folder;
  BoxInput box;
  box.lower = {0, 0, -300}, box.upper = {400, 400, 300}, box.periodic = {true, true, false};
  writeState(
      folder / "in.h5",
      {straightFibre({390, 10, 0}, {1, 0, 0}, 8), straightFibre({20, 380, 18}, {0, 1, 0}, 8)}, box);
  writeState(
      folder / "moved.h5",
      {straightFibre({790, 10, 0}, {1, 0, 0}, 8), straightFibre({20, -20, 18}, {0, 1, 0}, 8)}, box);
  for (const char* name : {"in", "moved"}) {
    const auto outcome = run(folder,
                             std::string("-scene file -scene_file ") + name +
                                 ".h5 -ts_max_steps 0 -energy_monitor ascii:" + name + ".csv",
                             2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
  }
  const auto a = readCsv(folder / "in.csv"), b = readCsv(folder / "moved.csv");
  EXPECT_LT(a.at("pair").front(), -1.0);  // they cross through the corner of the box
  EXPECT_NEAR(a.at("pair").front(), b.at("pair").front(), 1e-9);
  EXPECT_LT(a.at("stretch").front() + a.at("shear").front(), 1e-9);
}

}  // namespace
}  // namespace nanoweft::test
