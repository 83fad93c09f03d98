/// Walls: the same bytes on any ranks and threads, and over restarts.
#include <gtest/gtest.h>

#include "support/expect.hpp"
#include "support/program.hpp"

namespace nanoweft::test {
namespace {

/// A weave between a floor and a lid that a force drives, and a ball that turns and comes down.
const std::string pressed =
    "-weave_fibres 6,6 -weave_segments 24 -pair contact -contact_modulus 30 -contact_friction 0.3 "
    "-walls floor,lid,ball -floor_point 0,0,-25 -floor_axis 0,0,1 -floor_modulus 20 "
    "-floor_friction 0.4 -lid_point 0,0,25 -lid_axis 0,0,-1 -lid_modulus 20 -lid_force 0,0,-2 "
    "-lid_mass 200000 -lid_drag 100 -lid_friction 0.2 -ball_shape sphere -ball_point 0,0,80 "
    "-ball_radius 60 -ball_velocity 0,0,-0.004 -ball_spin 1e-4 -ball_axis 0,0,1 -ball_modulus 20 "
    "-ball_friction 0.3 "
    "-ball_restitution 0.7 -damping_local 0.1 -ts_dt 8 -progress_interval 0 ";

std::string options(int steps, const std::string& more) {
  return pressed +
         "-energy_monitor ascii:energy.csv -wall_monitor ascii:walls.csv -monitor_interval 50 "
         "-state_output out.h5 -ts_max_steps " +
         std::to_string(steps) + " " + more;
}

TEST(WallsOnRanks, SameBytesOnAnyRanksThreadsAndRestarts) {
  const Folder reference;
  auto outcome = run(reference, options(500, ""), 1, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto walls = readCsv(reference / "walls.csv");
  for (const char* wall : {"floor", "lid", "ball"})
    EXPECT_NE(walls.at(wall + std::string("_force_z")).back(), 0) << wall << " is not touched";
  EXPECT_NE(readCsv(reference / "energy.csv").at("friction").back(), 0);
  const struct {
    int ranks, threads;
    const char* more;
  } layouts[] = {{1, 2, ""}, {3, 1, ""}, {4, 1, "-partition metis -partition_piece 8"}};
  for (const auto& l : layouts) {
    const Folder folder;
    outcome = run(folder, options(500, l.more), l.ranks, l.threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    for (const char* file : {"out.h5", "energy.csv", "walls.csv"})
      EXPECT_TRUE(readFile(folder / file) == readFile(reference / file))
          << file << " on " << l.ranks << " x " << l.threads << " " << l.more;
  }
  const Folder pieces;
  outcome = run(pieces, options(230, "-checkpoint_file c.h5"), 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces,
                "-restart c.h5 -ts_max_steps 500 -energy_monitor ascii:energy.csv -wall_monitor "
                "ascii:walls.csv -monitor_interval 50 -state_output out.h5",
                3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file : {"out.h5", "energy.csv", "walls.csv"})
    EXPECT_TRUE(readFile(pieces / file) == readFile(reference / file)) << file;
}

}  // namespace
}  // namespace nanoweft::test
