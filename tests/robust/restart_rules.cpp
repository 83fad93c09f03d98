/// What a run may go on from, with which options, and what its files say of where they come from.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "nanoweft/base/digest.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/state/state_signature.hpp"
#include "support/expect.hpp"
#include "support/program.hpp"

using namespace nanoweft;
using namespace nanoweft::test;

namespace {

const std::string weave = "-scene weave -weave_fibres 4,4 -weave_segments 24 -progress_interval 0 ";
const std::string pulled =
    weave + "-damping_local 0.3 -tension_rate 4e-6 -tension_ramp 500 -tension_grip 40 ";
const std::string table = "-monitor_interval 10 -stress_monitor ascii:s.csv ";

/// An attribute of /run that is a text; empty when there is none.
std::string textOf(const std::string& file, const char* name) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  h5::Handle run(H5Gopen2(f, "run", H5P_DEFAULT), H5Gclose);
  return h5::readText(run, name).value_or("");
}

std::vector<double> realsOf(const std::string& file, const char* name) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  h5::Handle run(H5Gopen2(f, "run", H5P_DEFAULT), H5Gclose);
  return h5::readReals(run, name).value_or(std::vector<double>());
}

void copy(const Folder& folder, const std::string& from, const std::string& to) {
  std::filesystem::copy_file(folder / from, folder / to,
                             std::filesystem::copy_options::overwrite_existing);
}

class RestartRules : public testing::TestWithParam<int> {
 protected:
  Outcome go(const Folder& folder, const std::string& options) const {
    return run(folder, options, GetParam());
  }
};
INSTANTIATE_TEST_SUITE_P(Ranks, RestartRules, testing::Values(1, 3));

// Provenance

TEST(ProvenanceOfFiles, IsTheSameOnAnyRanksAndAfterARestart) {
  const std::string text =
      "-break_strain_mean 0.3\n-damping_local 0.3\n-pair_exclude 12\n-seed 1\n-ts_dt 10\n"
      "-vdw_splice kink\n-weave_fibres 4,4\n-weave_segments 24\n";
  // Defaults and what changes no result are not among them; breakage is on by being given.
  const std::string options =
      "-weave_segments 2.4e1 -weave_fibres 4.0,4 -damping_local .30 -ts_dt 1e1 -pair_exclude 12 "
      "-vdw_splice kink -break_strain_mean 0.3 -energy_alarm 0.9 -progress_interval 0 -vdw_a "
      "0.02230 -vdw_beta 4 -scene weave ";
  for (int ranks : {1, 2, 3}) {
    SCOPED_TRACE(ranks);
    const Folder own;
    expectDone(run(own,
                   options +
                       "-ts_max_steps 4 -checkpoint_file c.h5 -state_output out.h5 -snapshot_file "
                       "sn -snapshot_interval 4 -partition dmda",
                   ranks));
    for (const auto& [file, purpose] :
         {std::pair("c.h5", "checkpoint"), {"out.h5", "final"}, {"sn_0000000004.h5", "snapshot"}}) {
      SCOPED_TRACE(file);
      EXPECT_EQ(textOf(own / file, "options"), text);
      EXPECT_EQ(textOf(own / file, "purpose"), purpose);
      EXPECT_EQ(textOf(own / file, "program"), "nanoweft");
      EXPECT_EQ(textOf(own / file, "version"), NANOWEFT_VERSION);
      EXPECT_EQ(textOf(own / file, "input"), "");
    }
    expectDone(run(own, "-restart c.h5 -ts_max_steps 8 -progress_interval 0 -state_output two.h5",
                   4 - ranks));
    EXPECT_EQ(textOf(own / "two.h5", "options"), text);
  }
}

