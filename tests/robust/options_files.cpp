/// Options from files, pipes, YAML and the environment: what is read is what was written, or one
/// line says where it is wrong; and the questions that need no run.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>

#include "nanoweft/app/text_input.hpp"
#include "nanoweft/app/wall_time.hpp"
#include "nanoweft/app/yaml_options.hpp"
#include "nanoweft/base/error.hpp"
#include "support/expect.hpp"
#include "support/program.hpp"

using namespace nanoweft;
using namespace nanoweft::test;

namespace {

const std::string rest = " -ts_max_steps 3 -progress_interval 0 ";

/// The line of energies at the end of a run.
std::string energies(const Outcome& outcome) {
  const auto at = outcome.output.find("energies (eV)");
  if (outcome.status != 0 || at == std::string::npos)
    return "status " + std::to_string(outcome.status) + ": " + outcome.output;
  return outcome.output.substr(at, outcome.output.find('\n', at) - at);
}

/// What a stretched fibre of five segments has: all sources of options must come to this.
const std::string& wanted() {
  static const std::string line = [] {
    const Folder folder;
    return energies(run(folder, "-scene fibre -fibre_segments 5 -fibre_strain 0.01" + rest));
  }();
  EXPECT_TRUE(line.starts_with("energies")) << line;
  return line;
}

/// An environment variable while it lives.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
};

