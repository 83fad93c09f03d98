/// Two kinds of fibre in one run: the same bytes on any ranks and threads, and over restarts.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

/// Thin fibres along x, woven with some twice as thick along y; the thick ones alone break.
const std::string weave =
    "-kinds thin,thick -thick_fibre_radius 13.56 -thick_fibre_density 2273 -weave_kinds thin,thick "
    "-weave_fibres 8,4 -weave_segments 32 -scene_perturb 0.2 -damping_local 0.2 -ts_dt 12 "
    "-thick_break_strain_mean 0.012 -thick_break_strain_std 0.004 -progress_interval 0 ";
const std::string outputs =
    "-energy_monitor ascii:energy.csv -monitor_interval 50 -state_output out.h5 -state_forces ";

TEST(KindsInOneRun, SameBytesOnAnyRanksThreadsAndPartition) {
  const Folder reference;
  auto outcome = run(reference, weave + outputs + "-ts_max_steps 300", 1, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto energies = readCsv(reference / "energy.csv");
  EXPECT_GT(energies.at("broken").back(), 0) << "no thick fibre has broken";
  EXPECT_LT(energies.at("pair").back(), 0) << "no fibres attract each other";
  const struct {
    int ranks, threads;
    const char* more;
  } layouts[] = {{1, 2, ""}, {2, 1, ""}, {3, 2, ""}, {4, 1, "-partition metis -partition_piece 8"}};
  for (const auto& l : layouts) {
    const Folder folder;
    outcome = run(folder, weave + outputs + "-ts_max_steps 300 " + l.more, l.ranks, l.threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    for (const char* file : {"out.h5", "energy.csv"})
      EXPECT_TRUE(readFile(folder / file) == readFile(reference / file))
          << file << " on " << l.ranks << " x " << l.threads << " " << l.more;
  }
}

TEST(KindsInOneRun, TheTableOfKindsAddsUpToTheEnergiesOnAnyRanks) {
  const std::string monitors =
      "-energy_monitor ascii:energy.csv -kind_monitor ascii:kinds.csv -monitor_interval 40 "
      "-ts_max_steps 80";
  const Folder one, three;
  auto outcome = run(one, weave + monitors, 1, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(three, weave + monitors, 3, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(one / "kinds.csv") == readFile(three / "kinds.csv"));
  const auto all = readCsv(one / "energy.csv"), kinds = readCsv(one / "kinds.csv");
  ASSERT_EQ(kinds.at("step").size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    for (const char* part : {"stretch", "shear", "bending", "torsion", "kinetic", "rotational"})
      EXPECT_NEAR(
          kinds.at("thin_" + std::string(part))[k] + kinds.at("thick_" + std::string(part))[k],
          all.at(part)[k], 1e-9 * all.at("total")[0])
          << part;
    EXPECT_NEAR(kinds.at("thin_thin_pair")[k] + kinds.at("thin_thick_pair")[k] +
                    kinds.at("thick_thick_pair")[k],
                all.at("pair")[k], 1e-9 * std::abs(all.at("pair")[k]));
    EXPECT_LT(kinds.at("thin_thick_pair")[k], 0);
    EXPECT_EQ(kinds.at("links")[k], 0);
  }
  expectRefused(run(one, "-weave_fibres 2,2 -kind_monitor ascii:k.csv -ts_max_steps 2"),
                {"-kind_monitor", "-kinds"});
}

TEST(KindsInOneRun, TheTableOfStressAddsUpToTheVirialOnAnyRanks) {
  const std::string pull =
      weave +
      "-tension_rate 1e-5 -tension_ramp 2000 -tension_grip 60 -tension_thickness 30 "
      "-links_density 0.005 -links_distance 40 -link_stiffness 20,1000,-200,100 -ts_max_steps 200 "
      "-stress_monitor ascii:stress.csv -kind_stress_monitor ascii:kinds.csv -monitor_interval 100";
  const Folder one, three;
  auto outcome = run(one, pull, 1, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(three, pull, 3, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(one / "kinds.csv") == readFile(three / "kinds.csv"));
  const auto virial = readCsv(one / "stress.csv"), kinds = readCsv(one / "kinds.csv");
  for (std::size_t k = 0; k < 3; ++k) {
    double sum = 0;
    for (const char* carrier :
         {"thin", "thick", "thin_thin_pair", "thin_thick_pair", "thick_thick_pair", "links"}) {
      const double part = kinds.at(carrier + std::string("_GPa")).at(k);
      sum += part;
    }
    for (const char* carrier : {"thin", "thick", "thin_thick_pair", "links"})
      EXPECT_TRUE(k == 0 || kinds.at(carrier + std::string("_GPa"))[k] != 0) << carrier;
    EXPECT_NEAR(sum, virial.at("virial_xx_GPa")[k], 1e-12);
    EXPECT_EQ(kinds.at("strain")[k], virial.at("strain")[k]);
  }
  expectRefused(run(one, weave + "-kind_stress_monitor ascii:k.csv -ts_max_steps 2"),
                {"-kind_stress_monitor", "-tension_rate"});
  expectRefused(run(one,
                    "-weave_fibres 2,2 -tension_rate 1e-5 -kind_stress_monitor ascii:k.csv "
                    "-ts_max_steps 2"),
                {"-kind_stress_monitor", "-kinds"});
}

TEST(KindsInOneRun, TheTableOfKindsBooksEachOnItsOwn) {
  // A thin fibre that is stretched and at rest, far from a thick one that flies; two more thin
  // ones lie side by side.
  const Folder folder;
  constexpr double T = tube::length, strain = 0.01, speed = 1e-4;
  FibreInput thin = straightFibre({0, 0, 0}, {1, 0, 0}, 6);
  for (std::size_t k = 0; k < 6; ++k)
    thin.position[k].x = static_cast<double>(k) * T * (1 + strain);
  FibreInput thick = straightFibre({0, 300, 0}, {1, 0, 0}, 4);  // segments twice as long
  for (Vec3d& x : thick.position) x.x *= 2;
  const std::vector<FibreInput> fibres = {thin, thick, straightFibre({0, -300, 0}, {1, 0, 0}, 3),
                                          straightFibre({0, -317, 0}, {1, 0, 0}, 3)};
  writeState(folder / "in.h5", fibres);
  // Rows: 6 of the first fibre, 4 of the second (thick), 3 and 3.
  std::vector<double> kind(16, 0.0);
  std::fill_n(kind.begin() + 6, 4, 1.0);
  setDataset(folder / "in.h5", "kind", kind, 1);
  setMotion(
      folder / "in.h5",
      [](std::size_t row, const Vec3d&) {
        return Vec3d{0, row >= 6 && row < 10 ? speed : 0, 0};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const std::string kinds =
      "-kinds thin,thick -thick_fibre_radius 13.56 -thick_fibre_density 2273 -scene file "
      "-scene_file in.h5 -start_unchecked -ts_max_steps 0 -kind_monitor ascii:k.csv ";
  auto outcome = run(folder, kinds, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto table = readCsv(folder / "k.csv");
  auto value = [&](const std::string& column) { return table.at(column).at(0); };
  EXPECT_NEAR(value("thin_stretch") / (5 * 0.5 * tube::B1 * strain * strain * T * T), 1, 1e-9);
  EXPECT_NEAR(value("thick_stretch"), 0, 1e-12);
  EXPECT_EQ(value("thin_kinetic"), 0);
  const double mass = 2273 * 1e-30 * 2 * tube::pi * 13.56 * tube::wall * 2 * T / 1.602176634e-29;
  EXPECT_NEAR(value("thick_kinetic") / (4 * 0.5 * mass * speed * speed), 1, 1e-3);
  EXPECT_LT(value("thin_thin_pair"), 0);
  EXPECT_EQ(value("thin_thick_pair"), 0);
  EXPECT_EQ(value("thick_thick_pair"), 0);
}

TEST(KindsInOneRun, TheTableOfStressBooksEachOnItsOwn) {
  // Two fibres at the same strain, one three times as stiff as the other.
  const Folder folder;
  constexpr double T = tube::length, strain = 0.01;
  constexpr int n = 40;
  std::vector<FibreInput> fibres = {straightFibre({0, 0, 0}, {1, 0, 0}, n),
                                    straightFibre({0, 200, 0}, {1, 0, 0}, n)};
  for (FibreInput& f : fibres)
    for (std::size_t k = 0; k < n; ++k) f.position[k].x = static_cast<double>(k) * T * (1 + strain);
  writeState(folder / "in.h5", fibres);
  std::vector<double> kind(2 * n, 0.0);
  std::fill_n(kind.begin() + n, n, 1.0);
  setDataset(folder / "in.h5", "kind", kind, 1);
  const auto outcome =
      run(folder,
          "-kinds soft,stiff -soft_fibre_young 500 -stiff_fibre_young 1500 -scene file -scene_file "
          "in.h5 -start_unchecked -tension_rate 1e-6 -tension_grip 30 -tension_thickness 10 "
          "-tension_width 100 -ts_max_steps 0 -kind_stress_monitor ascii:k.csv",
          2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto table = readCsv(folder / "k.csv");
  const double soft = 500 * tube::area * strain / (100 * 10);
  EXPECT_NEAR(table.at("soft_GPa").at(0) / soft, 1, 1e-3);
  EXPECT_NEAR(table.at("stiff_GPa").at(0) / (3 * soft), 1, 1e-3);
  for (const char* pair : {"soft_soft_pair_GPa", "soft_stiff_pair_GPa", "stiff_stiff_pair_GPa"})
    EXPECT_EQ(table.at(pair).at(0), 0) << pair;
}

TEST(KindsInOneRun, OverlapIsMeasuredByTheRadiiOfBoth) {
  for (const char* kinds : {"thin,thick", "thick,thin"}) {
    const Folder folder;
    const auto outcome =
        run(folder, "-kinds " + std::string(kinds) + " -weave_kinds " + kinds +
                        " -thick_fibre_radius 13.56 -thick_fibre_density 2273 -weave_fibres 2,2 "
                        "-weave_segments 16 -weave_gap 16 -pair_allow_overlap -ts_max_steps 0");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const std::string words = " overlap by ";
    const auto at = outcome.output.find(words);
    ASSERT_NE(at, std::string::npos) << outcome.output;
    // 64 % of the thin radius where crossing axes are 16 A apart; segments that slant come less
    // near.
    const double depth = std::stod(outcome.output.substr(at + words.size()));
    EXPECT_LE(depth, 100 * (6.78 + 13.56 - 16) / 6.78 + 0.5);
    EXPECT_GE(depth, 55);
  }
}

TEST(KindsInOneRun, ViscousDampingAndFireHaveTheSameBytes) {
  for (const std::string& more :
       {std::string("-damping_viscous 20 -damping_viscous_angular 500 -ts_max_steps 200"),
        std::string("-relax_method fire -relax_force 1 -ts_limit_interval 50 -ts_max_steps 300")}) {
    std::string options = weave + outputs + more;
    if (more.find("fire") != std::string::npos)
      options.replace(options.find("-damping_local 0.2"), 18, "");
    const Folder one, three;
    auto outcome = run(one, options, 1, 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    outcome = run(three, options, 3, 1);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(readFile(one / "out.h5") == readFile(three / "out.h5")) << more;
  }
}

TEST(KindsInOneRun, ARestartGoesOnWithThem) {
  const Folder whole, pieces;
  auto outcome = run(whole, weave + outputs + "-ts_max_steps 300", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, weave + outputs + "-ts_max_steps 140 -checkpoint_file c.h5", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // The checkpoint has the options.
  outcome = run(pieces, outputs + "-restart c.h5 -ts_max_steps 300", 3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file : {"out.h5", "energy.csv"})
    EXPECT_TRUE(readFile(pieces / file) == readFile(whole / file)) << file;
}

TEST(KindsInOneRun, RestShapesHaveTheSameBytesAndGoOn) {
  const std::string curved = weave + outputs + "-thin_fibre_rest_curvature 0.001,-0.002 ";
  for (const std::string& options : {curved, weave + outputs + "-weave_rest shaped "}) {
    const Folder whole, pieces;
    auto outcome = run(whole, options + "-ts_max_steps 200", 1, 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    outcome = run(pieces, options + "-ts_max_steps 90 -checkpoint_file c.h5", 3);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    outcome = run(pieces, outputs + "-restart c.h5 -ts_max_steps 200", 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    for (const char* file : {"out.h5", "energy.csv"})
      EXPECT_TRUE(readFile(pieces / file) == readFile(whole / file)) << options << file;
  }
}

TEST(KindsInOneRun, ViscosityAndPlasticFlowHaveTheSameBytesAndGoOn) {
  const std::string options = weave + outputs +
                              "-thin_fibre_retardation 3 -thin_fibre_yield_strain 0.001 "
                              "-fibre_yield_curvature 0.0002 ";
  const Folder whole, pieces;
  auto outcome = run(whole, options + "-ts_max_steps 300", 1, 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* part : {"/state/rest_extension", "/state/rest_rotation"}) {
    const auto values = readDataset(whole / "out.h5", part);
    EXPECT_GT(*std::ranges::max_element(values), 0) << part << ": nothing has flowed";
  }
  outcome = run(pieces, options + "-ts_max_steps 140 -checkpoint_file c.h5", 3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces,
                outputs + "-restart c.h5 -ts_max_steps 300 -partition metis -partition_piece 8", 4);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file : {"out.h5", "energy.csv"})
    EXPECT_TRUE(readFile(pieces / file) == readFile(whole / file)) << file;
}

TEST(KindsInOneRun, TheSkinOfTheListsChangesNoByte) {
  const Folder reference;
  auto outcome = run(reference, weave + outputs + "-ts_max_steps 200", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* skin : {"1.5", "20"}) {
    const Folder folder;
    outcome = run(folder, weave + outputs + "-ts_max_steps 200 -pair_skin " + skin, 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(readFile(folder / "out.h5") == readFile(reference / "out.h5")) << skin;
  }
}

TEST(KindsInOneRun, AStateThatARunHasStrainedGoesOnWithItsKindsInAnyOrder) {
  const Folder folder;
  auto outcome = run(folder, weave +
                                 "-tension_rate 2e-5 -tension_ramp 1000 -tension_grip 60 "
                                 "-tension_thickness 30 -tension_max_strain 0.2 -state_output "
                                 "in.h5 -thick_break_strain_mean 0.5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string from =
      "-scene file -scene_file in.h5 -thick_fibre_radius 13.56 -thick_fibre_density 2273 "
      "-ts_max_steps 2 -ts_dt 5 -progress_interval 0 ";
  for (const char* kinds : {"-kinds thin,thick", "-kinds thick,thin"}) {
    outcome = run(folder, from + kinds, 2);
    EXPECT_EQ(outcome.status, 0) << kinds << outcome.output;
  }
  // With another material the strain is no longer the run's own.
  expectRefused(run(folder, from + "-kinds thin,thick -thin_fibre_young 900", 2),
                {"cannot be meant"});
}

/// A run's final state as the input of another.
TEST(KindsInOneRun, NamesInTheFileSayWhichKindsAreMeant) {
  const Folder folder;
  auto outcome = run(folder, weave + "-state_output in.h5 -ts_max_steps 0", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string from = "-scene file -scene_file in.h5 -progress_interval 0 -ts_max_steps 0 ";
  auto energyWith = [&](const std::string& kinds) {
    outcome = run(folder, from + kinds + " -energy_monitor ascii:e.csv -overwrite", 2);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return readCsv(folder / "e.csv").at("total").back();
  };
  const std::string thick = " -thick_fibre_radius 13.56 -thick_fibre_density 2273";
  EXPECT_EQ(energyWith("-kinds thin,thick" + thick), energyWith("-kinds thick,thin" + thick));
  const struct {
    std::string options, says;
  } refused[] = {
      {"", "-kinds must name"},
      {"-kinds thin,other", "the kind 'thick', which is not among -kinds thin,other"},
  };
  for (const auto& r : refused)
    for (const int ranks : {1, 3}) expectRefused(run(folder, from + r.options, ranks), {r.says});
  // Rows that make no sense are named.
  auto kinds = std::vector<double>(12 * 32, 0.0);
  kinds[5] = 1;
  setDataset(folder / "in.h5", "kind", kinds, 1);
  expectRefused(run(folder, from + "-scene_file_edited -kinds thin,thick" + thick, 2),
                {"row 5", "another kind than the segment before it"});
}

TEST(KindsInOneRun, AKindWithoutFibresIsWarnedOf) {
  for (const int ranks : {1, 3})
    for (const auto& [mixed, warned] :
         {std::pair{"", true}, std::pair{"-weave_kinds a,b", false}}) {
      const Folder folder;
      const auto outcome = run(folder,
                               std::string("-kinds a,b -b_fibre_young 500 -weave_fibres 3,3 "
                                           "-weave_segments 24 -ts_max_steps 0 ") +
                                   mixed,
                               ranks);
      ASSERT_EQ(outcome.status, 0) << outcome.output;
      EXPECT_EQ(outcome.output.find("warning: no fibre is of the kind b") != std::string::npos,
                warned)
          << outcome.output;
    }
}

TEST(KindsInOneRun, RestRotationsThatCannotBeMeantAreRefused) {
  const Folder folder;
  const auto outcome = run(folder, weave + "-state_output in.h5 -ts_max_steps 0", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string from =
      "-scene file -scene_file in.h5 -scene_file_edited -kinds thin,thick -ts_max_steps 0 "
      "-thick_fibre_radius 13.56 -thick_fibre_density 2273 ";
  auto turns = std::vector<double>(3 * 12 * 32, 0.0);
  turns[16] = 4;  // degrees, say
  setDataset(folder / "in.h5", "rest_rotation", turns, 3);
  expectRefused(run(folder, from, 2), {"row 5", "4 rad; pi is the largest"});
  turns[16] = 0;
  setDataset(folder / "in.h5", "rest_rotation", turns, 3);
  expectRefused(run(folder, from + "-thin_fibre_rest_curvature 1e-3,0", 2),
                {"rest rotations of their own"});
}

}  // namespace
}  // namespace nanoweft::test