TEST(ProvenanceOfFiles, NamesGroupsAndTheFileThatTheRunStartedFromByItsDigest) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({}, {1, 0, 0}, 12)});
  const std::string digest = sha256OfFile(folder / "in.h5");
  expectDone(run(folder,
                 "-scene file -scene_file in.h5 -bc root,tip -root_region -1,-1,-1,1,1,1 "
                 "-root_fix yes,1,on -root_fix_rotation -tip_region 140,-1,-1,160,1,1 -tip_force "
                 "0,0,1e-3 -tip_ramp 0 -ts_max_steps 4 -checkpoint_file c.h5",
                 2));
  EXPECT_EQ(textOf(folder / "c.h5", "options"),
            "-bc root,tip\n-root_fix 1,1,1\n-root_fix_rotation true\n-root_region -1,-1,-1,1,1,1\n"
            "-scene file\n-seed 1\n-tip_force 0,0,0.001\n-tip_region 140,-1,-1,160,1,1\n");
  EXPECT_EQ(textOf(folder / "c.h5", "input"), digest);
  // The restart keeps it, whether the file is there or not, and refuses another.
  const std::string on = "-restart c.h5 -ts_max_steps 6 -state_output out.h5 ";
  expectDone(run(folder, on));
  EXPECT_EQ(textOf(folder / "out.h5", "input"), digest);
  expectDone(run(folder, on + "-scene file -scene_file in.h5", 3));
  writeState(folder / "other.h5", {straightFibre({}, {1, 0, 0}, 13)});
  expectRefused(run(folder, on + "-scene file -scene_file other.h5", 3),
                {"-scene_file other.h5", "c.h5 was made from another file"});
  std::filesystem::remove(folder / "in.h5");
  expectDone(run(folder, on + "-scene file -scene_file in.h5"));
  EXPECT_EQ(textOf(folder / "out.h5", "input"), digest);
}

TEST(ProvenanceOfFiles, NamesTheTextThatFibresWereLaidAlongByItsDigest) {
  const Folder folder;
  writeText(folder / "a.txt", "0 0 0\n200 0 0\n");
  writeText(folder / "b.txt", "0 0 0\n300 0 0\n");
  const std::string text = "-scene text -ts_max_steps 2 -progress_interval 0 -text_file ";
  expectDone(run(folder, text + "a.txt -checkpoint_file c.h5 -state_output out.h5"));
  const std::string digest = textOf(folder / "out.h5", "input");
  EXPECT_EQ(digest.size(), 64u) << digest;
  const std::string kept = readFile(folder / "out.h5");
  expectRefused(run(folder, text + "b.txt -state_output out.h5", 2),
                {"will not replace out.h5", "another file"});
  EXPECT_TRUE(readFile(folder / "out.h5") == kept);
  const std::string on = "-restart c.h5 -ts_max_steps 4 -progress_interval 0 ";
  expectDone(run(folder, on + "-scene text -text_file a.txt", 2));
  expectRefused(run(folder, on + "-scene text -text_file b.txt", 2),
                {"-text_file b.txt", "made from another file"});
  expectDone(run(folder, on + "-state_output on.h5"));
  EXPECT_EQ(textOf(folder / "on.h5", "input"), digest);
}

// Options of a restart

TEST_P(RestartRules, OptionsComeFromTheCheckpoint) {
  const Folder whole, pieces;
  const std::string options = pulled +
                              "-units nano -break_strain_mean 0.1 -seed 7 -scene_perturb 0.2 "
                              "-pair_points 4 -vdw_epsilon 0.08 -ts_dt 12 -domain_upper "
                              "900,900,900 ";
  expectDone(go(whole, options + table + "-ts_max_steps 60 -state_output out.h5"));
  expectDone(go(pieces, options + table + "-ts_max_steps 30 -checkpoint_file c.h5"));
  expectDone(go(
      pieces, "-restart c.h5 -progress_interval 0 -ts_max_steps 60 -state_output out.h5 " + table));
  EXPECT_TRUE(readFile(pieces / "out.h5") == readFile(whole / "out.h5"));
  EXPECT_EQ(readFile(pieces / "s.csv"), readFile(whole / "s.csv"));
}

