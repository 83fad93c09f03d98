/// Pair forces in the whole program: reference pairs, adhesion of parallel tubes, exclusion, laws.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "support/program.hpp"

namespace nanoweft::test {
namespace {

double pairEnergy(const Folder& folder, const std::string& options, int ranks = 1) {
  const auto outcome = run(
      folder,
      "-scene file -scene_file in.h5 -ts_max_steps 0 -energy_monitor ascii:energy.csv -overwrite " +
          options,
      ranks);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return readCsv(folder / "energy.csv").at("pair").front();
}

TEST(Adhesion, ReferencePairsThroughTheProgram) {
  // Every reference pair with 3 points, smooth splice, as two single segments far from all others.
  const Folder folder;
  std::ifstream file(std::string(NANOWEFT_SOURCE_DIR) + "/tests/data/pairs.csv");
  std::string line, cell;
  std::getline(file, line);
  std::vector<FibreInput> fibres;
  std::vector<std::vector<double>> rows;
  double energy = 0;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<double> row;
    while (std::getline(cells, cell, ',')) row.push_back(std::stod(cell));
    if (row[0] != 3 || row[1] != 1) continue;
    const Vec3d shift{300.0 * static_cast<double>(rows.size()), 0, 0};
    fibres.push_back({{shift + Vec3d{row[2], row[3], row[4]}}, {{row[5], row[6], row[7], row[8]}}});
    fibres.push_back(
        {{shift + Vec3d{row[9], row[10], row[11]}}, {{row[12], row[13], row[14], row[15]}}});
    energy += row[16];
    rows.push_back(row);
  }
  ASSERT_GE(rows.size(), 30u);
  BoxInput box;
  box.upper[0] = 300.0 * static_cast<double>(rows.size()) + 1000;
  writeState(folder / "in.h5", fibres, box);
  for (int ranks : {1, 3}) {
    const double found = pairEnergy(
        folder, "-pair_points 3 -pair_far_points 3 -state_output out.h5 -state_forces", ranks);
    EXPECT_NEAR(found, energy, 1e-9 * std::abs(energy));
    const auto force = readDataset(folder / "out.h5", "/state/force"),
               torque = readDataset(folder / "out.h5", "/state/torque");
    for (std::size_t k = 0; k < rows.size(); ++k) {
      double size = 1e-3;
      for (std::size_t c = 0; c < 3; ++c) size = std::max(size, std::abs(rows[k][17 + c]));
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(force[6 * k + c], rows[k][17 + c], 1e-9 * size);
        EXPECT_EQ(force[6 * k + c], -force[6 * k + 3 + c]);
        EXPECT_NEAR(torque[6 * k + c], rows[k][20 + c], 1e-8 * size);
        EXPECT_NEAR(torque[6 * k + 3 + c], rows[k][23 + c], 1e-8 * size);
      }
    }
  }
}

TEST(Adhesion, ParallelTubesHaveThePublishedEnergyPerLength) {
  // model.md 4.1: -0.193731 eV/A at 17.0716 A for the continuous smooth law; the cutoff at 3T to
  // 4T changes it by 0.04 %. Two endless tubes: closed fibres through a periodic boundary.
  const Folder folder;
  const int segments = 40;
  auto energyPerLength = [&](double distance, double slide) {
    FibreInput a = straightFibre({0, 0, 0}, {1, 0, 0}, segments),
               b = straightFibre({slide, distance, 0}, {1, 0, 0}, segments);
    a.closed = b.closed = true;
    BoxInput box;
    box.lower = {0, -200, -200}, box.upper = {segments * 13.56, 200, 200},
    box.periodic = {true, false, false};
    writeState(folder / "in.h5", {a, b}, box);
    return pairEnergy(folder, "-pair_points 5") / (segments * 13.56);
  };
  EXPECT_NEAR(energyPerLength(17.0716, 0) / -0.193731, 1.0, 6e-4);
  EXPECT_LT(energyPerLength(17.0716, 0), energyPerLength(16.97, 0));
  EXPECT_LT(energyPerLength(17.0716, 0), energyPerLength(17.17, 0));
  // Sliding costs almost nothing: 0.0017 % with 5 points.
  EXPECT_NEAR(energyPerLength(17.0716, 13.56 / 10) / energyPerLength(17.0716, 0), 1.0, 3e-5);
}

TEST(Adhesion, NeighboursAlongAFibreAreExcluded) {
  // Two segments in line, k places apart: within the cutoff up to k = 4 (points 4 T - 2/3 T apart).
  const Folder folder;
  const std::string points = "-pair_points 3 -pair_far_points 3 ";
  auto inLine = [&](int places) {
    writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 1),
                                  straightFibre({13.56 * places, 0, 0}, {1, 0, 0}, 1)});
    return pairEnergy(folder, points);
  };
  const double three = inLine(3), four = inLine(4);
  EXPECT_LT(three, four);
  EXPECT_LT(four, 0.0);
  EXPECT_EQ(inLine(5), 0.0);
  // So a straight fibre of 30 has 27 such pairs 3 places apart and 26 pairs 4 places apart.
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 30)});
  EXPECT_NEAR(pairEnergy(folder, points + "-pair_exclude 3"), 27 * three + 26 * four, 1e-9);
  EXPECT_NEAR(pairEnergy(folder, points + "-pair_exclude 4"), 26 * four, 1e-9);
  EXPECT_EQ(pairEnergy(folder, points + "-pair_exclude 5"), 0.0);
}

TEST(Adhesion, PairNoneIsFreeOfPairs) {
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 5), straightFibre({0, 17, 0}, {1, 0, 0}, 5)});
  EXPECT_EQ(pairEnergy(folder, "-pair none"), 0.0);
  EXPECT_LT(pairEnergy(folder, "-pair vdw"), -1.0);
}

TEST(Adhesion, HertzRepelsOnlyInContact) {
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 1), straightFibre({0, 12.56, 0}, {1, 0, 0}, 1)});
  // One point each, overlap 1 A: K.
  EXPECT_NEAR(pairEnergy(folder, "-pair hertz -pair_points 1 -hertz_stiffness 3"), 3.0, 1e-12);
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 1), straightFibre({0, 13.6, 0}, {1, 0, 0}, 1)});
  EXPECT_EQ(pairEnergy(folder, "-pair hertz -pair_points 1"), 0.0);
}

TEST(Adhesion, ALawThatAddsNothingChangesNothing) {
  // No fibres overlap, so hertz is zero; damping and links belong to pairs, not to laws.
  const Folder folder;
  auto energies = [&](const std::string& laws, const char* table) {
    const auto outcome =
        run(folder,
            "-scene weave -weave_fibres 4,4 -weave_segments 16 -links_density 0.003 "
            "-links_distance 20 -damping_viscous 20 -ts_dt 10 -ts_max_steps 60 -overwrite "
            "-monitor_interval 20 -energy_monitor ascii:" +
                std::string(table) + " -pair " + laws,
            1);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return readCsv(folder / table);
  };
  const auto one = energies("vdw", "one.csv"), two = energies("vdw,hertz", "two.csv");
  EXPECT_GT(one.at("damped").back(), 0.0);
  for (const auto& [column, values] : one)
    for (std::size_t k = 0; k < values.size(); ++k)
      EXPECT_NEAR(two.at(column)[k], values[k], 1e-8 * (1 + std::abs(values[k]))) << column;
}

}  // namespace
}  // namespace nanoweft::test
