/// State files of whole runs, on several ranks: full disks, places that are another's, memory.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

const std::string weave =
    "-scene weave -weave_fibres 4,4 -weave_segments 100 -progress_interval 0 -ts_max_steps 3 ";
const std::string fibre = "-scene fibre -fibre_segments 12 -progress_interval 0 -ts_max_steps 2 ";

/// One line "nanoweft: error: ..." with the fragment.
void expectEnds(const Outcome& outcome, int status, const std::string& fragment) {
  EXPECT_EQ(outcome.status, status) << outcome.output;
  const std::size_t at = outcome.output.find("nanoweft: error: ");
  ASSERT_NE(at, std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find("nanoweft: error: ", at + 1), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find(fragment, at), std::string::npos) << outcome.output;
  expectClean(outcome.output);
}

std::string namesIn(const Folder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  std::string all;
  for (const std::string& name : names) all += name + " ";
  return all;
}

class Files : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Robust, Files, testing::Values(1, 3), testing::PrintToStringParamName());

TEST_P(Files, FullDiskEndsTheRunAndLeavesTheLastCheckpoint) {
  const Folder folder;
  ASSERT_EQ(run(folder, weave + "-checkpoint_file c.h5").status, 0);
  const std::string before = readFile(folder / "c.h5");
  const std::string options =
      "-restart c.h5 -checkpoint_file c.h5 -progress_interval 0 -ts_max_steps 6";
  expectEnds(runAfter(folder, "ulimit -f 60", options, GetParam()), 2,
             "cannot write c.h5: File too large");
  EXPECT_TRUE(readFile(folder / "c.h5") == before);
  EXPECT_EQ(namesIn(folder), "c.h5 out.txt ");
}

TEST_P(Files, SnapshotsFinalStateAndForcesHaveTheSameBytes) {
  const std::string options =
      "-scene weave -weave_fibres 20,20 -weave_segments 900 -pair none -ts_max_steps 1 "
      "-progress_interval 0 -snapshot_file s -snapshot_interval 1 -state_output f.h5 -state_forces "
      "-checkpoint_file c.h5";
  const Folder one, several;
  ASSERT_EQ(run(one, options).status, 0);
  const Outcome outcome = run(several, options, 1 + GetParam());
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file : {"s_0000000000.h5", "s_0000000001.h5", "f.h5", "c.h5"})
    EXPECT_TRUE(readFile(one / file) == readFile(several / file)) << file;
}

TEST_P(Files, TheSceneFileIsNeverReplaced) {
  const Folder folder;
  writeState(folder / "mine.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 12)});
  const std::string before = readFile(folder / "mine.h5");
  for (const std::string output : {"-state_output", "-checkpoint_file"})
    expectEnds(
        run(folder,
            "-scene file -scene_file mine.h5 -ts_max_steps 2 -overwrite " + output + " ./mine.h5",
            GetParam()),
        1, "this run starts from it");
  EXPECT_TRUE(readFile(folder / "mine.h5") == before);
}

TEST_P(Files, AnEditedSceneIsUsedOnlyWhenThatIsSaid) {
  const Folder folder;
  ASSERT_EQ(run(folder, fibre + "-state_output in.h5").status, 0);
  const std::string line = readFile(folder / "in.h5").substr(0, 512);
  stopMotion(folder / "in.h5");
  const std::string from = "-scene file -scene_file in.h5 -ts_max_steps 1 ";
  EXPECT_EQ(run(folder, from, GetParam()).status, 0);  // signed anew
  // As an editor leaves it that knows nothing of the digest.
  const std::string bytes = line + readFile(folder / "in.h5").substr(512);
  writeText(folder / "in.h5", bytes);
  expectEnds(run(folder, from, GetParam()), 1, "SHA-256");
  EXPECT_EQ(run(folder, from + "-scene_file_edited", GetParam()).status, 0);
}

TEST_P(Files, TooManySegmentsForTheMemoryAreRefusedByAll) {
  const Folder folder;
  expectEnds(runAfter(folder, "ulimit -v 3000000",
                      "-scene fibre -fibre_segments 100000000 -ts_max_steps 1", GetParam()),
             2, "not enough memory");
}

TEST_P(Files, FifosAndDevicesAreRefusedAtOnce) {
  const Folder folder;
  ASSERT_EQ(std::system(("mkfifo " + folder / "pipe").c_str()), 0);
  for (const std::string name : {"pipe", "/dev/zero"})
    for (const std::string option : {"-restart ", "-state_output ", "-checkpoint_file "})
      EXPECT_EQ(run(folder, fibre + option + name, GetParam()).status, 1) << option << name;
  expectEnds(run(folder, "-scene file -ts_max_steps 1 -scene_file pipe", GetParam()), 1, "a fifo");
}

TEST(FilesBesides, AnotherRunsOutputOfTheSameTimeIsKept) {
  const Folder folder;
  const Outcome outcome = runBeside(
      folder,
      "-scene weave -weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -ts_max_steps 100000 "
      "-progress_interval 0.05 -state_output f.h5",
      2,
      "for i in $(seq 1200); do grep -q ns/day out.txt && break; sleep 0.05; done; echo mine > "
      "f.h5");
  expectEnds(outcome, 2, "will not replace f.h5");
  EXPECT_EQ(readFile(folder / "f.h5"), "mine\n");
}

}  // namespace
}  // namespace nanoweft::test