TEST_P(RestartRules, OptionsThatContradictTheCheckpointAreRefused) {
  const Folder folder;
  expectDone(go(folder, pulled + table + "-ts_max_steps 20 -checkpoint_file c.h5"));
  const std::string rows = readFile(folder / "s.csv"), kept = readFile(folder / "c.h5");
  const struct {
    const char *given, *was;
  } cases[] = {
      {"-tension_rate 1e-6", "with 4e-6"},
      {"-tension_axis y", "with its default, x"},
      {"-tension_grip 80", "with 40"},
      {"-tension_width 1000", "with its default, measured at the start"},
      {"-tension_ramp 400", "with 500"},
      {"-domain_upper 5000,5000,5000", "with its default, of the scene"},
      {"-domain_periodic 1,0,0", "with its default, of the scene"},
      {"-scene_perturb 5", "with its default, 0"},
      {"-vdw_epsilon 0.5", "with its default, 0.07124"},
      {"-pair none", "with its default, vdw"},
      {"-pair_points 5", "with its default, "},
      {"-damping_local 0.4", "with 0.3"},
      {"-damping_viscous 3", "with its default, 0"},
      {"-break_strain_mean 0.2", "with its default, of the preset"},
      {"-seed 2", "with 1"},
      {"-units si", "with its default, nano"},
      {"-fibre_young 1000", "with its default, of the preset"},
      {"-weave_fibres 4,6", "with 4,4"},
      {"-weave_periodic", "with its default, false"},
      {"-relax_method fire", "with its default, dynamics"},
      {"-bc edge", "without it"},
      {"-scene fibre", "with its default, weave"},
  };
  // On several ranks every fourth, since they take the same way.
  for (std::size_t k = 0; k<std::size(cases); k += GetParam()> 1 ? 4 : 1) {
    const auto& c = cases[k];
    SCOPED_TRACE(c.given);
    const std::string option = std::string(c.given).substr(0, std::string(c.given).find(' '));
    expectRefused(go(folder, "-restart c.h5 -ts_max_steps 30 " + table + c.given),
                  {option, std::string("the checkpoint c.h5 was made ") + c.was,
                   "-scene file -scene_file c.h5"});
  }
  // The whole command once more, but for one number.
  expectRefused(go(folder, weave + table +
                               "-damping_local 0.3 -tension_rate 4.1e-6 -tension_ramp 500 "
                               "-tension_grip 40 -restart c.h5 -ts_max_steps 30"),
                {"-tension_rate 4.1e-6", "with 4e-6"});
  EXPECT_EQ(readFile(folder / "s.csv"), rows);
  EXPECT_TRUE(readFile(folder / "c.h5") == kept);
}

TEST_P(RestartRules, TheSameValuesInAnotherSpellingAgree) {
  const Folder folder;
  expectDone(go(folder, pulled + "-ts_max_steps 20 -checkpoint_file c.h5 -state_output a.h5"));
  expectDone(go(folder,
                "-restart c.h5 -scene weave -weave_fibres 4.0,4 -weave_segments 2.4e1 "
                "-damping_local .3 -tension_rate 0.000004 -tension_ramp 5e2 -tension_grip 40.0 "
                "-tension_axis x -seed 1.0 -weave_periodic no -vdw_epsilon 0.071240 -units nano "
                "-ts_max_steps 20 -state_output b.h5"));
  EXPECT_TRUE(readFile(folder / "a.h5") == readFile(folder / "b.h5"));
}

