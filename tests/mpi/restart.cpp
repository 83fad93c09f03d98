/// A restart goes on bit for bit, on any number of ranks, also after a signal.
#include <gtest/gtest.h>

#include "support/program.hpp"

namespace nanoweft::test {
namespace {

/// Runs to the end at once, and in two pieces with other numbers of ranks; all files must agree.
void expectSameInPieces(const std::string& options, const std::string& half,
                        const std::vector<std::string>& files) {
  const Folder whole, pieces;
  auto outcome = run(whole, options + " -state_output out.h5", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, options + " " + half + " -checkpoint_file c.h5", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, options + " -restart c.h5 -state_output out.h5", 3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const std::string& file : files)
    EXPECT_TRUE(readFile(pieces / file) == readFile(whole / file)) << file;
}

const std::string energy = " -energy_monitor ascii:energy.csv -monitor_interval 50";

TEST(Restart, RelaxingWeave) {
  expectSameInPieces(
      "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -ts_max_steps 600" + energy,
      "-ts_max_steps 300", {"out.h5", "energy.csv"});
}

TEST(Restart, TensionWithBreakage) {
  expectSameInPieces(
      "-weave_fibres 4,4 -weave_segments 32 -damping_local 0.4 -tension_rate 2e-5 -tension_ramp "
      "2000 -tension_grip 40 "
      "-break_strain_mean 0.12 -break_strain_std 0.03 -ts_dt 15 -tension_max_strain 0.45 "
      "-stress_monitor ascii:stress.csv" +
          energy,
      "-tension_max_strain 0.21", {"out.h5", "energy.csv", "stress.csv"});
}

TEST(Restart, ViscousDampingAndNamedBoundaries) {
  expectSameInPieces(
      "-weave_fibres 4,4 -weave_segments 24 -damping_viscous 20 -ts_max_steps 400 -bc edge,pull "
      "-edge_region -1000,-1000,-1000,10,1000,1000 -edge_fix 1,0,1 -pull_region "
      "180,-1000,-1000,1000,1000,1000 "
      "-pull_force 0.05,0,0 -pull_ramp 4000" +
          energy,
      "-ts_max_steps 150", {"out.h5", "energy.csv"});
}

TEST(Restart, GroupsThatTurnAndTheirTable) {
  for (const char* half : {"-ts_max_steps 75", "-ts_max_steps 150"})
    expectSameInPieces(
        "-weave_fibres 4,4 -weave_segments 24 -damping_viscous 20 -ts_max_steps 250 -bc left,right "
        "-left_region -1000,-1000,-1000,10,1000,1000 -left_fix 0,1,1 -left_force -0.02,0,0 "
        "-right_region 180,-1000,-1000,1000,1000,1000 -right_spin 1e-5 -right_axis 1,0,0 "
        "-right_centre 0,100,0 -right_velocity 1e-4,0,0 -right_ramp 2000 -group_monitor "
        "ascii:groups.csv" +
            energy,
        half, {"out.h5", "energy.csv", "groups.csv"});
}

TEST(Restart, TheMiddleOfATensionProgram) {
  // In a leg, and in the ramp between two.
  for (const char* half : {"-ts_max_steps 100", "-ts_max_steps 205"})
    expectSameInPieces(
        "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -tension_program "
        "0.03,1e-5,0.01,1e-5 -tension_ramp 600 -tension_grip 40 -tension_lateral -ts_dt 15 "
        "-stress_monitor ascii:stress.csv" +
            energy,
        half, {"out.h5", "energy.csv", "stress.csv"});
}

TEST(Restart, ConvergenceIsRemembered) {
  expectSameInPieces(
      "-weave_fibres 2,2 -weave_segments 16 -damping_local 0.7 -relax_tolerance 0.05 "
      "-relax_interval 300 -ts_max_steps 20000" +
          energy,
      "-ts_max_steps 450", {"out.h5"});
}

TEST(Restart, Fire) {
  // Step, mixing and the count of steps downhill go on; the first checkpoint lies on a step at
  // which the stable limit is looked at.
  for (const char* half : {"-ts_max_steps 100", "-ts_max_steps 133"})
    expectSameInPieces(
        "-weave_fibres 4,4 -weave_segments 24 -relax_method fire -relax_force 0.5 "
        "-ts_limit_interval 50 -ts_max_steps 5000 -bc edge,pull -edge_region "
        "-1000,-1000,-1000,10,1000,1000 -edge_fix 1,0,1 -pull_region "
        "180,-1000,-1000,1000,1000,1000 -pull_force 0.05,0,0 -pull_ramp 4000" +
            energy,
        half, {"out.h5", "energy.csv"});
}

TEST(Restart, StepChosenByTheStableLimit) {
  expectSameInPieces(
      "-units si -scene fibre -fibre_preset carbon_t300 -fibre_segments 60 -fibre_bend 1 "
      "-fibre_strain 0.01 -pair none -ts_max_steps 600" +
          energy,
      "-ts_max_steps 250", {"out.h5", "energy.csv"});
}

TEST(Restart, SignalsWriteACheckpointAndEndWithThree) {
  const std::string options =
      "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -ts_max_steps 60000 "
      "-checkpoint_file "
      "c.h5 "
      "-checkpoint_interval 100000 -progress_interval 0.05" +
      energy;
  const Folder whole, pieces;
  auto outcome = run(whole, options + " -state_output out.h5", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // Wait for the first progress line, then ask mpirun, which passes SIGUSR1 on.
  const std::string wait =
      "for i in $(seq 1200); do grep -q ns/day out.txt && break; sleep 0.05; done; ";
  outcome = runBeside(pieces, options + " -state_output out.h5", 2, wait + "kill -USR1 $PID");
  ASSERT_EQ(outcome.status, 3) << outcome.output;
  EXPECT_NE(outcome.output.find("-restart c.h5"), std::string::npos) << outcome.output;
  EXPECT_FALSE(std::filesystem::exists(pieces / "out.h5"));
  // SIGTERM straight to one of the ranks.
  outcome = runBeside(pieces, options + " -restart c.h5 -state_output out.h5", 2,
                      wait + "kill -TERM $(pgrep -P $PID | head -1)");
  ASSERT_EQ(outcome.status, 3) << outcome.output;
  outcome = run(pieces, options + " -restart c.h5 -state_output out.h5", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(pieces / "out.h5") == readFile(whole / "out.h5"));
  EXPECT_TRUE(readFile(pieces / "energy.csv") == readFile(whole / "energy.csv"));
}

}  // namespace
}  // namespace nanoweft::test
