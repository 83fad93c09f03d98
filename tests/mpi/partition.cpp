/// METIS and straight cuts: the same bytes, and equal shares where straight cuts cannot make them.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "support/program.hpp"

namespace nanoweft::test {
namespace {

struct Report {
  std::string kind;
  double imbalance;
};

/// What the summary says of the partition.
Report partitionOf(const Outcome& outcome) {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(
      outcome.output, found,
      std::regex("partition: ([a-z]+), imbalance of work ([0-9.]+), ([0-9.e+-]+) ghosts a segment, "
                 "([0-9]+) bonds cut")))
      << outcome.output;
  return found.size() == 5 ? Report{found[1], std::stod(found[2])} : Report{"", 0};
}

/// A bundle of parallel tubes, hexagonally packed, along x.
void addBundle(std::vector<FibreInput>& fibres, const Vec3d& corner, int side, int segments) {
  const double distance = 17.1;
  for (int a = 0; a < side; ++a)
    for (int b = 0; b < side; ++b)
      fibres.push_back(straightFibre(
          corner + Vec3d{0, distance * (a + 0.5 * (b % 2)), distance * std::sqrt(0.75) * b},
          {1, 0, 0}, segments));
}

TEST(Partition, WeaveWithBreakageHasTheSameBytesHoweverItIsShared) {
  // 2000 steps, with a restart on another number of ranks in between.
  const std::string scene =
      "-weave_fibres 4,4 -weave_segments 32 -damping_local 0.4 -tension_rate 2e-5 -tension_ramp "
      "2000 -tension_grip 40 -tension_max_strain 1 -break_strain_mean 0.12 -break_strain_std 0.03 "
      "-ts_dt 12 -partition_tolerance 1.02 -energy_monitor ascii:energy.csv ";
  const std::string whole = scene + "-ts_max_steps 2000 -state_output out.h5 ";
  const Folder reference;
  auto outcome = run(reference, whole);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_GT(readDataset(reference / "out.h5", "/state/bond_broken").size(), 0u);
  int broken = 0;
  for (double b : readDataset(reference / "out.h5", "/state/bond_broken")) broken += b != 0;
  EXPECT_GT(broken, 0);
  const std::string metis = "-partition metis -partition_piece 4 ";
  struct Layout {
    int ranks, threads;
    std::string partition;
  };
  for (const Layout& l : {Layout{2, 1, metis},
                          {3, 1, metis},
                          {4, 2, metis},
                          {8, 1, metis},
                          {3, 2, "-partition dmda "}}) {
    const Folder folder;
    outcome = run(folder, scene + l.partition + "-ts_max_steps 900 -checkpoint_file c.h5", l.ranks,
                  l.threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    outcome = run(folder, whole + "-restart c.h5 " + l.partition, l.ranks == 8 ? 2 : l.ranks + 1);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(partitionOf(outcome).kind, l.partition == metis ? "metis" : "rectilinear");
    for (const char* file : {"out.h5", "energy.csv"})
      EXPECT_TRUE(readFile(folder / file) == readFile(reference / file))
          << file << " on " << l.ranks << " x " << l.threads << " " << l.partition;
  }
}

TEST(Partition, TwoOccupiedCornersOnThreeRanks) {
  // Straight cuts through a bundle three cells thick cannot make thirds; pieces of fibre can.
  const Folder folder;
  std::vector<FibreInput> fibres;
  addBundle(fibres, {-800, -900, -900}, 10, 32);
  addBundle(fibres, {400, 600, 600}, 10, 32);
  writeState(folder / "in.h5", fibres);
  const std::string options = "-scene file -scene_file in.h5 -ts_max_steps 2 ";
  auto report = [&](const std::string& partition) {
    const auto outcome = run(folder, options + partition, 3);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return partitionOf(outcome);
  };
  const Report straight = report("-partition dmda"), metis = report("-partition metis");
  EXPECT_EQ(straight.kind, "rectilinear");
  EXPECT_EQ(metis.kind, "metis");
  EXPECT_GT(straight.imbalance, 1.1);
  EXPECT_LT(metis.imbalance, 1.06);
}

TEST(Partition, MetisGivesWayWhereItsBordersCostMoreThanItEvensOut) {
  // A dense bundle: pieces of fibre have long borders, and so many ghosts.
  const Folder folder;
  const std::string options =
      "-scene bundle -bundle_fibres 91 -bundle_segments 64 -scene_perturb 0.3 -ts_dt 20 "
      "-partition_tolerance 1.001 -pair_skin 0.3 -ts_max_steps 20 ";
  const auto metis = run(folder, options + "-partition metis", 3),
             automatic = run(folder, options, 3);
  ASSERT_EQ(metis.status, 0) << metis.output;
  ASSERT_EQ(automatic.status, 0) << automatic.output;
  EXPECT_EQ(partitionOf(metis).kind, "metis");
  EXPECT_EQ(partitionOf(automatic).kind, "rectilinear");
  // Before the first step, and not when the lists are made anew some day.
  const auto once = run(folder, options + "-pair_skin 5 -ts_max_steps 1", 3);
  ASSERT_EQ(once.status, 0) << once.output;
  EXPECT_EQ(partitionOf(once).kind, "rectilinear");
}

TEST(Partition, WorkCountsNotSegments) {
  // A bundle, whose segments have many neighbours, beside as many loose tubes, which have none.
  const Folder folder;
  std::vector<FibreInput> fibres;
  addBundle(fibres, {-400, -950, -100}, 8, 64);
  for (int k = 0; k < 64; ++k)
    fibres.push_back(
        straightFibre({-400, -700.0 + 100 * (k % 16), -200.0 + 100 * (k / 16)}, {1, 0, 0}, 64));
  writeState(folder / "in.h5", fibres);
  const auto outcome = run(folder, "-scene file -scene_file in.h5 -ts_max_steps 2", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Report report = partitionOf(outcome);
  EXPECT_EQ(report.kind, "metis");
  EXPECT_LT(report.imbalance, 1.06);
}

TEST(Partition, EvenSheetKeepsStraightCuts) {
  const Folder folder;
  const auto outcome =
      run(folder, "-weave_fibres 40,40 -weave_segments 200 -weave_periodic -ts_max_steps 2", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Report report = partitionOf(outcome);
  EXPECT_EQ(report.kind, "rectilinear");
  EXPECT_LT(report.imbalance, 1.05);
}

TEST(Partition, FewerPiecesThanRanks) {
  const std::string options =
      "-scene fibre -fibre_segments 40 -fibre_bend 1 -ts_max_steps 20 -state_output out.h5 ";
  const Folder one, four;
  auto outcome = run(one, options, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(four, options + "-partition metis", 4);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(one / "out.h5") == readFile(four / "out.h5"));
}

}  // namespace
}  // namespace nanoweft::test