TEST_P(RestartRules, EndsOutputsAndWaysOfWorkingMayChange) {
  const Folder folder;
  const std::string first = pulled +
                            "-ts_max_steps 20 -checkpoint_file c.h5 "
                            "-snapshot_file sn -snapshot_interval 10 ";
  expectDone(go(folder, first));
  expectDone(go(folder, pulled + "-ts_max_steps 50 -state_output want.h5"));
  expectDone(go(folder,
                "-restart c.h5 -ts_max_steps 50 -ts_max_time 1e9 "
                "-tension_max_strain 0.4 -state_output out.h5 -partition metis -partition_piece 8 "
                "-pair_skin 3 -ts_limit_interval 7 -energy_alarm 0.5 -ts_dt_unsafe "
                "-pair_allow_overlap -monitor_interval 5 -energy_monitor ascii:e.csv "
                "-snapshot_file more -snapshot_interval 15 -checkpoint_file d.h5 "
                "-checkpoint_interval 20 -progress_interval 1 -overwrite"));
  for (const char* set : {"state/position", "state/orientation", "state/velocity", "state/group"})
    EXPECT_EQ(readDataset(folder / "out.h5", set), readDataset(folder / "want.h5", set)) << set;
  EXPECT_EQ(textOf(folder / "out.h5", "options"), textOf(folder / "want.h5", "options"));
}

TEST_P(RestartRules, TheThicknessOfAHeldBoxStaysWithAndWithoutItsMonitor) {
  const Folder folder;
  const std::string box =
      "-scene weave -weave_periodic -weave_fibres 4,4 -weave_segments 24 -progress_interval 0 ";
  expectDone(go(folder, box + "-deform_thickness 17 -box_monitor ascii:b.csv -ts_max_steps 4 "
                              "-checkpoint_file c.h5"));
  expectDone(go(folder, "-restart c.h5 -progress_interval 0 -ts_max_steps 8"));
  expectDone(go(folder,
                "-restart c.h5 -progress_interval 0 -ts_max_steps 8 -deform_thickness 17 "
                "-box_monitor ascii:b.csv"));
}

TEST_P(RestartRules, AnotherTimeStepIsSaidAndRecorded) {
  const Folder folder;
  expectDone(go(folder, pulled + "-ts_max_steps 20 -checkpoint_file c.h5"));
  auto outcome = go(folder, "-restart c.h5 -ts_max_steps 22 -ts_dt 10 -checkpoint_file d.h5");
  expectDone(outcome);
  EXPECT_TRUE(says(outcome, "time step changed from 20 to 10 fs at this restart"))
      << outcome.output;
  EXPECT_NE(textOf(folder / "d.h5", "options").find("-ts_dt 10\n"), std::string::npos);
  EXPECT_EQ(realsOf(folder / "d.h5", "time_step"), std::vector<double>{10});
  // From then on it is the step; the same again is no change.
  for (const char* step : {"", " -ts_dt 1e1"}) {
    outcome = go(folder, "-restart d.h5 -ts_max_steps 24 -state_output e.h5" + std::string(step));
    expectDone(outcome);
    EXPECT_FALSE(says(outcome, "notice")) << outcome.output;
    EXPECT_EQ(realsOf(folder / "e.h5", "time_step"), std::vector<double>{10});
  }
  outcome = go(folder, "-restart c.h5 -ts_max_steps 22 -ts_dt 20.0 -state_output f.h5");
  expectDone(outcome);
  EXPECT_FALSE(says(outcome, "notice")) << outcome.output;
  EXPECT_EQ(textOf(folder / "f.h5", "options"), textOf(folder / "c.h5", "options"));
}

TEST_P(RestartRules, FiresLongestStepMayChange) {
  const Folder folder;
  expectDone(
      go(folder, weave + "-relax_method fire -ts_dt 20 -ts_max_steps 40 -checkpoint_file c.h5"));
  for (const double longest : {10.0, 25.0}) {
    const auto outcome =
        go(folder, "-restart c.h5 -ts_max_steps 60 -overwrite -state_output out.h5 -ts_dt " +
                       std::to_string(longest));
    expectDone(outcome);
    EXPECT_TRUE(says(outcome, "time step changed from 20")) << outcome.output;
    EXPECT_EQ(realsOf(folder / "out.h5", "fire").at(1), longest);
  }
}

