/// A thermostat draws the same on any ranks, threads and partitions, and over restarts.
#include <gtest/gtest.h>

#include "support/expect.hpp"
#include "support/program.hpp"

namespace nanoweft::test {
namespace {

const std::string options =
    "-weave_fibres 4,4 -weave_segments 24 -temperature 300 -temperature_damping 1e-3 "
    "-temperature_start -bc edge,push -edge_region -1000,-1000,-1000,10,1000,1000 -edge_fix 1,0,1 "
    "-push_region 180,-1000,-1000,1000,1000,1000 -push_force 0.05,0,0 -progress_interval 0 "
    "-energy_monitor ascii:energy.csv -monitor_interval 50 -state_output out.h5 -state_forces "
    "-snapshot_file s -snapshot_interval 150 ";
const std::vector<std::string> files{"out.h5", "energy.csv", "s_0000000300.h5"};

void expectSame(const Folder& one, const Folder& other, const std::string& what) {
  for (const std::string& file : files)
    EXPECT_TRUE(readFile(one / file) == readFile(other / file)) << file << ": " << what;
}

TEST(ThermostatOnRanks, GivesTheSameBytesOnAnyRanksThreadsAndPartitions) {
  const Folder reference;
  expectDone(run(reference, options + "-ts_max_steps 300"));
  const struct {
    int ranks, threads;
    const char* partition;
  } layouts[] = {
      {1, 2, "auto"}, {2, 1, "dmda"}, {2, 2, "metis"}, {3, 2, "metis -partition_piece 5"}};
  for (const auto& l : layouts) {
    const Folder folder;
    expectDone(
        run(folder, options + "-ts_max_steps 300 -partition " + l.partition, l.ranks, l.threads));
    expectSame(folder, reference, l.partition);
  }
  const Folder other;
  expectDone(run(other, options + "-ts_max_steps 300 -seed 2"));
  EXPECT_FALSE(readFile(other / "energy.csv") == readFile(reference / "energy.csv"));
}

TEST(ThermostatOnRanks, GoesOnOverARestart) {
  const Folder whole, pieces;
  expectDone(run(whole, options + "-ts_max_steps 300"));
  // At a step at which nobody looks.
  expectDone(run(pieces, options + "-ts_max_steps 137 -checkpoint_file c.h5", 2));
  expectDone(run(pieces, options + "-ts_max_steps 300 -restart c.h5", 3, 2));
  expectSame(pieces, whole, "in two pieces");
}

}  // namespace
}  // namespace nanoweft::test
