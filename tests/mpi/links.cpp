/// Links between segments: the same bytes on any ranks, threads and partitions, and over restarts.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "nanoweft/base/hdf5.hpp"
#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

/// A weave of 8 fibres of 24 segments with 60 links all over it: near and far ones, several at one
/// segment, some within a fibre.
std::vector<LinkEnds> linksOfWeave() {
  std::vector<LinkEnds> links;
  for (std::int64_t k = 0; k < 50; ++k)
    links.push_back({k % 8, (7 * k) % 24, (3 * k + 1) % 8, (11 * k + 5) % 24});
  for (std::int64_t k = 0; k < 10; ++k) links.push_back({2, 12, k % 2 ? 2 : 5, 1 + 2 * k});
  std::erase_if(links, [](const LinkEnds& l) { return l[0] == l[2] && l[1] == l[3]; });
  return links;
}

void makeLinked(const Folder& folder, const std::vector<LinkEnds>& links = linksOfWeave()) {
  const auto outcome = run(folder,
                           "-weave_fibres 4,4 -weave_segments 24 -scene_perturb 0.1 "
                           "-ts_max_steps 0 -state_output in.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  if (!links.empty()) setLinks(folder / "in.h5", links);
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
  double all = 0;
  for (int seed = 1; seed <= 8; ++seed) {
    const Folder folder;
    outcome = run(folder,
                  "-weave_fibres 8,8 -weave_segments 24 -links_density 0.0057 -links_distance 22 "
                  "-link_law spring -ts_max_steps 0 -state_output out.h5 -seed " +
                      std::to_string(seed),
                  1);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    all += static_cast<double>(readDataset(folder / "out.h5", "/link/rest_length").size());
  }
  const double expected = 8 * 0.0057 * 16 * 24 * 13.56;
  EXPECT_NEAR(all, expected, 4 * std::sqrt(expected));
  const auto ends = readDataset(one / "out.h5", "/link/segments");
  for (std::size_t k = 0; k < links.size(); ++k) EXPECT_NE(ends[4 * k], ends[4 * k + 2]);
  outcome = run(other, made + "-seed 2", 1);
  EXPECT_NE(readDataset(other / "out.h5", "/link/segments"), ends);
  expectRefused(
      run(other, "-weave_fibres 4,4 -links_density 1 -links_distance 20 -ts_max_steps 2", 2),
      {"-links_density 1: there are only", "at most"});
  expectRefused(run(other, "-links_density 1 -ts_max_steps 2"), {"needs -links_distance"});
  expectRefused(run(other, "-links_density 1e-3 -links_distance 900 -ts_max_steps 2"),
                {"-links_distance 900: beyond"});
  expectRefused(run(other, "-pair none -links_density 1e-3 -links_distance 20 -ts_max_steps 2", 2),
                {"-links_density: links are made among the pairs of the lists", "without -pair"});
  // What the lists need not have all of, a skin or another length of segments would decide.
  expectRefused(run(other,
                    "-weave_fibres 4,4 -links_density 1e-3 -links_distance 45 -pair_skin 2 "
                    "-ts_max_steps 2"),
                {"-links_distance 45: beyond 4", "a wider -pair_skin"});
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
  EXPECT_NE(outcome.output.find("warning: the run that left the state had links of another law"),
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

void expectSaid(const std::string& output, const std::string& text) {
  EXPECT_NE(output.find(text), std::string::npos) << text << "\n" << output;
}

/// Every third link of the weave is of the other kind.
bool isSoft(std::size_t link) {
  return link % 3 == 0;
}

const std::string lawsOfKinds =
    "-link_kinds stiff,soft -soft_link_law spring -soft_link_stretch 0.5 -stiff_link_stiffness "
    "2,400,-80,30 ";

/// The weave with links of both kinds; the file numbers them in another order than the run.
void makeLinkedByKinds(const Folder& folder) {
  const auto links = linksOfWeave();
  std::vector<std::int32_t> kinds;
  for (std::size_t k = 0; k < links.size(); ++k) kinds.push_back(isSoft(k) ? 0 : 1);
  makeLinked(folder, links);
  setLinkKinds(folder / "in.h5", kinds, "soft,stiff");
}

TEST(LinkKinds, BreakByTheirOwnLawWithTheSameBytesOnAnyRanksAndThreadsAndOverARestart) {
  const Folder folder;
  makeLinkedByKinds(folder);
  const std::string start =
      "-scene file -scene_file in.h5 -scene_perturb 0.2 -damping_local 0.2 -progress_interval 0 " +
      lawsOfKinds + "-stiff_link_break_strain 0.01 " + outputs;
  auto outcome = run(folder, start + "-ts_max_steps 100", 1, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  expectSaid(outcome.output, "stiff links: bonds with B1 2,");
  expectSaid(outcome.output, "soft links: springs of 0.5");
  const std::string state = readFile(folder / "out.h5"), table = readFile(folder / "energy.csv");
  const auto broken = readDataset(folder / "out.h5", "/link/broken"),
             kind = readDataset(folder / "out.h5", "/link/kind");
  int torn = 0;
  for (std::size_t k = 0; k < broken.size(); ++k) {
    EXPECT_EQ(kind[k], isSoft(k) ? 1 : 0) << k;
    EXPECT_TRUE(broken[k] == 0 || !isSoft(k)) << k;
    torn += broken[k] != 0;
  }
  EXPECT_GT(torn, 1);
  EXPECT_LT(torn, 38);
  const int layouts[][2] = {{1, 2}, {2, 1}, {2, 2}, {3, 1}, {3, 2}};
  for (const auto& [ranks, threads] : layouts) {
    outcome = run(folder, start + "-ts_max_steps 100", ranks, threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(readFile(folder / "out.h5") == state) << ranks << " x " << threads;
    EXPECT_TRUE(readFile(folder / "energy.csv") == table) << ranks << " x " << threads;
  }
  outcome = run(folder, start + "-ts_max_steps 45 -checkpoint_file c.h5", 3);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(folder, outputs + "-restart c.h5 -ts_max_steps 100", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_TRUE(readFile(folder / "out.h5") == state);
  EXPECT_TRUE(readFile(folder / "energy.csv") == table);
}

TEST(LinkKinds, ActAsEachDoesAlone) {
  const auto links = linksOfWeave();
  std::vector<LinkEnds> soft, stiff;
  for (std::size_t k = 0; k < links.size(); ++k) (isSoft(k) ? soft : stiff).push_back(links[k]);
  auto forces = [](const Folder& folder, const std::string& laws) {
    const auto outcome = run(folder,
                             "-scene file -scene_file in.h5 -pair none -scene_perturb 0.2 "
                             "-ts_max_steps 0 -state_output out.h5 -state_forces " +
                                 laws,
                             1);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    auto all = readDataset(folder / "out.h5", "/state/force");
    const auto torque = readDataset(folder / "out.h5", "/state/torque");
    all.insert(all.end(), torque.begin(), torque.end());
    return all;
  };
  const Folder none, both, softAlone, stiffAlone;
  makeLinked(none, {});
  makeLinkedByKinds(both);
  makeLinked(softAlone, soft);
  makeLinked(stiffAlone, stiff);
  const auto bare = forces(none, ""), together = forces(both, lawsOfKinds),
             bySoft = forces(softAlone, "-link_law spring -link_stretch 0.5"),
             byStiff = forces(stiffAlone, "-link_stiffness 2,400,-80,30");
  ASSERT_FALSE(bare.empty());
  double most[2] = {0, 0};
  for (std::size_t k = 0; k < bare.size(); ++k) {
    EXPECT_NEAR(together[k] - bare[k], bySoft[k] - bare[k] + byStiff[k] - bare[k], 1e-9) << k;
    most[0] = std::max(most[0], std::abs(bySoft[k] - bare[k]));
    most[1] = std::max(most[1], std::abs(byStiff[k] - bare[k]));
  }
  EXPECT_GT(most[0], 0.01);
  EXPECT_GT(most[1], 0.01);
}

TEST(LinkKinds, AreMadeEachByItsOwnDraw) {
  const std::string weave =
      "-weave_fibres 8,8 -weave_segments 24 -links_distance 22 -link_law spring -ts_max_steps 0 "
      "-state_output out.h5 ";
  const Folder alone, one, three;
  for (const auto& [folder, ranks] : {std::pair{&one, 1}, std::pair{&three, 3}}) {
    const auto outcome =
        run(*folder,
            weave + "-link_kinds a,b -links_density 0.0057 -b_links_density 0.01 -a_link_stretch 3",
            ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
  }
  EXPECT_TRUE(readFile(one / "out.h5") == readFile(three / "out.h5"));
  ASSERT_EQ(run(alone, weave + "-links_density 0.0057", 2).status, 0);
  const auto first = readDataset(alone / "out.h5", "/link/segments"),
             all = readDataset(one / "out.h5", "/link/segments"),
             kind = readDataset(one / "out.h5", "/link/kind");
  const auto links = first.size() / 4;
  // The links of the first kind are those that it makes alone; the others lie elsewhere.
  ASSERT_GT(kind.size(), links + 20);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), all.begin()));
  for (std::size_t k = 0; k < kind.size(); ++k) EXPECT_EQ(kind[k], k < links ? 0 : 1) << k;
  std::set<std::array<double, 4>> taken;
  std::size_t shared = 0;
  for (std::size_t k = 0; k < kind.size(); ++k)
    shared += !taken.insert({all[4 * k], all[4 * k + 1], all[4 * k + 2], all[4 * k + 3]}).second;
  EXPECT_LT(shared, links);
}

TEST(LinkKinds, OfALaterStageAreKnownByTheirNames) {
  const Folder folder;
  makeLinkedByKinds(folder);
  const std::string run2 = " -ts_max_steps 2 -progress_interval 0 ",
                    next = "-scene file -scene_file a.h5" + run2;
  auto outcome =
      run(folder, "-scene file -scene_file in.h5 -state_output a.h5" + run2 + lawsOfKinds, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // The same laws in another order, with a kind that the file does not have.
  outcome = run(folder,
                next +
                    "-link_kinds more,soft,stiff -soft_link_law spring -soft_link_stretch 0.5 "
                    "-stiff_link_stiffness 2,400,-80,30",
                1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  expectSaid(outcome.output, "0 more links:");
  EXPECT_EQ(outcome.output.find("warning: the run that left"), std::string::npos) << outcome.output;
  outcome = run(folder, next + "-link_kinds stiff,soft", 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  expectSaid(outcome.output, "warning: the run that left the state had links of another law");
  expectRefused(run(folder, next, 1), {"the kind 'stiff', which -link_kinds must name"});
  expectRefused(run(folder, next + "-link_kinds soft,glue", 2),
                {"the kind 'stiff', which is not among -link_kinds soft,glue"});
}

TEST(LinkKinds, WrongOnesAreRefused) {
  const Folder folder;
  const std::string made = "-weave_fibres 4,4 -ts_max_steps 2 -links_distance 22 ";
  const struct {
    const char *options, *says;
  } cases[] = {
      {"-link_kinds a,A", "-link_kinds: 'A' stands there twice"},
      {"-link_kinds draw", "'draw' cannot name a kind of link, since -draw_"},
      {"-link_kinds a_b", "'a_b' cannot name a kind of link; a name is a letter"},
      {"-link_kinds a,b -b_links_density 5", "links b: -links_density 5: there are only"},
      {"-link_kinds a,b -a_links_density 1e-3 -b_link_stretch 3",
       "-b_link_stretch is not used by this run: the state has no links"},
      {"-link_kinds a -a_links_density 1e-3 -b_link_law spring", "unknown option -b_link_law"},
      {"-link_kinds a -a_links_density 1e-3 -kinds A", "'a' is among -kinds, too"},
      {"-link_kinds a -a_links_density 1e-3 -bc a -a_group 1 -a_fix 1,1,1",
       "'a' is among -bc, too"},
      {"-link_kinds a -a_links_density 1e-3 -walls a -a_point 0,0,-900 -a_axis 0,0,1 -a_modulus 9",
       "'a' is among -walls, too"},
  };
  for (const auto& c : cases) expectRefused(run(folder, made + c.options), {c.says});
  expectRefused(run(folder, "-weave_fibres 4,4 -ts_max_steps 2 -link_kinds a"),
                {"-link_kinds is not used by this run: the state has no links"});
  makeLinked(folder, {{0, 1, 1, 1}, {0, 2, 1, 3}});
  setLinkKinds(folder / "in.h5", {0, 2}, "");
  expectRefused(run(folder, "-scene file -scene_file in.h5 -link_kinds a,b -ts_max_steps 2", 2),
                {"link 1: its kind is 2; there are 2"});
}

TEST(LinksOfFiles, MayBeBrokenByTruthValuesOfH5py) {
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 4), straightFibre({0, 20, 0}, {1, 0, 0}, 4)});
  setLinks(folder / "in.h5", {{0, 1, 1, 1}, {0, 2, 1, 2}});
  {
    const h5::Handle file(H5Fopen((folder / "in.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose),
        type(H5Tenum_create(H5T_NATIVE_INT8), H5Tclose);
    const std::int8_t values[2] = {0, 1};
    H5Tenum_insert(type, "FALSE", values);
    H5Tenum_insert(type, "TRUE", values + 1);
    const hsize_t count = 2;
    const h5::Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose),
        set(H5Dcreate2(file, "/link/broken", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
            H5Dclose);
    ASSERT_GE(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), 0);
  }
  for (const int ranks : {1, 2}) {
    const auto outcome = run(folder,
                             "-scene file -scene_file in.h5 -scene_file_edited -pair none "
                             "-ts_max_steps 2 -overwrite -state_output out.h5",
                             ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(readDataset(folder / "out.h5", "/link/broken"), (std::vector<double>{0, 1}));
  }
}

TEST(LinkKinds, OfFibresWithoutAPairLawAreMissed) {
  const Folder folder;
  for (const auto& [law, warned] : {std::pair{"none", true}, std::pair{"hertz", false}}) {
    const auto outcome =
        run(folder,
            std::string("-kinds a,b -scene bundle -bundle_kinds a,b -bundle_fibres 7 "
                        "-bundle_segments 20 -links_density 0.001 -links_distance 20 -link_law "
                        "spring -link_stretch 0.1 -ts_max_steps 0 -pair hertz -a_b_pair ") +
                law,
            2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("no links between a and b") != std::string::npos, warned)
        << outcome.output;
  }
}

TEST(LinksOfStages, TieNoPlaceTwice) {
  const Folder folder;
  const std::string options =
      "-links_density 0.01 -links_distance 22 -damping_local 0.4 -ts_max_steps 4 -state_output ";
  ASSERT_EQ(run(folder, "-weave_fibres 4,4 -weave_segments 16 " + options + "one.h5").status, 0);
  std::vector<double> files[2];
  for (const int ranks : {1, 3}) {
    const auto outcome =
        run(folder, "-scene file -scene_file one.h5 -overwrite " + options + "two.h5", ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    files[ranks > 1] = readDataset(folder / "two.h5", "/link/segments");
  }
  EXPECT_EQ(files[0], files[1]);
  std::set<std::vector<double>> places;
  for (std::size_t k = 0; k < files[0].size(); k += 4)
    places.insert(std::vector<double>(files[0].begin() + static_cast<std::ptrdiff_t>(k),
                                      files[0].begin() + static_cast<std::ptrdiff_t>(k + 4)));
  EXPECT_EQ(4 * places.size(), files[0].size());
  EXPECT_GT(files[0].size(), readDataset(folder / "one.h5", "/link/segments").size());
}

}  // namespace
}  // namespace nanoweft::test