// What is no checkpoint

TEST_P(RestartRules, SnapshotsFinalStatesAndStatesMadeByHandAreNoCheckpoints) {
  const Folder folder;
  expectDone(go(folder, weave + "-ts_max_steps 4 -state_output out.h5 -snapshot_file sn"));
  writeState(folder / "hand.h5", {straightFibre({}, {1, 0, 0}, 12)});
  const struct {
    const char *file, *what;
  } cases[] = {{"sn_0000000000.h5", "no checkpoint but a snapshot"},
               {"out.h5", "no checkpoint but a final state"},
               {"hand.h5", "no checkpoint: it holds a state alone"}};
  for (const auto& c : cases)
    expectRefused(go(folder, weave + "-ts_max_steps 8 -restart " + c.file),
                  {std::string("-restart ") + c.file, c.what,
                   std::string("-scene file -scene_file ") + c.file});
}

/// A copy of a checkpoint with one thing taken out, signed as if it were whole.
void takeOut(const Folder& folder, const std::string& part) {
  copy(folder, "c.h5", "x.h5");
  const std::string file = folder / "x.h5", name = part.substr(part.find('/') + 1);
  {
    h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    const std::string place = "/" + part.substr(0, part.find('/'));
    h5::Handle group(H5Gopen2(f, place.c_str(), H5P_DEFAULT), H5Gclose);
    const bool attribute = H5Aexists(group, name.c_str()) > 0;
    ASSERT_GE(
        attribute ? H5Adelete(group, name.c_str()) : H5Ldelete(group, name.c_str(), H5P_DEFAULT), 0)
        << part;
  }
  const int descriptor = ::open(file.c_str(), O_RDWR);
  ASSERT_EQ(signFile(descriptor), 0);
  ::close(descriptor);
}

TEST_P(RestartRules, ACheckpointWithoutOneOfItsPartsIsRefused) {
  const Folder folder;
  expectDone(go(folder, pulled + "-break_strain_mean 0.3 -damping_viscous 0.01 -bc edge "
                                 "-edge_region -1000,-1000,-1000,1000,1000,1000 -edge_force "
                                 "0,0,1e-5 -temperature 300 -temperature_damping 1e-3 "
                                 "-ts_max_steps 20 -checkpoint_file c.h5"));
  const char* parts[] = {"state/velocity",       "state/angular_velocity",
                         "state/group",          "state/bond_broken",
                         "state/viscous",        "state/gap",
                         "state/image",          "state/step",
                         "state/time",           "run/account_damped",
                         "run/account_external", "run/account_broken",
                         "run/relax_elastic",    "run/tension",
                         "run/tension_strain",   "run/tension_axis",
                         "run/tension_grip",     "run/tension_thickness",
                         "run/tension_ends",     "run/tension_strength",
                         "run/boundary_edge",    "run/fibre",
                         "run/time_step",        "run/options",
                         "run/purpose",          "run/account_heat"};
  // On several ranks every fourth, since they take the same way.
  for (std::size_t k = 0; k<std::size(parts); k += GetParam()> 1 ? 4 : 1) {
    const char* part = parts[k];
    SCOPED_TRACE(part);
    takeOut(folder, part);
    const std::string name = std::string(part).substr(std::string(part).find('/') + 1);
    expectRefused(go(folder, "-restart x.h5 -ts_max_steps 30"),
                  {"x.h5", name == "options" || name == "purpose" ? "older version" : name});
  }
  expectDone(go(folder, "-restart c.h5 -ts_max_steps 30"));
}