struct Case {
  std::string name, text;
  std::vector<std::string> fragments = {};
  std::string file = "run.opts";
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

const std::vector<Case> goodFiles = {
    {"Tabs", "-scene\tfibre\n\t-fibre_segments\t5\t\n-fibre_strain 0.01\n"},
    {"WindowsLines", "-scene fibre\r\n-fibre_segments 5\r\n\r\n-fibre_strain 0.01\r\n"},
    {"OldMacLines", "-scene fibre\r-fibre_segments 5\r-fibre_strain 0.01\r"},
    {"ByteOrderMark", "\xef\xbb\xbf-scene fibre\n-fibre_segments 5\n-fibre_strain 0.01\n"},
    {"FormFeeds", "-scene fibre\n\f\n-fibre_segments\f5\n-fibre_strain\v0.01\n"},
    {"NoNewlineAtTheEnd", "-scene fibre\n-fibre_segments 5\n-fibre_strain 0.01"},
    {"Comments",
     "# a fibre -scene weave\n-scene fibre # -x\n  #\n-fibre_segments 5 #5\n"
     "-fibre_strain 0.01\t# 'open \"quotes\n"},
    {"Quotes", "-scene 'fibre'\n-fibre_segments \"5\"\n-fibre_strain '0.01' # x\n"},
    {"Alias", "-glass 0.01\nalias -glass -fibre_strain\n-scene fibre\n-fibre_segments 5\n"},
    {"Prefix",
     "-scene fibre\n-prefix_push fibre_\n-segments 5\n-strain 0.01\n-prefix_pop\n"
     "-pair_exclude 20\n"},
    {"LaterWins",
     "-scene weave\n-fibre_segments 7\n-scene fibre\n-fibre_segments 5\n"
     "-FIBRE_strain 0.3\n-fibre_strain 0.01\n"},
    {"NegativeValues",
     "-scene fibre\n-fibre_segments 5\n-fibre_strain 0.01\n"
     "-domain_lower -500,-500,-500\n-domain_upper 500,500,500\n"},
    {"LongValue",
     "-scene fibre\n-fibre_segments 5\n-fibre_strain 0.01" + std::string(5000, '0') + "\n"},
    {"ByExtension", "scene: fibre\nfibre_segments: 5\nfibre_strain: 0.01\n", {}, "run.yaml"},
    {"NestedMaps", "scene: fibre\nfibre:\n  segments: 5\n  strain: 1e-2\n", {}, "run.yml"},
    {"ByItsStart", "---\nscene: fibre\nfibre: {segments: 5, strain: 0.01}\n"},
    {"Json",
     "{\"scene\": \"fibre\", \"fibre\": {\"segments\": 5, \"strain\": 0.01}}",
     {},
     "run.json"},
    {"ListsAndNumbersBelowZero",
     "scene: fibre\nfibre: {segments: 5, strain: 0.01}\ndomain:\n  lower: [-500, -500, -500]\n"
     "  upper:\n  - 500\n  - 500\n  - 500\n",
     {},
     "run.yaml"},
    {"MergedMaps",
     "$$common: &common\n  segments: 5\n  strain: 0.01\nscene: fibre\nfibre:\n  <<: *common\n",
     {},
     "run.yaml"},
    {"MergedMapsThatDiffer",
     "$$a: &a\n  segments: 7\n  strain: 0.01\n$$b: &b\n  segments: 9\n  strain: 0.02\nscene: "
     "fibre\nfibre:\n  segments: 5\n  <<: [*a, *b]\n",
     {},
     "run.yaml"},
    {"WindowsYaml",
     "\xef\xbb\xbfscene: fibre\r\nfibre_segments: 5\r\nfibre_strain: 0.01\r\n",
     {},
     "run.yaml"},
};

class GoodFile : public testing::TestWithParam<Case> {};

TEST_P(GoodFile, IsReadAsItWasWritten) {
  const Folder folder;
  const Case& c = GetParam();
  writeText(folder / c.file, c.text);
  EXPECT_EQ(energies(run(folder, "-options_file " + c.file + rest)), wanted());
}

INSTANTIATE_TEST_SUITE_P(Options, GoodFile, testing::ValuesIn(goodFiles),
                         [](const auto& info) { return info.param.name; });

const std::vector<Case> badFiles = {
    {"NoDash", "-scene fibre\nts_max_steps 2\n", {"run.opts: line 2", "'ts_max_steps'"}},
    {"EnDash", "-scene fibre\n\xe2\x80\x93ts_max_steps 2\n", {"run.opts: line 2"}},
    {"TwoDashes", "--scene fibre\n", {"line 1", "'--scene'", "one -"}},
    {"EqualsSign", "-scene=fibre\n", {"line 1", "-scene fibre"}},
    {"NoBreakSpace",
     "-scene\xc2\xa0"
     "fibre\n",
     {"line 1", "no-break space"}},
    {"TwoOptions", "-scene fibre -fibre_segments 5\n", {"line 1", "one option on a line"}},
    {"FlagAndOption", "# x\r\n-state_forces -scene fibre\r\n", {"line 2", "one option on a line"}},
    {"TwoValues", "-domain_lower -1, -1, -1\n", {"line 1", "'-1,'", "quotes"}},
    {"OpenQuote", "-scene fibre\n\n-state_output \"open.h5\n-x \"y\n", {"line 3", "quote"}},
    {"OpenSingleQuote", "-scene fibre\n-state_output 'open.h5", {"line 2", "quote"}},
    {"TextBehindAQuote", "-state_output 'a'b\n", {"line 1", "after the quoted"}},
    {"QuotedName", "'-scene' fibre\n", {"line 1", "'-scene'"}},
    {"NulBytes", std::string("-scene fibre\n-ts_dt 2\0\n", 24), {"run.opts", "not a text file"}},
    {"Utf16", std::string("\xff\xfe-\0s\0c\0", 8), {"run.opts", "UTF-16"}},
    {"ControlCharacter", "-scene fib\x1bre\n", {"line 1", "control character"}},
    {"LongLine", "-scene fibre\n# " + std::string(2 << 20, 'x') + "\n", {"line 2", "1 MB"}},
    {"FileOfItself", "-options_file run.opts\n", {"include each other"}},
    {"NoFileNamed", "-scene fibre\n-options_file\n", {"line 2", "-options_file needs"}},
    {"MissingNestedFile", "-scene fibre\n-options_file no.opts\n", {"run.opts: line 2", "no.opts"}},
    {"FolderAsFile", "-options_file .\n", {"run.opts: line 1", "folder"}},
    {"PrefixLeftOpen", "-prefix_push fibre_\n-segments 5\n", {"run.opts", "-prefix_pop"}},
    {"PopWithoutPush", "-scene fibre\n-prefix_pop\n", {"line 2", "-prefix_push"}},
    {"BadAlias", "alias -new\n", {"line 1", "alias -new_name -option"}},
    {"YamlTab", "scene: fibre\n\tts_max_steps: 2\n", {"run.yaml: line 2"}, "run.yaml"},
    {"YamlWithoutValue", "scene: fibre\nts_max_steps\n", {"run.yaml: line "}, "run.yaml"},
    {"YamlWithoutBlank", "scene:fibre\n", {"run.yaml: line 1", "colon"}, "run.yaml"},
    {"YamlWithDash", "scene: fibre\n-ts_dt: 20\n", {"run.yaml: line 2", "without -"}, "run.yaml"},
    {"YamlOpenQuote", "scene: 'fibre\n", {"run.yaml: line "}, "run.yaml"},
    {"YamlOpenList", "scene: fibre\nbc: [a, b\n", {"run.yaml: line "}, "run.yaml"},
    {"YamlListOfLists", "domain_lower: [[1, 2], 3]\n", {"run.yaml: line 1"}, "run.yaml"},
    {"YamlCommaInList", "bc: ['a,b', c]\n", {"run.yaml: line 1", "comma"}, "run.yaml"},
    {"YamlNoUtf8", "scene: fibre\nx: \xff\xfe\n", {"run.yaml: line 2"}, "run.yaml"},
    {"YamlOfItself", "a: &a\n  b: *a\n", {"run.yaml: line ", "contain themselves"}, "run.yaml"},
    {"YamlUnknownAnchor", "a: *b\n", {"run.yaml: line 1"}, "run.yaml"},
    {"YamlInclude", "$$x: !include no.yaml\n", {"run.yaml: line 1", "options_file"}, "run.yaml"},
    {"YamlMapsOfMaps",
     [] {
       std::string text = "a0: &a0 {}\n";
       for (int k = 1; k <= 40; ++k)
         text += std::string("a") + std::to_string(k) + ": &a" + std::to_string(k) + " {<<: [*a" +
                 std::to_string(k - 1) + ", *a" + std::to_string(k - 1) + "]}\n";
       return text;
     }(),
     {"run.yaml: line ", "maps are merged"},
     "run.yaml"},
    {"YamlMissingNested", "options_file: no.opts\n", {"run.yaml: line 1", "no.opts"}, "run.yaml"},
};

class BadFile : public testing::TestWithParam<Case> {};

TEST_P(BadFile, IsRefusedWithItsLine) {
  const Folder folder;
  const Case& c = GetParam();
  writeText(folder / c.file, c.text);
  expectRefused(run(folder, "-options_file " + c.file + rest), c.fragments);
}

INSTANTIATE_TEST_SUITE_P(Options, BadFile, testing::ValuesIn(badFiles),
                         [](const auto& info) { return info.param.name; });

class OptionFilesOnRanks : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Options, OptionFilesOnRanks, testing::Values(1, 3));

