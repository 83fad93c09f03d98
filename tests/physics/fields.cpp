/// Fields of the segments in snapshots: strain, shares of the energies.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

const std::vector<std::string> energies{"stretch", "shear", "bending", "torsion", "pair"};

std::string frame(const Folder& folder, int step) {
  char name[40];
  std::snprintf(name, sizeof name, "frame_%010d.h5", step);
  return folder / name;
}

std::vector<double> energyField(const std::string& file, const std::string& part) {
  return readDataset(file, "/field/" + part + "_energy");
}

/// Half the spacing of float32 numbers, relative.
constexpr double rounding = 0x1p-24;

void expectTotals(const std::string& options, int ranks, int snapshots) {
  const Folder folder;
  const auto outcome = run(folder,
                           options +
                               " -snapshot_file frame -snapshot_interval 100 -energy_monitor "
                               "ascii:energy.csv -monitor_interval 100",
                           ranks);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto csv = readCsv(folder / "energy.csv");
  for (int k = 0; k < snapshots; ++k) {
    const auto row = static_cast<std::size_t>(k);
    ASSERT_EQ(csv.at("step")[row], 100 * k);
    for (const std::string& part : energies) {
      double sum = 0, size = 0;
      for (double e : energyField(frame(folder, 100 * k), part)) sum += e, size += std::abs(e);
      EXPECT_NEAR(sum, csv.at(part)[row], rounding * size + 1e-12) << part << " " << k;
    }
  }
}

TEST(Fields, SumToTheTotals) {
  expectTotals("-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -ts_max_steps 300", 1, 4);
}

TEST(Fields, SumToTheTotalsWithFewerPointsFarApartAndPeriodicRings) {
  expectTotals(
      "-weave_fibres 6,6 -weave_segments 36 -weave_periodic -scene_perturb 0.2 -pair_far_points 1 "
      "-ts_max_steps 200",
      2, 3);
}

TEST(Fields, SumToTheTotalsOfOtherLaws) {
  const std::string weave = "-weave_fibres 4,4 -weave_segments 24 -ts_max_steps 100 ";
  expectTotals(weave + "-pair hertz -weave_gap 13", 1, 2);
  expectTotals(weave + "-pair none", 1, 2);
}

TEST(Fields, StrainCountsFromTheBondsOwnRest) {
  // At 13.56 A, bonds that are longer at rest are compressed.
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 4)});
  setDataset(folder / "in.h5", "rest_extension", {0.1, 0.0, -0.2, 0.0}, 1);
  ASSERT_EQ(run(folder,
                "-scene file -scene_file in.h5 -pair none -ts_max_steps 0 -snapshot_file frame "
                "-snapshot_interval 1")
                .status,
            0);
  const auto strain = readDataset(frame(folder, 0), "/field/strain");
  EXPECT_NEAR(strain[0], tube::length / (tube::length + 0.1) - 1.0, 1e-7);
  EXPECT_NEAR(strain[1], 0.0, 1e-7);
  EXPECT_NEAR(strain[2], tube::length / (tube::length - 0.2) - 1.0, 1e-7);
}

TEST(Fields, EverySegmentHasItsShare) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-weave_fibres 4,4 -weave_segments 24 -pair_points 3 -scene_perturb 0.3 -ts_max_steps "
          "100 -snapshot_file frame -snapshot_interval 100",
          2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string file = frame(folder, 100);
  const auto x = readVectors(file, "/state/position");
  const auto q = readOrientations(file);
  const auto fibre = readDataset(file, "/state/fibre"), strain = readDataset(file, "/field/strain");
  std::vector<double> expected[5];
  for (auto& e : expected) e.assign(x.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool last = i + 1 == x.size() || fibre[i] != fibre[i + 1];
    EXPECT_NEAR(strain[i], last ? 0.0 : norm(x[i + 1] - x[i]) / tube::length - 1.0, 1e-8);
    for (std::size_t j = i + 1; j < x.size(); ++j)
      if (fibre[i] != fibre[j]) {
        const double half = 0.5 * tube::pair(x[i], q[i], x[j], q[j]).energy;
        expected[4][i] += half, expected[4][j] += half;
      }
    if (last) continue;
    const auto b = tube::bond(x[i], q[i], x[i + 1], q[i + 1]);
    const double parts[4] = {b.stretch, b.shear, b.bending, b.torsion};
    for (std::size_t k = 0; k < 4; ++k)
      expected[k][i] += 0.5 * parts[k], expected[k][i + 1] += 0.5 * parts[k];
  }
  for (std::size_t k = 0; k < 5; ++k) {
    const auto found = energyField(file, energies[k]);
    ASSERT_EQ(found.size(), x.size());
    // The formulas above cancel terms of 2e4 eV; the law's table is good to 1e-11.
    for (std::size_t i = 0; i < x.size(); ++i)
      EXPECT_NEAR(found[i], expected[k][i], rounding * std::abs(expected[k][i]) + 1e-10)
          << energies[k] << " " << i;
  }
}

TEST(Fields, BrokenBondsHaveNoStrain) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -tension_rate 2e-5 "
          "-tension_ramp 2000 -tension_grip 40 -tension_max_strain 0.45 -break_strain_mean 0.12 "
          "-break_strain_std 0.03 -ts_dt 15 -snapshot_file frame -snapshot_interval 100 "
          "-energy_monitor ascii:energy.csv -monitor_interval 100",
          2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto csv = readCsv(folder / "energy.csv");
  int count = 0;
  for (std::size_t k = 0; k < csv.at("step").size() - 1; ++k) {
    const std::string file = frame(folder, static_cast<int>(csv.at("step")[k]));
    const auto broken = readDataset(file, "/state/bond_broken"),
               strain = readDataset(file, "/field/strain");
    for (std::size_t i = 0; i < broken.size(); ++i)
      if (broken[i] != 0) {
        ++count;
        EXPECT_EQ(strain[i], 0.0);
      }
    for (const std::string& part : energies) {
      double sum = 0, size = 0;
      for (double e : energyField(file, part)) sum += e, size += std::abs(e);
      EXPECT_NEAR(sum, csv.at(part)[k], rounding * size + 1e-12) << part << " " << k;
    }
  }
  EXPECT_GT(count, 20);
}

TEST(Fields, SnapshotBetweenRecordsIsTheStateOfItsStep) {
  // Nothing else looks at step 7: its second half kick must have been made all the same.
  const std::string weave =
      "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -monitor_interval 1000 ";
  const Folder between, end;
  auto outcome = run(between, weave + "-ts_max_steps 10 -snapshot_file s -snapshot_interval 7");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(end, weave + "-ts_max_steps 7 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* name : {"position", "orientation", "velocity", "angular_velocity"}) {
    const std::string dataset = std::string("/state/") + name;
    EXPECT_TRUE(readDataset(between / "s_0000000007.h5", dataset) ==
                readDataset(end / "out.h5", dataset))
        << name;
  }
}

}  // namespace
}  // namespace nanoweft::test