TEST_P(RestartRules, SoDoWallsBoxesLinksAndFlowNeedTheirs) {
  const struct {
    std::string options;
    std::vector<std::string> parts;
    std::string again = {};
  } cases[] = {
      {"-weave_fibres 4,4 -weave_segments 24 -weave_periodic -damping_local 0.3 -deform_x stress "
       "-deform_x_stress 0.1 -deform_xy rate -deform_xy_rate 1e-6",
       {"run/deform", "run/deform_servo", "run/deform_shear"}},
      {"-scene fibre -fibre_segments 12 -pair none -walls floor,lid -floor_point 0,0,-6.7 "
       "-floor_axis 0,0,1 -floor_modulus 20 -floor_friction 0.3 -lid_point 0,0,6.7 -lid_axis "
       "0,0,-1 -lid_modulus 20 -lid_friction 0.3 -lid_force 0,0,-0.1 -lid_mass 20000",
       {"run/wall_floor", "run/wall_floor_felt", "run/wall_lid", "run/wall_lid_friction",
        "state/contact", "state/contact_spring", "state/viscous"}},
      {"-weave_fibres 4,4 -weave_segments 24 -damping_local 0.3 -links_density 0.005 "
       "-links_distance 22 -link_law spring -fibre_yield_strain 0.01",
       {"/link", "state/rest_extension", "state/rest_rotation"}},
      {"-weave_fibres 4,4 -weave_segments 24 -tension_rate 1e-6 -tension_grip 40 "
       "-tension_lateral -bc edge -edge_region -1000,-1000,-1000,1000,1000,1000 -edge_force "
       "0,0,1e-5 -group_monitor ascii:g.csv",
       {"run/tension_lateral", "run/account_groups"},
       "-group_monitor ascii:g.csv "}};
  for (const auto& [options, parts, again] : cases) {
    const std::string restart = again + "-overwrite -ts_max_steps 30 -restart ";
    const Folder folder;
    expectDone(go(folder, options + " -ts_max_steps 20 -checkpoint_file c.h5"));
    // On several ranks the first only, since they take the same way.
    for (std::size_t k = 0; k < (GetParam() > 1 ? 1 : parts.size()); ++k) {
      SCOPED_TRACE(parts[k]);
      takeOut(folder, parts[k]);
      expectRefused(go(folder, restart + "x.h5"),
                    {"x.h5", parts[k].substr(parts[k].find('/') + 1)});
    }
    expectDone(go(folder, restart + "c.h5"));
  }
}

TEST_P(RestartRules, FiresStateIsPartOfItsCheckpoint) {
  const Folder folder;
  expectDone(go(folder, weave + "-relax_method fire -ts_max_steps 20 -checkpoint_file c.h5"));
  for (const char* part : {"run/fire", "run/fire_downhill"}) {
    takeOut(folder, part);
    expectRefused(go(folder, "-restart x.h5 -ts_max_steps 30"), {"x.h5", "fire"});
  }
}

// Runs that are over

TEST_P(RestartRules, ARunThatHadConvergedIsOver) {
  const Folder folder;
  const std::string options = weave + "-damping_local 0.7 -ts_max_steps 4000 -relax_interval 50 ";
  const std::string out = "-energy_monitor ascii:e.csv -monitor_interval 100 -state_output out.h5 ";
  for (const std::string end : {"-relax_tolerance 0.2 ", "-relax_force 0.3 "}) {
    SCOPED_TRACE(end);
    const std::string relax =
        end[7] == 't' ? options : weave + "-damping_local 0.7 -ts_max_steps 4000 ";
    expectDone(go(folder, relax + end + out + "-checkpoint_file c.h5 -overwrite"));
    const std::string rows = readFile(folder / "e.csv"), state = readFile(folder / "out.h5");
    std::filesystem::remove(folder / "out.h5");
    const auto again = go(folder, relax + end + out + "-restart c.h5");
    expectDone(again);
    EXPECT_TRUE(says(again, "nothing to do: the run of c.h5 had converged at step"))
        << again.output;
    EXPECT_EQ(readFile(folder / "e.csv"), rows);
    EXPECT_TRUE(readFile(folder / "out.h5") == state);
    // With less tolerance it goes on.
    const std::string finer = end[7] == 't' ? "-relax_tolerance 1e-3 " : "-relax_force 0.1 ";
    copy(folder, "e.csv", "f.csv");
    const auto further =
        go(folder, relax + finer +
                       "-restart c.h5 -energy_monitor ascii:f.csv "
                       "-monitor_interval 100 -state_output further.h5 -overwrite");
    expectDone(further);
    EXPECT_FALSE(says(further, "nothing to do")) << further.output;
    EXPECT_GT(readCsv(folder / "f.csv")["step"].back(), readCsv(folder / "e.csv")["step"].back());
  }
}