TEST_P(OptionFilesOnRanks, StandardInputIsAFileOfOptions) {
  const Folder folder;
  writeText(folder / "run.opts", "-scene fibre\n-fibre_segments 5\n-fibre_strain 0.01\n");
  EXPECT_EQ(energies(run(folder, "-options_file /dev/stdin" + rest + "< run.opts", GetParam())),
            wanted());
}

TEST_P(OptionFilesOnRanks, ANamedPipeIsAFileOfOptions) {
  const Folder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const Outcome outcome =
      runBeside(folder, "-options_file pipe" + rest, GetParam(),
                "sleep 1; { printf -- '-scene fibre\\n-fibre_seg'; sleep 1; printf -- 'ments 5\\n"
                "-fibre_strain 0.01\\n'; } > pipe");
  EXPECT_EQ(energies(outcome), wanted());
}

TEST_P(OptionFilesOnRanks, YamlInAPipeIsReadToo) {
  const Folder folder;
  writeText(folder / "run.yaml", "scene: fibre\nfibre: {segments: 5, strain: 0.01}\n");
  EXPECT_EQ(
      energies(run(folder, "-options_file_yaml /dev/stdin" + rest + "< run.yaml", GetParam())),
      wanted());
}

TEST_P(OptionFilesOnRanks, AFileEndsNoPrefixOfTheFileThatNamesIt) {
  const Folder folder;
  writeText(folder / "run.opts",
            "-scene fibre\n-prefix_push fibre_\n-options_file more.opts\n-segments 5\n");
  writeText(folder / "more.opts", "-strain 0.01\n-prefix_pop\n");
  expectRefused(run(folder, "-options_file run.opts" + rest, GetParam()),
                {"more.opts: line 2", "-prefix_pop"});
}

