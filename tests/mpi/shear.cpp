/// A box that is sheared until its images have slid through a whole period: the same bytes on any
/// ranks, threads and skins, and over restarts.
#include <gtest/gtest.h>

#include "support/program.hpp"

namespace nanoweft::test {
namespace {

const std::string weave =
    "-weave_fibres 6,6 -weave_segments 24 -weave_periodic -damping_local 0.1 -ts_dt 15 "
    "-deform_xy rate -deform_xy_rate 1e-4 -deform_y free -deform_thickness 30 "
    "-break_strain_mean 0.03 -break_strain_std 0.01 -progress_interval 0 ";
const std::string outputs =
    "-box_monitor ascii:box.csv -energy_monitor ascii:energy.csv -monitor_interval 100 "
    "-state_output out.h5 ";

TEST(ShearOnRanks, SameBytesOnAnyRanksThreadsSkinsAndRestarts) {
  const Folder reference;
  auto outcome = run(reference, weave + outputs + "-ts_max_steps 800", 1, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_GT(readCsv(reference / "box.csv").at("strain_xy").back(), 1.1);
  const struct {
    int ranks, threads;
    const char* more;
  } layouts[] = {{1, 2, "-pair_skin 2"}, {3, 1, ""}, {2, 2, "-partition metis -partition_piece 8"}};
  for (const auto& l : layouts) {
    const Folder folder;
    outcome = run(folder, weave + outputs + "-ts_max_steps 800 " + l.more, l.ranks, l.threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    for (const char* file : {"out.h5", "energy.csv", "box.csv"})
      EXPECT_TRUE(readFile(folder / file) == readFile(reference / file))
          << file << " on " << l.ranks << " x " << l.threads << " " << l.more;
  }
  // The tilt turns from half a period to minus half between steps 330 and 340.
  const Folder pieces;
  outcome = run(pieces, weave + outputs + "-ts_max_steps 250 -checkpoint_file c.h5", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, outputs + "-restart c.h5 -ts_max_steps 800", 3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file : {"out.h5", "energy.csv", "box.csv"})
    EXPECT_TRUE(readFile(pieces / file) == readFile(reference / file)) << file;
}

TEST(ShearOnRanks, AServoGoesOnAfterARestart) {
  // Springs of fibres that lean are sheared back to no stress, in another plane.
  const std::string film =
      "-scene network -network_size 300,300,200 -network_fibres 30 -network_segments 10 "
      "-links_density 0.005 -links_distance 40 -link_law spring "
      "-link_stretch 2 -damping_local 0.2 -ts_dt 10 -deform_yz stress -deform_yz_stress 0.01 "
      "-deform_modulus 1 -deform_time 1000 -progress_interval 0 ";
  const Folder reference, pieces;
  auto outcome = run(reference, film + outputs + "-ts_max_steps 400", 1, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(readCsv(reference / "box.csv").at("strain_yz").back(), 0);
  outcome = run(pieces, film + outputs + "-ts_max_steps 150 -checkpoint_file c.h5", 3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, outputs + "-restart c.h5 -ts_max_steps 400", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file : {"out.h5", "energy.csv", "box.csv"})
    EXPECT_TRUE(readFile(pieces / file) == readFile(reference / file)) << file;
}

}  // namespace
}  // namespace nanoweft::test