TEST_P(RestartRules, ATensionTestThatHadReachedItsStrainIsOver) {
  const Folder folder;
  const std::string options = weave +
                              "-damping_local 0.3 -tension_rate 2e-5 -tension_ramp 200 "
                              "-tension_grip 40 -tension_max_strain 0.02 -state_output out.h5 " +
                              table;
  expectDone(go(folder, options + "-checkpoint_file c.h5"));
  const std::string rows = readFile(folder / "s.csv"), state = readFile(folder / "out.h5");
  const auto again = go(folder, options + "-restart c.h5");
  expectDone(again);
  EXPECT_TRUE(says(again, "nothing to do: the run of c.h5 had reached a strain of 0.02"))
      << again.output;
  EXPECT_EQ(readFile(folder / "s.csv"), rows);
  EXPECT_TRUE(readFile(folder / "out.h5") == state);
}

TEST_P(RestartRules, TheClosingRowOfARunAtItsEndIsKept) {
  const Folder folder;
  const std::string options = weave +
                              "-damping_local 0.3 -ts_max_steps 57 -energy_monitor ascii:e.csv "
                              "-monitor_interval 10 -checkpoint_file c.h5 -state_output f.h5 ";
  expectDone(go(folder, options));
  const std::string rows = readFile(folder / "e.csv");
  std::filesystem::remove(folder / "f.h5");
  expectDone(go(folder, options + "-restart c.h5"));
  EXPECT_EQ(readFile(folder / "e.csv"), rows);
}

// Tension across stages

TEST_P(RestartRules, ATensionTestGoesOnInANewStage) {
  const Folder folder;
  expectDone(go(folder, pulled + table + "-ts_max_steps 500 -state_output one.h5"));
  const auto first = readCsv(folder / "s.csv");
  const double reached = first.at("strain").back(), gage = realsOf(folder / "one.h5", "tension")[1];
  EXPECT_NEAR(reached, 4e-6 * (500 * 20 - 250), 1e-12);
  EXPECT_EQ(realsOf(folder / "one.h5", "tension_strain"), (std::vector<double>{0, reached}));

  const std::string second =
      "-scene file -scene_file one.h5 -damping_local 0.3 -progress_interval 0 -tension_rate 8e-6 "
      "-tension_ramp 400 -monitor_interval 10 -stress_monitor ascii:t.csv ";
  const auto outcome = go(folder, second + "-ts_max_steps 100 -state_output two.h5");
  expectDone(outcome);
  EXPECT_TRUE(says(outcome, "tension goes on from strain 0.039 of an earlier stage: gage"))
      << outcome.output;
  const auto rows = readCsv(folder / "t.csv");
  EXPECT_EQ(rows.at("strain").front(), reached);
  EXPECT_EQ(rows.at("stress_left_GPa").front(), first.at("stress_left_GPa").back());
  // From rest, by the new ramp, to the new rate.
  EXPECT_NEAR(rows.at("strain").at(1), reached + 8e-6 * 200 * 200 / 800, 1e-14);
  EXPECT_NEAR(rows.at("strain").back(), reached + 8e-6 * (2000 - 200), 1e-12);
  const auto tension = realsOf(folder / "two.h5", "tension");
  EXPECT_EQ(tension[1], gage);
  EXPECT_EQ(tension[2], realsOf(folder / "one.h5", "tension")[2]);
  // The same members; the grips have moved apart by the strain of this stage.
  const auto one = readDataset(folder / "one.h5", "state/group"),
             two = readDataset(folder / "two.h5", "state/group");
  EXPECT_EQ(one, two);
  const auto x1 = readDataset(folder / "one.h5", "state/position"),
             x2 = readDataset(folder / "two.h5", "state/position");
  for (std::size_t i = 0; i < one.size(); ++i)
    if (static_cast<int>(one[i]) >> 29 & 1) {
      EXPECT_NEAR(x2[3 * i] - x1[3 * i], 0.5 * gage * (rows.at("strain").back() - reached), 1e-9);
    }
  // A second stage in pieces is the second stage.
  expectDone(go(folder, second + "-ts_max_steps 50 -checkpoint_file c.h5 -overwrite"));
  expectDone(go(folder,
                "-restart c.h5 -progress_interval 0 -monitor_interval 10 -stress_monitor "
                "ascii:t.csv -ts_max_steps 100 -state_output again.h5"));
  EXPECT_TRUE(readFile(folder / "again.h5") == readFile(folder / "two.h5"));
}