TEST_P(OptionFilesOnRanks, ErrorsOfFilesComeOnce) {
  const Folder folder;
  writeText(folder / "run.opts", "-scene fibre\nrubbish\n");
  expectRefused(run(folder, "-options_file run.opts", GetParam()), {"run.opts: line 2"});
  expectRefused(run(folder, "-options_file_yaml nowhere.yaml", GetParam()), {"nowhere.yaml"});
  expectRefused(run(folder, "-options_file", GetParam()), {"-options_file needs the name"});
  expectRefused(run(folder, "-options_file /dev/zero", GetParam()), {"/dev/zero"});
  expectRefused(run(folder, "-scene fibre" + rest + "-malloc_debug perhaps", GetParam()),
                {"perhaps"});
  writeText(folder / ".petscrc", "-scene fibre\nrubbish\n");
  expectRefused(run(folder, "-scene fibre" + rest, GetParam()), {".petscrc: line 2"});
}

TEST(Sources, AnEndlessPipeIsGivenUp) {
  const Folder folder;
  ASSERT_EQ(mkfifo((folder / "endless").c_str(), 0600), 0);
  expectRefused(
      runBeside(folder, "-options_file endless" + rest, 1, "yes -- '-ts_dt 20' > endless"),
      {"endless", "64 MB"});
}

TEST(Sources, APipeIsReadOnceOnly) {
  const Folder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  expectRefused(runBeside(folder, "-options_file pipe -options_file pipe" + rest, 1,
                          "echo '-scene fibre' > pipe"),
                {"read before"});
}

TEST(Sources, EachWinsOverThoseBefore) {
  const Folder folder;
  // ~/.petscrc, .petscrc, petscrc, PETSC_OPTIONS, PETSC_OPTIONS_YAML, the command line.
  std::filesystem::create_directory(folder / "home");
  const Environment home("HOME", folder / "home");
  writeText(folder / "home/.petscrc", "-scene weave\n-fibre_segments 3\n-fibre_strain 0.04\n");
  writeText(folder / ".petscrc", "-scene fibre\n-fibre_segments 4\n-fibre_strain 0.05\n");
  writeText(folder / "petscrc", "-fibre_segments 6\n-fibre_strain 0.06\n");
  const Environment options("PETSC_OPTIONS", "-fibre_segments 5 -fibre_strain 0.07");
  const Environment yaml("PETSC_OPTIONS_YAML", "fibre: {strain: 0.08}");
  writeText(folder / "run.opts", "-fibre_strain 0.01\n");
  EXPECT_EQ(energies(run(folder, "-fibre_strain 0.09 -options_file run.opts" + rest)), wanted());
  EXPECT_EQ(energies(run(folder, "-options_file run.opts -fibre_strain 0.01" + rest)), wanted());
  // Without the three files there is no scene.
  EXPECT_EQ(energies(run(folder, "-skip_petscrc -scene fibre -fibre_strain 0.01" + rest)),
            wanted());
}

TEST(Sources, ErrorsNameTheEnvironment) {
  const Folder folder;
  const std::string fibre = "-scene fibre" + rest;
  {
    const Environment options("PETSC_OPTIONS", "-options_file nowhere.opts");
    expectRefused(run(folder, fibre), {"PETSC_OPTIONS: ", "nowhere.opts"});
  }
  {
    const Environment options("PETSC_OPTIONS", "rubbish -ts_dt 5");
    expectRefused(run(folder, fibre), {"PETSC_OPTIONS: ", "'rubbish'"});
  }
  {
    const Environment options("PETSC_OPTIONS", "-state_output 'open");
    expectRefused(run(folder, fibre), {"PETSC_OPTIONS: ", "quote"});
  }
  {
    const Environment options("PETSC_OPTIONS", "-skip_petscrc");
    expectRefused(run(folder, fibre), {"PETSC_OPTIONS: -skip_petscrc", "command line only"});
  }
  writeText(folder / "run.opts", "-skip_petscrc\n");
  expectRefused(run(folder, fibre + " -options_file run.opts"),
                {"run.opts: line 1: -skip_petscrc"});
  const Environment yaml("PETSC_OPTIONS_YAML", "ts_dt");
  expectRefused(run(folder, fibre), {"PETSC_OPTIONS_YAML: line 1"});
}

