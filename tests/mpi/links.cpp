/// Links between segments: the same bytes on any ranks, threads and partitions, and over restarts.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

/// A weave of 8 fibres of 24 segments with 60 links all over it: near and far ones, several at one
/// segment, some within a fibre.
void makeLinked(const Folder& folder) {
  const auto outcome = run(folder,
                           "-weave_fibres 4,4 -weave_segments 24 -scene_perturb 0.1 "
                           "-ts_max_steps 0 -state_output in.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  std::vector<LinkEnds> links;
  for (std::int64_t k = 0; k < 50; ++k)
    links.push_back({k % 8, (7 * k) % 24, (3 * k + 1) % 8, (11 * k + 5) % 24});
  for (std::int64_t k = 0; k < 10; ++k) links.push_back({2, 12, k % 2 ? 2 : 5, 1 + 2 * k});
  std::erase_if(links, [](const LinkEnds& l) { return l[0] == l[2] && l[1] == l[3]; });
  setLinks(folder / "in.h5", links);
}

const std::string options =
    "-scene file -scene_file in.h5 -scene_perturb 0.2 -damping_local 0.2 -progress_interval 0 "
    "-link_stiffness 2,400,-80,30 -link_break_strain 0.01 ";
const std::string outputs =
    "-energy_monitor ascii:energy.csv -monitor_interval 50 -state_output out.h5 -state_forces "
    "-overwrite ";

TEST(Links, HaveTheSameBytesOnAnyRanksThreadsAndPartitions) {
  const Folder folder;
  makeLinked(folder);
  auto outcome = run(folder, options + outputs + "-ts_max_steps 300", 1, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string state = readFile(folder / "out.h5"), table = readFile(folder / "energy.csv");
  const auto broken = readDataset(folder / "out.h5", "/link/broken");
  const auto count = std::count(broken.begin(), broken.end(), 1.0);
  EXPECT_GT(count, 3) << "too few links have broken";
  EXPECT_LT(count, 50) << "too many links have broken";
  EXPECT_GT(readCsv(folder / "energy.csv").at("broken").back(), 0);
  const struct {
    int ranks, threads;
    const char* more;
  } layouts[] = {{1, 2, ""}, {2, 1, ""}, {3, 2, ""}, {4, 1, "-partition metis -partition_piece 6"}};
  for (const auto& l : layouts) {
    outcome = run(folder, options + outputs + "-ts_max_steps 300 " + l.more, l.ranks, l.threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(readFile(folder / "out.h5") == state) << l.ranks << " x " << l.threads << l.more;
    EXPECT_TRUE(readFile(folder / "energy.csv") == table)
        << l.ranks << " x " << l.threads << l.more;
  }
}

TEST(Links, ARestartGoesOnWithThem) {
  const Folder folder;
  makeLinked(folder);
  auto outcome = run(folder, options + outputs + "-ts_max_steps 300", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string state = readFile(folder / "out.h5"), table = readFile(folder / "energy.csv");
  outcome = run(folder, options + outputs + "-ts_max_steps 140 -checkpoint_file c.h5", 3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(folder, outputs + "-restart c.h5 -ts_max_steps 300", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(folder / "out.h5") == state);
  EXPECT_TRUE(readFile(folder / "energy.csv") == table);
}

TEST(Links, AreMadeAtRandomPlacesAsDenselyAsAsked) {
  // 16 fibres of 24 segments, 5208 A in all, with 64 crossings: 30 links of some 100 places.
  const std::string made =
      "-weave_fibres 8,8 -weave_segments 24 -links_density 0.0057 -links_distance 22 -link_law "
      "spring -ts_max_steps 60 -damping_local 0.3 -progress_interval 0 -state_output out.h5 ";
  const Folder one, three, other;
  auto outcome = run(one, made, 1, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(three, made, 3, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(one / "out.h5") == readFile(three / "out.h5"));
  const auto links = readDataset(one / "out.h5", "/link/rest_length");
  EXPECT_NEAR(static_cast<double>(links.size()), 30, 15);  // three standard deviations
  const auto ends = readDataset(one / "out.h5", "/link/segments");
  for (std::size_t k = 0; k < links.size(); ++k) EXPECT_NE(ends[4 * k], ends[4 * k + 2]);
  outcome = run(other, made + "-seed 2", 1);
  EXPECT_NE(readDataset(other / "out.h5", "/link/segments"), ends);
  expectRefused(
      run(other, "-weave_fibres 4,4 -links_density 1 -links_distance 20 -ts_max_steps 2", 2),
      {"-links_density 1: there are only", "at most"});
  expectRefused(run(other, "-links_density 1 -ts_max_steps 2"), {"needs -links_distance"});
  expectRefused(run(other, "-links_density 1e-3 -links_distance 900 -ts_max_steps 2"),
                {"beyond the reach"});
}

TEST(Links, AreBornUnstressedAndSpringsTurnFreely) {
  for (const char* law : {"-link_law spring ", "-link_law bond "}) {
    const Folder folder;
    makeLinked(folder);
    const std::string start =
        "-scene file -scene_file in.h5 -ts_max_steps 0 -energy_monitor "
        "ascii:e.csv -overwrite ";
    auto outcome = run(folder, start + law, 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const double with = readCsv(folder / "e.csv").at("total")[0];
    const Folder without;
    outcome = run(without,
                  "-weave_fibres 4,4 -weave_segments 24 -scene_perturb 0.1 -ts_max_steps 0 "
                  "-energy_monitor ascii:e.csv");
    EXPECT_NEAR(with, readCsv(without / "e.csv").at("total")[0], 1e-9);
  }
}

TEST(Links, OfALaterStageAreThoseOfTheFileAndAnotherLawIsSaid) {
  const Folder folder;
  makeLinked(folder);
  const std::string law = "-link_law spring -link_stretch 3 ",
                    first =
                        "-scene file -scene_file in.h5 -ts_max_steps 60 -progress_interval 0 "
                        "-damping_local 0.2 -state_output a.h5 ",
                    next = "-scene file -scene_file a.h5 -ts_max_steps 2 -progress_interval 0 ";
  auto outcome = run(folder, first + law, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(folder, next + law, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("warning: the run that left"), std::string::npos) << outcome.output;
  outcome = run(folder, next, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("warning: the run that left the state had links of another kind"),
            std::string::npos)
      << outcome.output;
}

TEST(Links, TieFarSegmentsOnAnyRanksWithoutPairForces) {
  // Three fibres far apart: no list range brings them together, only the links do.
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 12), straightFibre({0, 400, 0}, {1, 0, 0}, 12),
              straightFibre({900, 0, 300}, {0, 1, 0}, 12)});
  setLinks(folder / "in.h5", {{0, 3, 1, 8}, {1, 2, 2, 11}, {2, 0, 0, 0}});
  const std::string options =
      "-scene file -scene_file in.h5 -pair none -scene_perturb 0.3 -ts_max_steps 200 "
      "-link_law spring -link_stretch 1 -progress_interval 0 -snapshot_file s -snapshot_interval "
      "200 -energy_monitor ascii:e.csv -overwrite ";
  auto outcome = run(folder, options, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string alone = readFile(folder / "s_0000000200.h5");
  // The fields of the segments add up to the table, links included.
  const auto fields = readDataset(folder / "s_0000000200.h5", "/field/stretch_energy");
  double stretch = 0;
  for (const double e : fields) stretch += e;
  const double table = readCsv(folder / "e.csv").at("stretch").back();
  EXPECT_NEAR(stretch / table, 1.0, 1e-5);
  for (const int ranks : {2, 3}) {
    outcome = run(folder, options, ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(readFile(folder / "s_0000000200.h5") == alone) << ranks;
  }
}

TEST(Links, WrongOnesAreRefusedWithTheirNumber) {
  const std::string start = "-scene file -scene_file in.h5 -ts_max_steps 2 ";
  const struct {
    std::vector<LinkEnds> links;
    const char* says;
  } cases[] = {
      {{{0, 1, 1, 1}, {0, 2, 7, 99}}, "link 1: its end at fibre 7, segment 99 is not in the file"},
      {{{0, 1, 0, 1}}, "link 0: its end at fibre 0, segment 1 is at both its ends"},
      {{{-3, 1, 0, 1}}, "fibre -3"},
      {{}, "has no dataset segments with links"},
  };
  for (const auto& c : cases)
    for (const int ranks : {1, 2}) {
      const Folder folder;
      writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 10),
                                    straightFibre({0, 40, 0}, {1, 0, 0}, 10)});
      setLinks(folder / "in.h5", c.links);
      expectRefused(run(folder, start, ranks), {c.says});
    }
  const Folder folder;
  expectRefused(run(folder, "-weave_fibres 2,2 -link_stretch 3 -ts_max_steps 2"),
                {"-link_stretch", "no links"});
}

}  // namespace
}  // namespace nanoweft::test