TEST_P(RestartRules, AStageThatContradictsItsTensionTestIsRefused) {
  const Folder folder;
  expectDone(go(folder, pulled + "-ts_max_steps 50 -state_output one.h5 -tension_max_strain 0.1"));
  const std::string stage =
      "-scene file -scene_file one.h5 -tension_rate 4e-6 -ts_max_steps 10 -state_output two.h5 ";
  for (const auto& [given, old] : {std::pair("-tension_axis y", "with x"),
                                   {"-tension_grip 80", "with 40"},
                                   {"-tension_width 1000", "with 3"},
                                   {"-tension_thickness 20", "with 17.1"},
                                   {"-tension_ends 0,300", "with "}})
    expectRefused(go(folder, stage + given),
                  {given, "one.h5 carries a tension test", old, "-tension_new"});
  expectRefused(go(folder, stage + "-domain_periodic 1,0,0 -domain_lower -2000,-2000,-2000 "
                                   "-domain_upper 2000,2000,2000"),
                {"-tension_axis x", "periodic"});
  expectRefused(go(folder, stage + "-tension_max_strain 0.002"),
                {"-tension_max_strain 0.002", "one.h5", "-tension_new"});
  EXPECT_FALSE(std::filesystem::exists(folder / "two.h5"));
  // The same again is no contradiction, and a test of its own starts at no strain.
  expectDone(go(folder, stage + "-tension_axis x -tension_grip 4e1"));
  EXPECT_GT(realsOf(folder / "two.h5", "tension_strain")[0], 0.0);
  expectDone(go(folder, stage + "-tension_axis y -tension_grip 80 -tension_new -overwrite"));
  EXPECT_EQ(realsOf(folder / "two.h5", "tension_strain")[0], 0.0);
  EXPECT_EQ(realsOf(folder / "two.h5", "tension_grip")[0], 80.0);
}

TEST_P(RestartRules, StrengthIsThatOfTheWholeTest) {
  const Folder folder;
  expectDone(
      go(folder, pulled + "-break_strain_mean 0.02 -ts_max_steps 1000 -state_output one.h5"));
  const double strength = realsOf(folder / "one.h5", "tension_strength")[0];
  EXPECT_GT(strength, 0.0);
  expectDone(go(folder,
                "-scene file -scene_file one.h5 -tension_rate 4e-6 -ts_max_steps 0 -state_output "
                "two.h5"));
  EXPECT_GE(realsOf(folder / "two.h5", "tension_strength")[0], strength);
}

}  // namespace
