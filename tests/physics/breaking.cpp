/// Breakage: which bonds break, when, and that no energy jumps in.
#include <gtest/gtest.h>

#include <cmath>

#include "nanoweft/force/bond_list.hpp"
#include "support/program.hpp"

namespace nanoweft::test {
namespace {

TEST(Breaking, WeakestBondOfAFibreBreaksFirst) {
  const Folder folder;
  const int segments = 20;
  const auto outcome = run(
      folder,
      "-scene fibre -fibre_segments 20 -pair none -damping_local 0.7 -tension_rate 2e-6 "
      "-tension_grip 1 "
      "-tension_width 17 -break_seed 5 -tension_max_strain 0.35 -stress_monitor ascii:stress.csv "
      "-monitor_interval 10 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  BreakageLaw law;
  law.seed = 5;
  int weakest = 0;
  for (int k = 1; k < segments - 1; ++k)
    if (law.criticalStrain(0, k, 100) < law.criticalStrain(0, weakest, 100)) weakest = k;
  const auto broken = readDataset(folder / "out.h5", "/state/bond_broken");
  for (std::size_t k = 0; k < broken.size(); ++k)
    EXPECT_EQ(broken[k], k == static_cast<std::size_t>(weakest)) << k;
  const auto csv = readCsv(folder / "stress.csv");
  double strength = 0;
  for (double s : csv.at("stress_right_GPa")) strength = std::max(strength, s);
  // Pulled slowly, the force at break is ES times the critical strain; area 17 A x 17.1 A.
  const double expected =
      67.593 * 13.56 * law.criticalStrain(0, weakest, 100) / (17 * 17.1) / 6.241509e-3;
  EXPECT_NEAR(strength / expected, 1.0, 0.03);
}

TEST(Breaking, NeighboursOfABreakDoNotInteractBeforeTheyHaveParted) {
  // Every bond of a stretched fibre breaks at the start; its segments lie deep in each other's
  // repulsion.
  const Folder folder;
  const std::string options =
      "-scene fibre -fibre_segments 12 -fibre_strain 0.3 -break_strain_mean 0.25 -break_strain_std "
      "0.0001 -damping_local 0.0 "
      "-energy_monitor ascii:energy.csv -monitor_interval 5 -ts_dt 5 -ts_max_steps 3000";
  const auto outcome = run(folder, options + " -state_output out.h5", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto csv = readCsv(folder / "energy.csv");
  EXPECT_GT(csv.at("broken").front(), 100.0);  // all bonds broke at once, at the first evaluation
  EXPECT_EQ(csv.at("stretch").front(), 0.0);
  // Had the pairs been switched on, they would fly apart with thousands of eV.
  for (double e : csv.at("pair")) EXPECT_EQ(e, 0.0);
}

TEST(Breaking, PartedPiecesInteractWhenTheyMeetAgain) {
  // Two pieces of one fibre, the bond between them broken, beyond each other's reach and moving
  // towards each other along y: they must attract and collide as pieces of different fibres do.
  const Folder folder;
  FibreInput one = straightFibre({0, 0, 0}, {1, 0, 0}, 6);
  const FibreInput other = straightFibre({0, 80, 0}, {1, 0, 0}, 6);
  std::vector<FibreInput> asTwo{one, other};
  one.position.insert(one.position.end(), other.position.begin(), other.position.end());
  one.orientation.insert(one.orientation.end(), other.orientation.begin(), other.orientation.end());
  const std::string move =
      " -bc left,right -left_region -1000,-10,-10,1000,10,10 -left_force 0,0.08,0 -right_region "
      "-1000,70,-10,1000,90,10 "
      "-right_force 0,-0.08,0 -ts_dt 10 -ts_max_steps 1500 -energy_monitor ascii:energy.csv "
      "-monitor_interval 10 -state_output out.h5 -overwrite";
  writeState(folder / "in.h5", asTwo);
  auto outcome = run(folder, "-scene file -scene_file in.h5" + move);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto expected = readDataset(folder / "out.h5", "/state/position");
  const auto energies = readCsv(folder / "energy.csv");
  EXPECT_LT(energies.at("pair").back(), -1.0);  // they have met
  // As one fibre: the bond between the pieces is 80 A long, so it breaks at once.
  writeState(folder / "in.h5", {one});
  outcome = run(folder,
                "-scene file -scene_file in.h5 -start_unchecked -break_strain_mean 0.3" + move, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto found = readDataset(folder / "out.h5", "/state/position");
  EXPECT_EQ(found, expected);
}

TEST(Breaking, OneDrawPerFibreOrPerBond) {
  const Folder folder;
  // All bonds at a strain of 0.3, the mean: about half of them break at once, or of the fibres.
  std::vector<FibreInput> fibres;
  for (int f = 0; f < 40; ++f) {
    FibreInput g;
    for (int k = 0; k < 11; ++k) {
      g.position.push_back({17.628 * k, 200.0 * f, 0});
      g.orientation.push_back({1, 0, 0, 0});
    }
    fibres.push_back(g);
  }
  BoxInput box;
  box.upper[1] = 9000;
  writeState(folder / "in.h5", fibres, box);
  const std::string common =
      "-scene file -scene_file in.h5 -pair none -ts_max_steps 0 -state_output out.h5 "
      "-overwrite -break_seed 3 -start_unchecked ";
  for (const char* per : {"bond", "fibre"}) {
    const auto outcome = run(
        folder,
        common + (std::string(per) == "fibre" ? "-break_scatter 0 " : "") + "-break_per " + per, 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto broken = readDataset(folder / "out.h5", "/state/bond_broken");
    int count = 0, whole = 0;
    for (std::size_t f = 0; f < 40; ++f) {
      int here = 0;
      for (std::size_t k = 0; k < 10; ++k) here += broken[11 * f + k] != 0;
      count += here;
      whole += here == 0 || here == 10;
    }
    if (std::string(per) == "fibre") {
      EXPECT_EQ(whole, 40);
      EXPECT_GT(count, 80);
      EXPECT_LT(count, 320);
    } else {
      EXPECT_LT(whole, 10);
      EXPECT_NEAR(count, 200, 60);
    }
  }
}

}  // namespace
}  // namespace nanoweft::test
