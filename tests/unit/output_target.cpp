/// Whose place a result may take.
#include "nanoweft/state/output_target.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "nanoweft/base/error.hpp"
#include "state_helpers.hpp"

namespace nanoweft::test {
namespace {

namespace fs = std::filesystem;

std::string refusal(const std::string& file, const ReplaceRule& rule) {
  try {
    refuseForeignTarget(PETSC_COMM_SELF, file, rule);
    return "";
  } catch (const InputError& problem) {
    return problem.what();
  }
}

void expectSays(const std::string& text, const std::string& fragment) {
  EXPECT_NE(text.find(fragment), std::string::npos) << "no '" << fragment << "' in: " << text;
}

ReplaceRule ruleOf(const std::string& options) {
  ReplaceRule rule;
  rule.run = testRun(options);
  return rule;
}

TEST(OutputTarget, IsReplacedByTheSameRunOnly) {
  const Place place;
  writeTestState(place / "s.h5", "-damping_local 0.3\n-seed 1\n");
  EXPECT_EQ(refusal(place / "s.h5", ruleOf("-damping_local 0.3\n-seed 1\n")), "");
  const std::string other = refusal(place / "s.h5", ruleOf("-damping_local 0.9\n-seed 1\n"));
  expectSays(other, "will not replace " + place / "s.h5" + ": another run wrote it");
  expectSays(other, "it has -damping_local 0.3, this run 0.9");
  expectSays(refusal(place / "s.h5", ruleOf("-seed 1\n")),
             "it has -damping_local 0.3, this run not");
  ReplaceRule forced = ruleOf("-seed 2\n");
  forced.overwrite = true;
  EXPECT_EQ(refusal(place / "s.h5", forced), "");
  ReplaceRule restart = ruleOf("-seed 2\n");
  restart.restart = place / "s.h5";
  EXPECT_EQ(refusal(place / "s.h5", restart), "");
}

TEST(OutputTarget, IsNeverTheInputWhateverItsName) {
  const Place place;
  writeTestState(place / "s.h5");
  fs::create_symlink("s.h5", place / "link.h5");
  fs::create_hard_link(place / "s.h5", place / "twin.h5");
  ReplaceRule rule = ruleOf("-seed 1\n");
  rule.overwrite = true;
  rule.inputs = {place / "s.h5"};
  for (const char* name : {"s.h5", "link.h5", "twin.h5", "./s.h5"})
    expectSays(refusal(place / name, rule), "this run starts from it");
}

TEST(OutputTarget, IsNoFifoDeviceFolderOrForeignFile) {
  const Place place;
  ::mkfifo((place / "pipe").c_str(), 0666);
  setBytes(place / "notes.txt", "mine");
  ReplaceRule rule = ruleOf("-seed 1\n");
  rule.overwrite = true;
  expectSays(refusal(place / "pipe", rule), "no regular file");
  expectSays(refusal("/dev/null", rule), "no regular file");
  expectSays(refusal(place / "", rule), "folder");
  expectSays(refusal(place / "notes.txt", rule), "not a nanoweft state file");
  writeTestState(place / "locked.h5");
  ::chmod((place / "locked.h5").c_str(), 0444);
  expectSays(refusal(place / "locked.h5", rule), "write-protected");
}

TEST(OutputTarget, ThatAnotherRunTookMeanwhileIsKept) {
  const Place place;
  EXPECT_EQ(refusal(place / "s.h5", ruleOf("-seed 1\n")), "");
  setBytes(place / "s.h5", "another's");
  EXPECT_THROW(writeTestState(place / "s.h5"), RunError);
  EXPECT_EQ(bytesOf(place / "s.h5"), "another's");
  fs::remove(place / "s.h5");
  writeTestState(place / "s.h5");
  // The run itself may go on replacing its own.
  writeTestState(place / "s.h5");
  fs::remove(place / "s.h5");
  setBytes(place / "s.h5", "another's");
  EXPECT_THROW(writeTestState(place / "s.h5"), RunError);
  EXPECT_EQ(bytesOf(place / "s.h5"), "another's");
}

TEST(OutputTarget, IsProbedWithoutTrace) {
  const Place place;
  setBytes(place / "s.h5.tmp", "precious");
  requireWritable(PETSC_COMM_SELF, place / "s.h5");
  writeTestState(place / "s.h5");
  EXPECT_EQ(bytesOf(place / "s.h5.tmp"), "precious");
  EXPECT_THROW(requireWritable(PETSC_COMM_SELF, place / std::string(256, 'x')), InputError);
  EXPECT_THROW(requireWritable(PETSC_COMM_SELF, place / "none/s.h5"), InputError);
}

TEST(OutputTarget, LinksStayAndTheirTargetsAreMade) {
  const Place place;
  fs::create_directory(place / "real");
  fs::create_symlink("real/s.h5", place / "a.h5");
  fs::create_symlink(place / "a.h5", place / "b.h5");
  for (int k = 0; k < 2; ++k) {
    writeTestState(place / "b.h5");
    EXPECT_TRUE(fs::is_symlink(place / "a.h5") && fs::is_symlink(place / "b.h5"));
    EXPECT_EQ(stateFileProblem(place / "real/s.h5"), "");
    EXPECT_EQ(stateFileProblem(place / "b.h5"), "");
  }
  fs::create_symlink("loop.h5", place / "loop.h5");
  EXPECT_THROW(writeTestState(place / "loop.h5"), RunError);
}

TEST(OutputTarget, NamesMayBeAsLongAsTheSystemAllows) {
  const Place place;
  writeTestState(place / (std::string(252, 'x') + ".h5"));
  writeTestState(place / (std::string(252, 'x') + ".h5"));
  std::string deep = place / "";
  while (deep.size() < 3500) deep += std::string(200, 'd') + "/";
  fs::create_directories(deep);
  writeTestState(deep + "s.h5");
  EXPECT_EQ(stateFileProblem(deep + "s.h5"), "");
}

TEST(OutputFile, WorksWhereFilesNeedANameFromTheStart) {
  const Place place;
  for (const auto& [bytes, leaf] : {std::pair<std::string, std::string>{"one", "f"},
                                    {"two", "f"},
                                    {"three", std::string(255, 'y')}}) {
    FileIdentity replaced = FileIdentity::of(place / leaf);
    OutputFile file(place / leaf, OutputFile::Temporary::named);
    file.write(bytes);
    EXPECT_EQ(file.publish(replaced), "");
    EXPECT_EQ(bytesOf(place / leaf), bytes);
  }
  { OutputFile(place / "g", OutputFile::Temporary::named).write("never published"); }
  for (const auto kind : {OutputFile::Temporary::named, OutputFile::Temporary::nameless}) {
    FileIdentity nothing;
    OutputFile file(place / "f", kind);
    EXPECT_NE(file.publish(nothing).find("will not replace"), std::string::npos);
  }
  EXPECT_EQ(bytesOf(place / "f"), "two");
  EXPECT_EQ(std::ranges::count(place.names(), ' '), 2);
}

TEST(OutputFile, HasThePermissionsOfTheUser) {
  const Place place;
  const mode_t before = ::umask(027);
  writeTestState(place / "s.h5");
  ::umask(before);
  struct stat status {};
  ASSERT_EQ(::stat((place / "s.h5").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

}  // namespace
}  // namespace nanoweft::test
