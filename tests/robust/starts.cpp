/// Starts that cannot be meant, as people make them: refused with the cause; what is meant passes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

using namespace nanoweft;
using namespace nanoweft::test;

namespace {

constexpr double T = 13.56, pi = std::numbers::pi;

const std::string start = "-scene file -scene_file in.h5 -progress_interval 0 ";

void expectSilent(const Outcome& outcome) {
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("warning"), std::string::npos) << outcome.output;
}

std::size_t warnings(const Outcome& outcome) {
  std::size_t count = 0;
  for (auto at = outcome.output.find("warning"); at != std::string::npos;
       at = outcome.output.find("warning", at + 1))
    ++count;
  return count;
}

/// Gives each segment its image, three whole numbers.
void setImages(const std::string& file, const std::vector<std::int32_t>& images) {
  const hsize_t shape[2] = {images.size() / 3, 3};
  h5::Handle h(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  h5::Handle space(H5Screate_simple(2, shape, nullptr), H5Sclose);
  h5::Handle set(
      H5Dcreate2(h, "/state/image", H5T_NATIVE_INT32, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  H5Dwrite(set, H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, images.data());
}

/// A straight fibre whose spacing is not T.
FibreInput spaced(double spacing, int segments = 30) {
  FibreInput f = straightFibre({0, 0, 0}, {1, 0, 0}, segments);
  for (std::size_t k = 0; k < f.position.size(); ++k)
    f.position[k].x = static_cast<double>(k) * spacing;
  return f;
}

/// A straight fibre along y with other orientations.
FibreInput turned(const Quatd& q) {
  FibreInput f = straightFibre({0, 0, 0}, {0, 1, 0}, 30);
  std::ranges::fill(f.orientation, q);
  return f;
}

/// A closed circle in the x, y plane; `twist` is added from the middle of the fibre on.
FibreInput ring(int segments, double twist = 0) {
  FibreInput f;
  f.closed = true;
  const double radius = 0.5 * T / std::sin(pi / segments);
  for (int k = 0; k < segments; ++k) {
    const double angle = 2 * pi * k / segments;
    f.position.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    const Quatd along = rotation({0, 0, angle + 0.5 * pi});
    f.orientation.push_back(2 * k < segments ? along : along * rotation({twist, 0, 0}));
  }
  return f;
}

struct Start {
  std::string name;
  std::vector<FibreInput> fibres;
  std::vector<std::string> fragments;
};

const double half = std::sqrt(0.5);

const std::vector<Start> refused = {
    {"Nanometres", {spaced(0.1 * T)}, {"strain -90 %", "29 of 29", "T/10 apart", "nm"}},
    {"TenTimesTooFar", {spaced(10 * T)}, {"strain +900 %", "10 T apart", "twice"}},
    {"Metres", {spaced(1e-10 * T)}, {"strain -100 %", "in m?"}},
    {"OtherSegmentLength", {spaced(20.34)}, {"+50 %", "-fibre_segment_length 20.34"}},
    {"OtherSegmentLengthShorter", {spaced(6.78)}, {"-50 %", "-fibre_segment_length 6.78"}},
    {"OneGap",
     {[] {
       FibreInput f = spaced(T);
       for (std::size_t k = 12; k < f.position.size(); ++k) f.position[k].x += 3;
       return f;
     }()},
     {"fibre 0, segments 11 and 12", "strain +22 %", "1 of 29 bonds is", "order of index"}},
    {"ScalarLast", {turned({0, 0, half, half})}, {"look like x, y, z, w", "w, x, y, z"}},
    {"ScalarLastAlongX",
     {[] {
       FibreInput f = spaced(T);
       std::ranges::fill(f.orientation, Quatd{0, 0, 0, 1});
       return f;
     }()},
     {"against the chain", "x, y, z, w", "index the fibre the other way"}},
    {"AgainstTheChain", {turned({half, 0, 0, -half})}, {"180 degrees", "against the chain"}},
    {"OneFibreAgainstTheChain",
     {spaced(T), spaced(T),
      [] {
        FibreInput f = straightFibre({0, 40, 0}, {1, 0, 0}, 30);
        std::ranges::reverse(f.position);
        return f;
      }()},
     {"fibre 2, segments", "29 of 87", "against the chain"}},
    {"BodyZ", {turned({half, -half, 0, 0})}, {"90 degrees", "body z axis runs along the chain"}},
    {"NoOrientation", {turned({1, 0, 0, 0})}, {"90 degrees", "body x axis"}},
    {"SpaceToBody",
     {[] {
       // Along (1, 1, 1).
       const double c = std::sqrt(1.0 / 3), w = std::sqrt(0.5 * (1 + c)), s = 0.5 * c / w;
       FibreInput f = straightFibre({0, 0, 0}, {1, 1, 1}, 30);
       std::ranges::fill(f.orientation, Quatd{w, 0, s, -s});
       return f;
     }()},
     {"from space to body"}},
    {"Slanted",
     {turned(rotation({0, 0, 0.5 * pi + 0.14}))},
     {"sheared 8.02 degrees", "shear holds"}},
    {"TwistInOneBondOfARing", {ring(40, 0.5 * pi)}, {"twisted by 90 degrees", "distribute"}},
    {"SmallTwistInOneBondOfARing", {ring(40, 0.25)}, {"twisted by 14.3 degrees", "distribute"}},
    {"TwistInOneBond",
     {[] {
       FibreInput f = spaced(T);
       for (std::size_t k = 10; k < 30; ++k) f.orientation[k] = rotation({1.5, 0, 0});
       return f;
     }()},
     {"segments 9 and 10", "twisted by 85.9 degrees", "one frame along the fibre"}},
    {"OpenFibreClosed",
     {spaced(T),
      [] {
        FibreInput f = straightFibre({0, 40, 0}, {1, 0, 0}, 20);
        f.closed = true;
        return f;
      }()},
     {"fibre 1, segments 19 and 0", "does not lie beside its first", "fibre_closed"}},
};

class Starts : public testing::TestWithParam<std::tuple<Start, int>> {};

TEST(Starts, NamesThatNobodyReadsAreWarnedOf) {
  const Folder folder;
  const std::string file = folder / "in.h5";
  const auto fibres = {straightFibre({0, 0, 0}, {1, 0, 0}, 10),
                       straightFibre({0, 20, 0}, {1, 0, 0}, 10)};
  const std::string options = start + "-pair none -ts_max_steps 1";
  writeState(file, fibres);
  setLinks(file, {{0, 3, 1, 3}});
  setDataset(file, "velocity", std::vector<double>(60, 1e-6), 3);
  expectSilent(run(folder, options));
  setDataset(file, "velocities", std::vector<double>(60, 1e-6), 3);
  setDataset(file, "/link/rest_lenght", {10.0}, 1);
  for (const int ranks : {1, 3}) {
    const Outcome outcome = run(folder, options, ranks);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(warnings(outcome), 2) << outcome.output;
    for (const char* said : {"in /state of the state file nobody reads velocities; known are ",
                             "in /link of the state file nobody reads rest_lenght; known are "})
      EXPECT_NE(outcome.output.find(said), std::string::npos) << outcome.output;
  }
}

TEST(Starts, ImagesThatTearFibresAreWarnedOf) {
  const Folder folder;
  BoxInput box;
  box.lower = {0, 0, -100};
  box.upper = {200, 200, 100};
  box.periodic = {true, false, false};
  FibreInput fibre = straightFibre({150, 50, 0}, {1, 0, 0}, 9);
  for (Vec3d& x : fibre.position) x.x -= x.x > 200 ? 200 : 0;
  // The last five segments lie in the next image; one of them may say that it does not.
  auto imagesWith = [](int at) {
    std::vector<std::int32_t> images(27, 0);
    for (std::size_t k = 4; k < 9; ++k) images[3 * k] = 1;
    if (at >= 0) images[3 * static_cast<std::size_t>(at)] = 0;
    return images;
  };
  for (const int ranks : {1, 3})
    for (const auto& [at, torn] : {std::pair{-1, 0}, std::pair{8, 1}, std::pair{6, 2}}) {
      writeState(folder / "in.h5", {fibre}, box);
      setImages(folder / "in.h5", imagesWith(at));
      const Outcome outcome = run(folder, start + "-pair none -ts_max_steps 1", ranks);
      if (torn == 0) {
        expectSilent(outcome);
        continue;
      }
      EXPECT_NE(
          outcome.output.find(nanoweft::format("tears %d bonds of fibres (fibre 0 first)", torn)),
          std::string::npos)
          << outcome.output;
    }
}

TEST_P(Starts, ThatCannotBeMeantAreRefusedWithTheCause) {
  const auto& [c, ranks] = GetParam();
  const Folder folder;
  writeState(folder / "in.h5", c.fibres);
  auto fragments = c.fragments;
  fragments.push_back("-start_unchecked");
  expectRefused(run(folder, start + "-pair none -ts_max_steps 2", ranks), fragments);
}

INSTANTIATE_TEST_SUITE_P(Robust, Starts,
                         testing::Combine(testing::ValuesIn(refused), testing::Values(1, 3)),
                         [](const testing::TestParamInfo<Starts::ParamType>& info) {
                           return std::get<0>(info.param).name + "On" +
                                  std::to_string(std::get<1>(info.param));
                         });

TEST(StartCheck, SaysTheSameOnAnyNumberOfRanks) {
  for (const Start& c : {refused[5], refused[9], refused[14], refused[17]}) {
    const Folder folder;
    writeState(folder / "in.h5", c.fibres);
    const std::string options = start + "-pair none -ts_max_steps 2";
    const std::string alone = run(folder, options, 1).output;
    for (const int ranks : {2, 5}) EXPECT_EQ(run(folder, options, ranks).output, alone);
  }
}

TEST(StartCheck, UncheckedStartsRunWithAWarning) {
  const Folder folder;
  writeState(folder / "in.h5", {spaced(1.08 * T, 12)});
  const Outcome outcome = run(folder, start + "-pair none -ts_max_steps 2 -start_unchecked");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(warnings(outcome), 1u) << outcome.output;
  EXPECT_NE(outcome.output.find("strain +8.0 %"), std::string::npos) << outcome.output;
}

TEST(StartCheck, AnEvaluationTakesWhatItIsGivenAndWarns) {
  const Folder folder;
  writeState(folder / "in.h5", {spaced(1.5 * T, 12)});
  const Outcome outcome =
      run(folder, start + "-pair none -ts_max_steps 0 -energy_monitor ascii:e.csv", 3);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(warnings(outcome), 1u) << outcome.output;
  EXPECT_NE(outcome.output.find("strain +50 %"), std::string::npos) << outcome.output;
  // B1/2 (T/2)^2 for each of 11 bonds.
  EXPECT_NEAR(readCsv(folder / "e.csv")["stretch"][0], 11 * 0.5 * 67.59 * 6.78 * 6.78, 2);
}

TEST(StartCheck, BetweenOneAndFivePercentItWarnsOnce) {
  const Folder folder;
  writeState(folder / "in.h5", {spaced(1.03 * T, 12), straightFibre({0, 40, 0}, {1, 0, 0}, 12)});
  const Outcome outcome = run(folder, start + "-ts_max_steps 1", 3);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(warnings(outcome), 1u) << outcome.output;
  EXPECT_NE(outcome.output.find("strain +3.0 %); 11 of 22 bonds are beyond 1 %"), std::string::npos)
      << outcome.output;
}

TEST(StartCheck, FilesThatAreMeantPassWithoutAWord) {
  const Folder folder;
  writeState(folder / "in.h5",
             {ring(40), straightFibre({300, 300, 300}, {3, -1, 2}, 30), spaced(1.005 * T, 4)});
  expectSilent(run(folder, start + "-pair_allow_overlap -ts_max_steps 0", 2));
}

TEST(StartCheck, WhatAnOptionAsksForPassesWithoutAWord) {
  const Folder folder;
  const std::string fibre = "-scene fibre -pair none -ts_max_steps 0 -fibre_segments 12 ";
  for (const char* wish :
       {"-fibre_strain 0.3", "-fibre_twist 20", "-fibre_bend 9", "-fibre_strain -0.2",
        "-fibre_closed -fibre_bend 6.283185307179586",
        "-fibre_closed -fibre_strain 0.1 -domain_lower 0,-90,-90 -domain_upper 178.992,90,90 "
        "-domain_periodic 1,0,0"})
    expectSilent(run(folder, fibre + wish));
  for (const char* weave :
       {"-weave_fibres 4,4 -weave_segments 24", "-weave_fibres 6,6 -weave_segments 18",
        "-weave_periodic -weave_fibres 4,4 -weave_segments 44"})
    expectSilent(run(folder, std::string("-scene weave -ts_max_steps 0 ") + weave));
}

TEST(StartCheck, AStraightFibreDoesNotClose) {
  const Folder folder;
  expectRefused(run(folder, "-scene fibre -fibre_closed -fibre_segments 60 -ts_max_steps 5"),
                {"fibre 0, segments 59 and 0", "-fibre_closed", "-fibre_bend"});
}

TEST(StartCheck, AFibreThatClosesThroughAnOpenBoundaryIsNamed) {
  const Folder folder;
  FibreInput f = spaced(T);
  f.closed = true;
  BoxInput box;
  box.lower = {0, -100, -100}, box.upper = {30 * T, 100, 100};
  writeState(folder / "in.h5", {f}, box);
  expectRefused(run(folder, start + "-pair none -ts_max_steps 2", 3),
                {"fibre 0, segments 29 and 0", "closes through the boundary along x, which is open",
                 "-domain_periodic"});
  expectSilent(run(folder, start + "-pair none -ts_max_steps 2 -domain_periodic 1,0,0"));
  // The box of another length.
  box.periodic = {true, false, false};
  writeState(folder / "in.h5", {f}, box);
  expectRefused(run(folder, start + "-pair none -ts_max_steps 2 -domain_upper 500,100,100"),
                {"segments 29 and 0", "-domain_upper"});
}

TEST(StartCheck, AMaskOfClosedFibresIsRefused) {
  const Folder folder;
  writeState(folder / "in.h5", {spaced(T, 12), spaced(T, 12), spaced(T, 12)});
  setDataset(folder / "in.h5", "fibre_closed", {0, 1, 0}, 1);
  expectRefused(run(folder, start + "-ts_max_steps 0", 3), {"fibre_closed", "mask", "ids"});
}

TEST(StartCheck, AMaskOfTrueAndFalseIsRefused) {
  const Folder folder;
  writeState(folder / "in.h5", {spaced(T, 12), spaced(T, 12)});
  {
    // As h5py writes numpy's bool.
    h5::Handle type(H5Tenum_create(H5T_STD_I8LE), H5Tclose);
    for (const std::int8_t value : {std::int8_t{0}, std::int8_t{1}})
      H5Tenum_insert(type, value ? "TRUE" : "FALSE", &value);
    h5::Handle file(H5Fopen((folder / "in.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
    const hsize_t rows = 2;
    h5::Handle space(H5Screate_simple(1, &rows, nullptr), H5Sclose);
    h5::Handle set(
        H5Dcreate2(file, "state/fibre_closed", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Dclose);
    const std::int8_t mask[2] = {0, 1};
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, mask);
  }
  expectRefused(run(folder, start + "-ts_max_steps 0"), {"fibre_closed", "True and False"});
}

/// p.h5: a periodic weave, run for a while, so that segments have crossed the boundary.
void periodicWeave(const Folder& folder) {
  ASSERT_EQ(run(folder,
                "-scene weave -weave_periodic -weave_fibres 4,4 -weave_segments 44 "
                "-scene_perturb 0.2 -ts_max_steps 100 -progress_interval 0 -state_output p.h5")
                .status,
            0);
}

TEST(StartCheck, AClosedFibreIsNotCutByOpeningItsDirection) {
  const Folder folder;
  periodicWeave(folder);
  for (const int ranks : {1, 3})
    expectRefused(run(folder,
                      "-scene file -scene_file p.h5 -domain_periodic 0,1,0 -ts_max_steps 5 "
                      "-progress_interval 0",
                      ranks),
                  {"segments 43 and 0", "boundary along x, which is open", "fibre_closed"});
  expectSilent(run(folder, "-scene file -scene_file p.h5 -ts_max_steps 5 -progress_interval 0"));
}

TEST(StartCheck, FibresOfAnOpenedDirectionAreWholeAndDrawnWhereTheyAre) {
  const Folder folder;
  periodicWeave(folder);
  const Outcome outcome = run(folder,
                              "-scene file -scene_file p.h5 -domain_periodic 0,1,0 -ts_max_steps 0 "
                              "-snapshot_file s");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto held = readVectors(folder / "s_0000000000.h5", "state/position"),
             drawn = readVectors(folder / "s_0000000000.h5", "mesh/points");
  ASSERT_EQ(held.size(), 8 * 44u);
  double largest = 0, longest = 0;
  for (std::size_t k = 0; k < held.size(); ++k) {
    largest = std::max(largest, std::abs(held[k].x - drawn[k].x));
    if (k % 44 > 0) longest = std::max(longest, std::abs(held[k].x - held[k - 1].x));
  }
  EXPECT_LT(largest, 1e-3);
  EXPECT_LT(longest, 1.1 * T);
}

TEST(StartCheck, FibresOfAnOpenedDirectionMayBeCut) {
  const Folder folder;
  periodicWeave(folder);
  // Fibres 0 to 3 run along x. What an outsider would write: the same poses and images, and the
  // bonds that closed those fibres broken.
  const auto x = readVectors(folder / "p.h5", "state/position");
  const auto q = readOrientations(folder / "p.h5");
  std::vector<FibreInput> fibres(8);
  std::vector<double> broken(x.size(), 0.0);
  for (std::size_t k = 0; k < x.size(); ++k) {
    fibres[k / 44].position.push_back(x[k]);
    fibres[k / 44].orientation.push_back(q[k]);
    if (k < 4 * 44 && k % 44 == 43) broken[k] = 1;
  }
  for (FibreInput& f : fibres) f.closed = true;
  const auto points = readDataset(folder / "p.h5", "state/image");
  BoxInput box;
  const std::string options = "-scene file -ts_max_steps 3 -progress_interval 0 -scene_file ";
  {
    h5::Handle file(H5Fopen((folder / "p.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    h5::Handle group(H5Gopen2(file, "state", H5P_DEFAULT), H5Gclose);
    const auto lower = *h5::readReals(group, "lower"), upper = *h5::readReals(group, "upper");
    std::copy_n(lower.begin(), 3, box.lower.begin());
    std::copy_n(upper.begin(), 3, box.upper.begin());
    box.periodic = {true, true, false};
  }
  writeState(folder / "cut.h5", fibres, box);
  setDataset(folder / "cut.h5", "bond_broken", broken, 1);
  setDataset(folder / "cut.h5", "image", points, 3);
  const Outcome outcome = run(folder, options + "cut.h5 -domain_periodic 0,1,0", 2);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
}

TEST(StartCheck, AStateThatWasPulledStartsTheNextStage) {
  const Folder folder;
  ASSERT_EQ(run(folder,
                "-scene fibre -fibre_segments 12 -fibre_strain 0.2 -pair none -ts_max_steps 2 "
                "-progress_interval 0 -state_output pulled.h5")
                .status,
            0);
  expectSilent(run(folder,
                   "-scene file -scene_file pulled.h5 -pair none -ts_max_steps 2 "
                   "-progress_interval 0"));
  // Other segments are another matter.
  expectRefused(run(folder,
                    "-scene file -scene_file pulled.h5 -pair none -ts_max_steps 2 "
                    "-fibre_segment_length 6.78"),
                {"strain +140 %"});
}

TEST(Contacts, ThatAreTooDeepWarnOnce) {
  const Folder folder;
  // Two crossing fibres whose axes are 1.8 rf apart, a fifth of a radius less than their walls.
  writeState(folder / "in.h5", {straightFibre({-6 * T, 0, 0}, {1, 0, 0}, 13),
                                straightFibre({0, -4 * T, 1.8 * 6.78}, {0, 1, 0}, 9)});
  for (const int ranks : {1, 3}) {
    const Outcome outcome =
        run(folder, start + "-pair_allow_overlap -ts_dt 5 -ts_max_steps 300", ranks);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(warnings(outcome), 1u) << outcome.output;
    EXPECT_NE(
        outcome.output.find("warning: step 0: fibre 0 segment 6 and fibre 1 segment 4 overlap "
                            "by 20 % of a radius"),
        std::string::npos)
        << outcome.output;
  }
}

TEST(Threads, FewerThanAskedGiveTheSameBytes) {
  const Folder folder;
  const std::string options =
      "-weave_fibres 4,4 -weave_segments 24 -ts_max_steps 150 -damping_local 0.2 "
      "-progress_interval 0 -snapshot_interval 100 ";
  auto outputs = [](const std::string& name) {
    return "-energy_monitor ascii:" + name + ".csv -state_output " + name + ".h5 -snapshot_file " +
           name;
  };
  ASSERT_EQ(run(folder, options + outputs("full"), 1, 3).status, 0);
  const std::pair<const char*, const char*> limits[] = {{"OMP_THREAD_LIMIT", "1"},
                                                        {"OMP_THREAD_LIMIT", "2"},
                                                        {"OMP_MAX_ACTIVE_LEVELS", "0"},
                                                        {"OMP_DYNAMIC", "true"}};
  for (const auto& [name, value] : limits) {
    setenv(name, value, 1);
    const Outcome outcome = run(folder, options + outputs("few"), 1, 3);
    unsetenv(name);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    if (name != std::string("OMP_DYNAMIC")) {
      EXPECT_NE(outcome.output.find("3 threads asked, the runtime gives"), std::string::npos)
          << outcome.output;
    }
    for (const char* file : {".csv", ".h5", "_0000000100.h5"})
      EXPECT_EQ(readFile(folder / ("few" + std::string(file))),
                readFile(folder / ("full" + std::string(file))))
          << name << "=" << value << ": " << file;
    for (const char* file : {".csv", ".h5", "_0000000000.h5", "_0000000100.h5", ".xdmf"})
      std::filesystem::remove(folder / ("few" + std::string(file)));
  }
}

TEST(Threads, GiveWayWhereTheyShareACoreAndTheBytesStay) {
  const Folder folder;
  // Two threads on one core pass it to and fro at each of their meetings.
  const std::string onOneCore =
      "taskset -pc \"$(taskset -pc $$ | sed \"s/.*: //; s/[-,].*//\")\" $$ > /dev/null; "
      "export OMP_NUM_THREADS=2";
  const std::string options =
      "-weave_fibres 6,6 -weave_segments 30 -damping_local 0.4 -ts_max_steps 40000 "
      "-progress_interval 0 -monitor_interval 4000 ";
  auto outputs = [](const std::string& name) {
    return "-energy_monitor ascii:" + name + ".csv -state_output " + name + ".h5";
  };
  ASSERT_EQ(run(folder, options + outputs("one")).status, 0);
  const Outcome two = runAfter(folder, onOneCore, options + outputs("two"));
  ASSERT_EQ(two.status, 0) << two.output;
  EXPECT_NE(two.output.find("1 rank x 2 threads"), std::string::npos) << two.output;
  EXPECT_NE(two.output.find(" of 2 worked on average, since there are fewer cores"),
            std::string::npos)
      << two.output;
  for (const char* file : {".csv", ".h5"})
    EXPECT_EQ(readFile(folder / ("one" + std::string(file))),
              readFile(folder / ("two" + std::string(file))));
  const Outcome all = runAfter(folder, onOneCore,
                               options + "-threads all -ts_max_steps 20000 -state_output all.h5");
  ASSERT_EQ(all.status, 0) << all.output;
  EXPECT_EQ(all.output.find("worked on average"), std::string::npos) << all.output;
}

TEST(Starts, TubesOfAnyChiralityAndLawsOfAnyRangeHaveTheirTables) {
  const Folder folder;
  const std::string fibre = "-scene fibre -fibre_segments 8 -ts_max_steps 1 ";
  for (const char* preset : {"cnt_7_3", "cnt_8_4", "cnt_8_5", "cnt_16_14", "cnt_17_10", "cnt_22_3",
                             "cnt_26_0", "cnt_39_17"})
    expectDone(run(folder, fibre + "-fibre_preset " + preset));
  for (const char* range :
       {"-pair_cutoff 63", "-pair_far_from 25.27",
        "-pair_points 5 -pair_far_points 5 -pair_cutoff "
        "65.62",
        "-pair capillary,contact -capillary_tension 0.0045 -capillary_volume 2400 "
        "-contact_modulus 20"})
    expectDone(run(folder, fibre + range));
}

TEST(Starts, TheDeepestOverlapIsFoundWhateverStandsBeforeIt) {
  // Two fibres side by side, and two end on whose points are nearer than their centres tell.
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 8),
                                straightFibre({0, 17.343571, 0}, {1, 0, 0}, 8),
                                straightFibre({0, 500, 0}, {1, 0, 0}, 8),
                                straightFibre({7 * 13.56 + 18, 500, 0}, {1, 0, 0}, 8)});
  for (const int ranks : {1, 2, 4})
    expectRefused(run(folder, "-scene file -scene_file in.h5 -ts_max_steps 1", ranks),
                  {"fibre 2 segment 7", "fibre 3 segment 0"});
}

TEST(Starts, ViscousDampingOfFewPairsIsWarnedOf) {
  const Folder folder;
  for (const auto& [law, warned] :
       {std::pair{"vdw", false}, std::pair{"hertz", true}, std::pair{"vdw,hertz", true}}) {
    const auto outcome = run(folder, std::string("-scene fibre -fibre_segments 6 -ts_max_steps 0 "
                                                 "-damping_viscous 1 -pair ") +
                                         law);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("warning: -damping_viscous") != std::string::npos, warned)
        << outcome.output;
  }
}

TEST(Starts, FarPointsThatAreTooFewAreWarnedOf) {
  const Folder folder;
  for (const auto& [from, warned] : {std::pair{"30", true}, std::pair{"38", false}}) {
    const auto outcome =
        run(folder, std::string("-kinds a,b -weave_kinds a,b -weave_fibres 2,2 -weave_segments 24 "
                                "-fibre_segment_length 27.12 -b_fibre_young 900 -pair_points 9 "
                                "-pair_far_points 1 -ts_max_steps 0 -pair_far_from ") +
                        from);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("warning: -a_pair_far_points 1") != std::string::npos, warned)
        << outcome.output;
  }
}

TEST(Starts, CoordinatesWithTooFewDigitsAreRefused) {
  const Folder folder;
  for (const double far : {1e9, 1e13}) {
    writeState(folder / "in.h5", {straightFibre({far, 0, 0}, {0, 1, 0}, 4)});
    const auto outcome = run(folder, start + "-pair none -ts_max_steps 1", 2);
    if (far < 1e10)
      expectDone(outcome);
    else
      expectRefused(outcome, {"reach to 1e+13 A", "too few digits"});
  }
}

TEST(Starts, SumsOfForcesThatNoIntegerHoldsAreRefused) {
  // All fibres of a bundle within each other: those at its rim are pushed by all others.
  const Folder folder;
  for (const int ranks : {1, 2})
    expectRefused(run(folder,
                      "-scene bundle -bundle_fibres 37 -bundle_segments 6 -bundle_gap 0.5 "
                      "-pair hertz -pair_allow_overlap -start_unchecked -ts_max_steps 0 "
                      "-state_output out.h5",
                      ranks),
                  {"fibres overlap so much", "fibre 22 segment 0"});
  EXPECT_FALSE(std::filesystem::exists(folder / "out.h5"));
}

TEST(Starts, DampingThatIsBeyondItsSumOnlyTogetherIsSeen) {
  // A segment along the joint of two, each of which dampens it by three quarters of what a number
  // may be: 8 m/2^k of twice the speed of sound, here 1.94 A/fs.
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {0, 1, 0}, 2),
                                straightFibre({0, 6.78, 13.4}, {0, 1, 0}, 1)});
  for (const auto& [speed, fits] : {std::pair{0.9, true}, std::pair{1.94, false}}) {
    setMotion(
        folder / "in.h5",
        [u = speed](std::size_t i, const Vec3d&) {
          return Vec3d{i < 2 ? 0.0 : u, 0, 0};
        },
        [](std::size_t, const Vec3d&) { return Vec3d{}; });
    const auto outcome = run(folder, start +
                                         "-scene_file_edited -pair contact -contact_modulus 20 "
                                         "-damping_viscous 1e6 -ts_dt 1e-5 -ts_max_steps 2");
    EXPECT_EQ(outcome.status, fits ? 0 : 2) << outcome.output;
    EXPECT_EQ(says(outcome, "larger than what is summed"), !fits) << outcome.output;
  }
}

TEST(Starts, ForcesThatGetBeyondTheirSumsEndTheRun) {
  // Dampers that turn every motion round within a step, between segments that meet at speed: those
  // of one fibre come upon the other after 110 steps, and are past it after 180.
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {0, 1, 0}, 1), straightFibre({-60, 0, 13.5}, {0, 1, 0}, 1)});
  setMotion(
      folder / "in.h5",
      [](std::size_t i, const Vec3d&) {
        return Vec3d{i == 0 ? 0.0 : 20.0, 0, 0};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const std::string options = start +
                              "-scene_file_edited -pair contact -contact_modulus 20 "
                              "-damping_viscous 1e6 -ts_dt 0.02 -overwrite ";
  for (const int ranks : {1, 2}) {
    expectDone(run(folder, options + "-ts_max_steps 100", ranks));
    const auto outcome =
        run(folder, options + "-ts_max_steps 300 -checkpoint_file c.h5 -checkpoint_interval 190",
            ranks);
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_TRUE(says(outcome, "larger than what is summed")) << outcome.output;
    EXPECT_TRUE(says(outcome, "at step 190")) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(folder / "c.h5"));
  }
}

}  // namespace