TEST(Sources, NamesOfFilesKeepTheirCharacters) {
  for (const auto& [written, name] : std::vector<std::pair<std::string, std::string>>{
           {"run#1.h5", "run#1.h5"},
           {"'my res.h5'", "my res.h5"},
           {"\"it's 1 # 2.h5\"", "it's 1 # 2.h5"},
           {"it's.h5", "it's.h5"},
           {"'-dash.h5'", "-dash.h5"},
           {"\xc3\xa9t\xc3\xa9.h5", "\xc3\xa9t\xc3\xa9.h5"},
           {"a\\b.h5", "a\\b.h5"}}) {
    const Folder folder;
    writeText(folder / "run.opts", "-scene fibre\n-state_output " + written + "\n");
    const Outcome outcome = run(folder, "-options_file run.opts" + rest);
    EXPECT_EQ(outcome.status, 0) << written << ": " << outcome.output;
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << written;
  }
}

TEST(Sources, PetscsOwnOptionsAreHeard) {
  const Folder folder;
  writeText(folder / "run.opts", "-scene fibre\n-log_view :log.txt\n-options_view\n");
  const Outcome outcome = run(folder, "-options_file run.opts" + rest);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(readFile(folder / "log.txt").find("NwKickDrift"), std::string::npos);
  EXPECT_NE(outcome.output.find("Option Table"), std::string::npos) << outcome.output;
}

TEST(Arguments, WordsThatAreNoOptionsAreRefused) {
  const Folder folder;
  expectRefused(run(folder, "run.opts"), {"'run.opts'", "-options_file NAME"});
  expectRefused(run(folder, "-ts_dt 20 30"), {"'30'"});
  expectRefused(run(folder, "-- -ts_dt 20"), {"'--'"});
  expectRefused(run(folder, "--ts_dt 20"), {"'--ts_dt'", "one -"});
  expectRefused(run(folder, "-ts_dt=20"), {"-ts_dt 20"});
}

class Questions : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Options, Questions, testing::Values(1, 3));

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST_P(Questions, HelpIsOursFirst) {
  const Folder folder;
  for (const char* question : {"--help", "-h"}) {
    const Outcome brief = run(folder, question, GetParam());
    EXPECT_EQ(brief.status, 0) << brief.output;
    EXPECT_TRUE(brief.output.starts_with("nanoweft: ")) << brief.output;
    EXPECT_EQ(count(brief.output, "  -ts_dt <"), 1U);
    EXPECT_EQ(brief.output.find("-log_view"), std::string::npos) << brief.output;
  }
  const Outcome help = run(folder, "-help", GetParam());
  EXPECT_EQ(help.status, 0) << help.output;
  EXPECT_TRUE(help.output.starts_with("nanoweft: ")) << help.output;
  EXPECT_EQ(count(help.output, "  -ts_dt <"), 1U);
  EXPECT_LT(help.output.find("  -ts_dt <"), help.output.find("-log_view"));
  EXPECT_NE(help.output.find("-log_view"), std::string::npos) << help.output;
}

TEST_P(Questions, TheVersionsAreTwoLines) {
  const Folder folder;
  for (const char* question : {"--version", "-version", "-scene weave --version"}) {
    const Outcome version = run(folder, question, GetParam());
    EXPECT_EQ(version.status, 0) << version.output;
    EXPECT_TRUE(version.output.starts_with("nanoweft " NANOWEFT_VERSION "\n")) << version.output;
    EXPECT_EQ(std::ranges::count(version.output, '\n'), 2) << version.output;
    for (const char* part : {"PETSc 3.", "Open MPI", "HDF5 1."})
      EXPECT_NE(version.output.find(part), std::string::npos) << version.output;
  }
}

TEST(Durations, AreReadAsSlurmWritesThem) {
  EXPECT_EQ(parseDuration("90"), 90.0);
  EXPECT_EQ(parseDuration("1.5"), 1.5);
  EXPECT_EQ(parseDuration("90:30"), 5430.0);
  EXPECT_EQ(parseDuration("1:02:03"), 3723.0);
  EXPECT_EQ(parseDuration("100:00:00"), 360000.0);
  EXPECT_EQ(parseDuration("1-02:03:04"), 93784.0);
  EXPECT_EQ(parseDuration("2-12"), 216000.0);
  EXPECT_EQ(parseDuration("2-12:30"), 217800.0);
  for (const char* wrong : {"", "x", "1:", ":1", "1:60", "1:2:3:4", "1-", "-1", "1-24:00:00", "1h",
                            "1:60:00", "1e3", "inf", "1.5:00", "1 2"})
    EXPECT_FALSE(parseDuration(wrong)) << wrong;
  EXPECT_EQ(shownDuration(93784.2), "26:03:04");
}

}  // namespace
