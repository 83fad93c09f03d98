/// Tables of monitors and snapshots with their index: no row is lost, none is torn or twice, and
/// nothing that another run or a person has written is replaced.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <sstream>

#include "support/expect.hpp"
#include "support/program.hpp"

namespace nanoweft::test {
namespace {

namespace fs = std::filesystem;

const std::string weave =
    "-scene weave -weave_fibres 2,2 -weave_segments 12 -damping_local 0.3 -progress_interval 0 ";
const std::string table = weave + "-energy_monitor ascii:e.csv -monitor_interval 10 ";

using Lines = std::vector<std::string>;

Lines linesOf(const std::string& text) {
  Lines lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string joined(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// The line of a step.
std::size_t rowOf(const Lines& lines, int step) {
  const std::string begin = std::to_string(step) + ",";
  const auto found =
      std::ranges::find_if(lines, [&](const std::string& line) { return line.starts_with(begin); });
  EXPECT_NE(found, lines.end()) << step;
  return static_cast<std::size_t>(found - lines.begin());
}

Lines stepsIn(const std::string& file) {
  Lines steps;
  for (const std::string& line : linesOf(readFile(file)))
    if (std::isdigit(static_cast<unsigned char>(line[0])))
      steps.push_back(line.substr(0, line.find(',')));
  return steps;
}

/// No temporary file is left.
void expectNoLitter(const Folder& folder) {
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name.find("tmp") == std::string::npos && !name.starts_with(".")) << name;
  }
}

/// What another run would have left: the same file with another option in its head.
void pretendAnotherRun(const std::string& file) {
  Lines lines = linesOf(readFile(file));
  lines.insert(lines.begin() + 1, "# -zz_of_another_run 1");
  writeText(file, joined(lines));
}

TEST(Tables, SayAtTheirHeadWhichRunWroteThem) {
  const Folder folder;
  expectDone(run(folder, table + "-ts_max_steps 25"));
  const Lines lines = linesOf(readFile(folder / "e.csv"));
  EXPECT_TRUE(lines[0].starts_with("# nanoweft ")) << lines[0];
  const auto columns =
      std::ranges::find_if(lines, [](const std::string& line) { return line[0] != '#'; });
  EXPECT_EQ(*(columns - 1), "# rows every 10 steps from step 0");
  EXPECT_TRUE(columns->starts_with("step,time_fs,stretch,")) << *columns;
  EXPECT_EQ(stepsIn(folder / "e.csv"), (Lines{"0", "10", "20", "25"}));
  expectNoLitter(folder);
}

TEST(Tables, EverySpellingOfAViewerIsSafe) {
  const std::vector<std::string> foreign{
      "mine\n", "\nnotes of ten years\n", "# mine\nstep,a\n0,1\n", "\r\n", "#", "\n"};
  const std::vector<std::string> viewers{"ascii:t.csv",         ":t.csv",
                                         "ascii:t.csv:default", "ascii:t.csv:default:write",
                                         "ascii:t.csv::write",  ":./t.csv::write"};
  for (std::size_t k = 0; k < viewers.size(); ++k) {
    const std::string& viewer = viewers[k];
    SCOPED_TRACE(viewer);
    const Folder folder;
    const std::string options = weave + "-monitor_interval 10 -energy_monitor " + viewer + " ";
    writeText(folder / "t.csv", foreign[k]);
    for (const char* more : {"", "-overwrite "}) {
      expectRefused(run(folder, options + more + "-ts_max_steps 3"), {"will not replace"});
      EXPECT_EQ(readFile(folder / "t.csv"), foreign[k]);
    }
    writeText(folder / "t.csv", "");
    expectDone(run(folder, options + "-ts_max_steps 60"));
    const std::string whole = readFile(folder / "t.csv");
    expectDone(run(folder, options + "-ts_max_steps 25 -checkpoint_file c.h5"));
    EXPECT_EQ(stepsIn(folder / "t.csv"), (Lines{"0", "10", "20", "25"}));
    expectDone(run(folder, options + "-ts_max_steps 60 -restart c.h5"));
    EXPECT_EQ(readFile(folder / "t.csv"), whole);
  }
}

TEST(Tables, ViewersThatHoldNoTableAreRefused) {
  const Folder folder;
  for (const auto& [viewer, fragment] : std::vector<std::pair<std::string, std::string>>{
           {"t.csv", "as in ascii:t.csv"},
           {"xascii:t.csv", "ascii or draw"},
           {"ascii:a:b.csv", "no ':' in the name"},
           {"ascii:t.csv:default:read", "by write"},
           {"ascii:t.csv::append", "by write"},
           {"ascii:t.csv:default:write:more", "no ':' in the name"},
           {"ascii:t.csv.gz", "not compressed"}}) {
    SCOPED_TRACE(viewer);
    expectRefused(run(folder, weave + "-ts_max_steps 3 -energy_monitor " + viewer), {fragment});
  }
  for (const char* stream :
       {"ascii", "ascii:", "ascii:stdout", "ascii:/dev/stdout", "ascii:stderr"}) {
    const Outcome outcome = run(folder, weave + "-ts_max_steps 3 -energy_monitor " + stream);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("\n3,60,"), std::string::npos) << outcome.output;
  }
  expectDone(run(folder, weave + "-ts_max_steps 3 -energy_monitor ascii:/dev/null"));
}

TEST(Tables, OfAnotherRunAreReplacedOnlyWhenAsked) {
  const Folder folder;
  expectDone(run(folder, table + "-ts_max_steps 20"));
  const std::string own = readFile(folder / "e.csv");
  pretendAnotherRun(folder / "e.csv");
  const std::string other = readFile(folder / "e.csv");
  expectRefused(run(folder, table + "-ts_max_steps 20"), {"-zz_of_another_run 1"});
  EXPECT_EQ(readFile(folder / "e.csv"), other);
  expectDone(run(folder, table + "-ts_max_steps 20 -overwrite"));
  EXPECT_EQ(readFile(folder / "e.csv"), own);
  // A table of the other monitor, and one without a head.
  const std::string pull = "-tension_rate 1e-6 -stress_monitor ascii:e.csv ";
  expectRefused(run(folder, weave + pull + "-ts_max_steps 5"), {"no table of -stress_monitor"});
  Lines lines = linesOf(own);
  std::erase_if(lines, [](const std::string& line) { return line[0] == '#'; });
  writeText(folder / "e.csv", joined(lines));
  expectRefused(run(folder, table + "-ts_max_steps 20"), {"another run wrote it"});
  expectDone(run(folder, table + "-ts_max_steps 20 -overwrite"));
}

TEST(Tables, GoThroughLinksAndIntoRegularFilesAlone) {
  const Folder folder;
  fs::create_symlink("real.csv", folder / "e.csv");  // dangling
  expectDone(run(folder, table + "-ts_max_steps 20"));
  EXPECT_TRUE(fs::is_symlink(folder / "e.csv"));
  EXPECT_EQ(stepsIn(folder / "real.csv"), (Lines{"0", "10", "20"}));
  fs::permissions(folder / "real.csv", fs::perms(0640));
  expectDone(run(folder, table + "-ts_max_steps 20"));
  EXPECT_TRUE(fs::is_symlink(folder / "e.csv"));
  EXPECT_EQ(fs::status(folder / "real.csv").permissions(), fs::perms(0640));
  fs::remove(folder / "e.csv");
  ASSERT_EQ(mkfifo((folder / "e.csv").c_str(), 0600), 0);
  expectRefused(run(folder, table + "-ts_max_steps 20", 2), {"no regular file"});
  fs::remove(folder / "e.csv");
  fs::create_directory(folder / "e.csv");
  expectRefused(run(folder, table + "-ts_max_steps 20", 2), {"a folder"});
}

TEST(Tables, TwoOutputsInOneFileAreRefused) {
  const Folder folder;
  const std::string pull =
      weave + "-tension_rate 1e-6 -ts_max_steps 5 -energy_monitor ascii:a.csv ";
  fs::create_directory(folder / "sub");
  fs::create_symlink("a.csv", folder / "link.csv");
  for (const char* same : {"a.csv", "./a.csv", "sub/../a.csv", "link.csv"})
    expectRefused(run(folder, pull + "-stress_monitor ascii:" + same), {"the same file"});
  expectDone(run(folder, pull));
  fs::create_hard_link(folder / "a.csv", folder / "hard.csv");
  for (const char* same : {"a.csv", "hard.csv", "link.csv"})
    expectRefused(run(folder, pull + "-stress_monitor ascii:" + same), {"the same file"});
  expectRefused(run(folder, pull + "-checkpoint_file x.h5 -state_output ./x.h5"),
                {"the same file"});
  for (const char* same : {"st_0000000005.h5", "./st.xdmf"})
    expectRefused(run(folder, pull + "-snapshot_file st -state_output " + same),
                  {"-snapshot_file st makes"});
}

struct Damage {
  const char* name;
  std::function<std::string(Lines)> apply;
  const char* fragment;
};

/// A table with rows 0, 10, ..., 60 of a run whose checkpoint is of step 40.
class DamagedTables : public testing::TestWithParam<Damage> {};

const Damage harmful[] = {
    {"TornAtTheRestart",
     [](Lines l) {
       l.resize(rowOf(l, 40) + 1);
       const std::string text = joined(l);
       return text.substr(0, text.size() - 30);
     },
     "torn"},
    {"TornBeforeTheRestart",
     [](Lines l) {
       l.resize(rowOf(l, 20) + 1);
       const std::string text = joined(l);
       return text.substr(0, text.size() - 1);
     },
     "torn"},
    {"RowMissing",
     [](Lines l) {
       l.erase(l.begin() + static_cast<long>(rowOf(l, 20)));
       return joined(l);
     },
     "step 20 is missing"},
    {"FirstRowsMissing",
     [](Lines l) {
       const auto first = l.begin() + static_cast<long>(rowOf(l, 0));
       l.erase(first, first + 2);
       return joined(l);
     },
     "steps 0 to 10 are missing"},
    {"LastRowsMissing",
     [](Lines l) {
       l.resize(rowOf(l, 30));
       return joined(l);
     },
     "steps 30 to 40 are missing"},
    {"AllRowsMissing",
     [](Lines l) {
       l.resize(rowOf(l, 0));
       return joined(l);
     },
     "steps 0 to 40 are missing"},
    {"RowTwice",
     [](Lines l) {
       const std::size_t row = rowOf(l, 20);
       l.insert(l.begin() + static_cast<long>(row), l[row]);
       return joined(l);
     },
     "step 20 stands after step 20"},
    {"TableTwice",
     [](Lines l) {
       const Lines rows(l.begin() + static_cast<long>(rowOf(l, 0)), l.end());
       return joined(l) + joined(rows);
     },
     "step 0 stands after step 60"},
    {"RowsExchanged",
     [](Lines l) {
       std::swap(l[rowOf(l, 20)], l[rowOf(l, 30)]);
       return joined(l);
     },
     "is missing"},
    {"NoNumber",
     [](Lines l) {
       std::string& row = l[rowOf(l, 20)];
       row = row.substr(0, row.rfind(',')) + ",nan";
       return joined(l);
     },
     "finite numbers"},
    {"LettersBehindANumber",
     [](Lines l) {
       l[rowOf(l, 20)] += "x";
       return joined(l);
     },
     "finite numbers"},
    {"ColumnMissing",
     [](Lines l) {
       std::string& row = l[rowOf(l, 20)];
       row = row.substr(0, row.rfind(','));
       return joined(l);
     },
     "finite numbers"},
    {"ColumnTooMuch",
     [](Lines l) {
       l[rowOf(l, 20)] += ",1";
       return joined(l);
     },
     "finite numbers"},
    {"EmptyLine",
     [](Lines l) {
       l.insert(l.begin() + static_cast<long>(rowOf(l, 20)), "");
       return joined(l);
     },
     "finite numbers"},
    {"LineEndsOfAnotherSystem",
     [](Lines l) {
       for (std::size_t k = rowOf(l, 0); k < l.size(); ++k) l[k] += "\r";
       return joined(l);
     },
     "finite numbers"},
    {"RowThatDoesNotBelong",
     [](Lines l) {
       std::string row = l[rowOf(l, 20)];
       row[1] = '5';
       l.insert(l.begin() + static_cast<long>(rowOf(l, 30)), row);
       return joined(l);
     },
     "step 25 belongs there"},
    {"AnotherRun",
     [](Lines l) {
       l.insert(l.begin() + 1, "# -zz 1");
       return joined(l);
     },
     "another run wrote it"},
    {"NoTable", [](Lines) { return std::string("mine\n"); }, "no table of -energy_monitor"},
};

TEST_P(DamagedTables, AreNamedAndLeftAsTheyAre) {
  const Folder folder;
  expectDone(run(folder, table + "-ts_max_steps 40 -checkpoint_file c.h5"));
  expectDone(run(folder, table + "-ts_max_steps 60 -restart c.h5"));
  const std::string damaged = GetParam().apply(linesOf(readFile(folder / "e.csv")));
  writeText(folder / "e.csv", damaged);
  expectRefused(run(folder, table + "-ts_max_steps 60 -restart c.h5", 2), {GetParam().fragment});
  EXPECT_EQ(readFile(folder / "e.csv"), damaged);
  expectNoLitter(folder);
}

INSTANTIATE_TEST_SUITE_P(Tables, DamagedTables, testing::ValuesIn(harmful),
                         [](const auto& i) { return std::string(i.param.name); });

TEST(Tables, WithOtherColumnsAreReplacedOnlyWhenAsked) {
  const Folder folder;
  const std::string still = "-scene fibre -ts_max_steps 0 -energy_monitor ascii:e.csv ",
                    walls = still + "-walls w -w_point 0,0,-50 -w_axis 0,0,1 -w_modulus 1 ";
  expectDone(run(folder, still));
  expectRefused(run(folder, walls), {"with the columns of this run", "-overwrite"});
  expectDone(run(folder, walls + "-overwrite"));
}

TEST(Tables, WhatIsTornBeyondTheRestartComesAgain) {
  const Folder folder;
  expectDone(run(folder, table + "-ts_max_steps 40 -checkpoint_file c.h5"));
  expectDone(run(folder, table + "-ts_max_steps 60 -restart c.h5"));
  const std::string whole = readFile(folder / "e.csv");
  Lines lines = linesOf(whole);
  lines.resize(rowOf(lines, 50) + 1);
  const std::string upTo50 = joined(lines);
  for (const std::string& found :
       {upTo50.substr(0, upTo50.size() - 20), upTo50 + std::string(500, '\0'), upTo50 + "60,abc\n",
        whole + "70,1"}) {
    writeText(folder / "e.csv", found);
    expectDone(run(folder, table + "-ts_max_steps 60 -restart c.h5"));
    EXPECT_EQ(readFile(folder / "e.csv"), whole);
  }
}

/// The closing row of a run that is at its end stays, or comes again with the same bytes.
TEST(Tables, ClosingRowsAreNeverLost) {
  const std::string base = "-weave_fibres 4,4 -weave_segments 24 -progress_interval 0 ";
  const std::string pull =
      "-damping_local 0.4 -tension_rate 2e-5 -tension_ramp 2000 -tension_grip 40 "
      "-break_strain_mean 0.12 -break_strain_std 0.03 -ts_dt 15 -tension_max_strain 0.2103 "
      "-stress_monitor ascii:s.csv ";
  const std::string monitors = "-energy_monitor ascii:e.csv -monitor_interval 40 ";
  for (const std::string& options :
       {base + "-damping_local 0.3 -ts_max_steps 57 ",
        base + "-damping_viscous 20 -ts_max_steps 57 ",
        base + "-damping_local 0.3 -ts_max_time 1150 ", base + pull,
        base + "-relax_method fire -relax_force 0.5 -ts_max_steps 57 ",
        base + "-relax_method fire -relax_force 3 -ts_max_steps 5000 "}) {
    SCOPED_TRACE(options);
    const Folder folder;
    const std::string all = options + monitors + "-checkpoint_file c.h5 ";
    expectDone(run(folder, all, 2));
    std::vector<std::string> files{"e.csv"};
    if (fs::exists(folder / "s.csv")) files.push_back("s.csv");
    std::vector<std::string> whole;
    for (const std::string& file : files) whole.push_back(readFile(folder / file));
    expectDone(run(folder, all + "-restart c.h5"));
    for (std::size_t k = 0; k < files.size(); ++k) EXPECT_EQ(readFile(folder / files[k]), whole[k]);
    // As if killed before it was written.
    for (std::size_t k = 0; k < files.size(); ++k) {
      Lines lines = linesOf(whole[k]);
      const bool closes = std::stoi(lines.back()) % 40 != 0;
      if (closes) lines.pop_back();
      writeText(folder / files[k], joined(lines));
    }
    expectDone(run(folder, all + "-restart c.h5"));
    for (std::size_t k = 0; k < files.size(); ++k) EXPECT_EQ(readFile(folder / files[k]), whole[k]);
  }
}

TEST(Tables, AnotherIntervalAfterARestart) {
  const Folder folder;
  expectDone(run(folder, table + "-ts_max_steps 35 -checkpoint_file c.h5"));
  const std::string other = weave + "-energy_monitor ascii:e.csv -monitor_interval 4 ";
  expectDone(run(folder, other + "-ts_max_steps 50 -restart c.h5 -checkpoint_file d.h5"));
  const Lines want{"0", "10", "20", "30", "36", "40", "44", "48", "50"};
  EXPECT_EQ(stepsIn(folder / "e.csv"), want);
  EXPECT_NE(
      readFile(folder / "e.csv").find("# rows every 10 steps from step 0, every 4 from step 35\n"),
      std::string::npos);
  const std::string whole = readFile(folder / "e.csv");
  // Later restarts know of both intervals.
  expectDone(run(folder, other + "-ts_max_steps 50 -restart d.h5"));
  EXPECT_EQ(readFile(folder / "e.csv"), whole);
  Lines lines = linesOf(whole);
  lines.erase(lines.begin() + static_cast<long>(rowOf(lines, 44)));
  writeText(folder / "e.csv", joined(lines));
  expectRefused(run(folder, other + "-ts_max_steps 60 -restart d.h5"), {"step 44 is missing"});
  // And one before the change forgets it.
  expectDone(run(folder, table + "-ts_max_steps 50 -restart c.h5"));
  EXPECT_EQ(stepsIn(folder / "e.csv"), (Lines{"0", "10", "20", "30", "40", "50"}));
}

TEST(Tables, NewOnesBeginAtTheRestart) {
  const Folder folder;
  expectDone(run(folder, weave + "-ts_max_steps 25 -checkpoint_file c.h5"));
  const Outcome outcome =
      run(folder, table + "-ts_max_steps 40 -restart c.h5 -checkpoint_file d.h5", 2);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("warning: there are no earlier rows"), std::string::npos)
      << outcome.output;
  EXPECT_EQ(stepsIn(folder / "e.csv"), (Lines{"25", "30", "40"}));
  const Outcome next = run(folder, table + "-ts_max_steps 60 -restart d.h5");
  EXPECT_EQ(next.output.find("warning"), std::string::npos) << next.output;
  EXPECT_EQ(stepsIn(folder / "e.csv"), (Lines{"25", "30", "40", "50", "60"}));
}

TEST(Tables, AKillWhileARestartOpensThemLosesNothing) {
  const Folder folder;
  const std::string options = weave + "-energy_monitor ascii:e.csv -monitor_interval 1 ";
  expectDone(run(folder, options + "-ts_max_steps 3000 -checkpoint_file c.h5"));
  expectDone(run(folder, options + "-ts_max_steps 3040 -restart c.h5"));
  // With rows beyond the restart, so that the content has to change.
  const std::string whole = readFile(folder / "e.csv");
  const std::string kept = whole.substr(0, whole.find("\n3000,") + 1);
  // The last one once the table has been changed.
  writeText(folder / "whole.csv", whole);
  const std::string changed =
      "while kill -0 $PID && cmp -s e.csv whole.csv; do :; done; kill -9 $(pgrep -P $PID) $PID";
  for (const char* moment :
       {"0.02", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.4", "0.5", "changed"}) {
    writeText(folder / "e.csv", whole);
    runBeside(folder, options + "-ts_max_steps 400000 -restart c.h5", 1,
              moment == std::string("changed")
                  ? changed
                  : std::string("sleep ") + moment + "; kill -9 $(pgrep -P $PID) $PID");
    EXPECT_TRUE(readFile(folder / "e.csv").starts_with(kept)) << moment;
  }
  EXPECT_NE(readFile(folder / "e.csv"), whole) << "the last one was killed too early";
  expectDone(run(folder, options + "-ts_max_steps 3040 -restart c.h5"));
  EXPECT_EQ(readFile(folder / "e.csv"), whole);
}

/// Two runs at the same time.
struct TwoOutcomes {
  Outcome first, second;
};
/// Runs `options`, and beside it `second` in another folder's out.txt once the first is running;
/// the first is stopped then.
TwoOutcomes runTwo(const Folder& folder, const std::string& options, const std::string& second) {
  const Outcome first =
      runBeside(folder, options + " -progress_interval 0.05", 1,
                "for i in $(seq 1200); do grep -q ns/day out.txt && break; sleep 0.05; done; " +
                    environment(folder, 1, "second") + "; '" NANOWEFT_BINARY "' " + second +
                    " > second.txt 2>&1; echo $? > status.txt; kill -USR1 $PID");
  return {first, {std::stoi(readFile(folder / "status.txt")), readFile(folder / "second.txt")}};
}

TEST(Tables, TwoRunsAtTheSameTimeDoNotShareATable) {
  const Folder folder;
  const std::string options =
      "-weave_fibres 2,2 -weave_segments 12 -damping_local 0.3 -energy_monitor ascii:e.csv "
      "-monitor_interval 10 ";
  const auto [first, second] =
      runTwo(folder, options + "-ts_max_steps 100000000 -checkpoint_file c.h5",
             options + "-ts_max_steps 100");
  EXPECT_EQ(first.status, 3) << first.output;
  expectRefused(second, {"another run is writing it"});
  const std::string stopped = readFile(folder / "e.csv");
  const Lines steps = stepsIn(folder / "e.csv");
  ASSERT_GT(steps.size(), 1u);
  for (std::size_t k = 0; k + 1 < steps.size(); ++k) EXPECT_EQ(steps[k], std::to_string(10 * k));
  expectDone(run(folder, options + "-restart c.h5 -ts_max_steps 0"));
  EXPECT_TRUE(readFile(folder / "e.csv").starts_with(stopped));
}

TEST(Tables, TwoRunsAtTheSameTimeDoNotShareSnapshots) {
  const Folder folder;
  const std::string options =
      "-weave_fibres 2,2 -weave_segments 12 -damping_local 0.3 -snapshot_file st ";
  const auto [first, second] =
      runTwo(folder,
             options + "-snapshot_interval 100000000 -ts_max_steps 100000000 -checkpoint_file c.h5",
             options + "-ts_max_steps 100");
  EXPECT_EQ(first.status, 3) << first.output;
  expectRefused(second, {"another run is writing it"});
  EXPECT_NE(readFile(folder / "st.xdmf").find("st_0000000000.h5"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder / "st_0000000000.h5"));
}

TEST(Tables, AFailedWriteEndsTheRunAtOnce) {
  const Folder folder;
  const std::string options =
      "-weave_fibres 2,2 -weave_segments 12 -damping_local 0.3 -monitor_interval 10 "
      "-ts_max_steps 100000000 -energy_monitor ascii:";
  Outcome outcome = run(folder, options + "/dev/full", 2);
  EXPECT_EQ(outcome.status, 1) << outcome.output;
  EXPECT_NE(outcome.output.find("No space left on device"), std::string::npos) << outcome.output;
  // A folder that goes away.
  outcome = runBeside(folder, options + "sub/e.csv -progress_interval 0.05", 2,
                      "for i in $(seq 1200); do grep -q ns/day out.txt && break; sleep 0.05; done; "
                      "rm -r sub");
  EXPECT_EQ(outcome.status, 2) << outcome.output;
  EXPECT_NE(outcome.output.find("e.csv: it was removed"), std::string::npos) << outcome.output;
}

const std::string frames = weave + "-snapshot_file st -snapshot_interval 10 ";

TEST(SnapshotFiles, ThatAPersonMadeAreNotTouched) {
  const Folder folder;
  for (const char* name : {"st.xdmf.tmp", "st_0000000000.h5.tmp"})
    writeText(folder / name, "mine\n");
  expectDone(run(folder, frames + "-ts_max_steps 10"));
  for (const char* name : {"st.xdmf.tmp"}) EXPECT_EQ(readFile(folder / name), "mine\n");
  writeText(folder / "st.xdmf", "mine\n");
  expectRefused(run(folder, frames + "-ts_max_steps 10 -overwrite"), {"no index of snapshots"});
  EXPECT_EQ(readFile(folder / "st.xdmf"), "mine\n");
  fs::remove(folder / "st.xdmf");
  ASSERT_EQ(mkfifo((folder / "st.xdmf").c_str(), 0600), 0);
  expectRefused(run(folder, frames + "-ts_max_steps 10"), {"no regular file"});
}

TEST(SnapshotFiles, AnIndexOfAnotherRunIsReplacedOnlyWhenAsked) {
  const Folder folder;
  expectDone(run(folder, frames + "-ts_max_steps 10"));
  const std::string own = readFile(folder / "st.xdmf");
  Lines lines = linesOf(own);
  lines.insert(lines.begin() + 3, "# -zz 1");
  const std::string other = joined(lines);
  writeText(folder / "st.xdmf", other);
  expectRefused(run(folder, frames + "-ts_max_steps 10"), {"another run wrote it"});
  EXPECT_EQ(readFile(folder / "st.xdmf"), other);
  expectDone(run(folder, frames + "-ts_max_steps 10 -overwrite"));
  EXPECT_EQ(readFile(folder / "st.xdmf"), own);
}

TEST(SnapshotFiles, OfAnotherRunThatStayAreNamed) {
  const Folder folder;
  const std::string warning = "warning: snapshots of another run are still there";
  expectDone(run(folder, frames + "-ts_max_steps 60"));
  const std::string other = frames + "-damping_local 0.1 -overwrite -ts_max_steps ";
  Outcome outcome = run(folder, other + "40 -checkpoint_file c.h5", 2);
  expectDone(outcome);
  EXPECT_NE(outcome.output.find(warning), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("st_0000000050.h5 to st_0000000060.h5 (2 of them"),
            std::string::npos)
      << outcome.output;
  // Nothing is left of the other run; what a restart goes on from is its own.
  outcome = run(folder, other + "60 -restart c.h5 -ts_dt 12");
  expectDone(outcome);
  EXPECT_EQ(outcome.output.find(warning), std::string::npos) << outcome.output;
}

TEST(SnapshotFiles, ARestartListsThoseOfItsRunUpToItsStep) {
  const Folder folder, straight;
  expectDone(run(straight, frames + "-ts_max_steps 60"));
  expectDone(run(folder, frames + "-ts_max_steps 40 -checkpoint_file c.h5"));
  expectDone(run(folder, frames + "-ts_max_steps 60 -restart c.h5"));
  EXPECT_EQ(readFile(folder / "st.xdmf"), readFile(straight / "st.xdmf"));
  expectDone(run(folder, frames + "-ts_max_steps 40 -restart c.h5"));
  const std::string index = readFile(folder / "st.xdmf");
  EXPECT_NE(index.find("st_0000000040.h5"), std::string::npos);
  EXPECT_EQ(index.find("st_0000000050.h5"), std::string::npos);
}

TEST(SnapshotFiles, NamesThatNoIndexCanHoldAreRefused) {
  const Folder folder;
  for (const char* name :
       {"'a:b'", "'a|b'", "' a'", "'a\nb'", "'a\x01z'", "'a\xffz'", "'\xed\xa0\x80'", "sub/"})
    expectRefused(run(folder, weave + "-ts_max_steps 3 -snapshot_file " + name, 1),
                  {"-snapshot_file"});
}

TEST(Tables, ThatBeganAtARestartMayChangeTheirIntervalThere) {
  const Folder folder;
  expectDone(run(folder, weave + "-ts_max_steps 20 -checkpoint_file a.h5"));
  const std::string on = "-restart a.h5 -energy_monitor ascii:b.csv ";
  expectDone(run(folder, on + "-monitor_interval 10 -ts_max_steps 25"));
  expectDone(run(folder, on + "-overwrite -monitor_interval 5 -ts_max_steps 30"));
  EXPECT_NE(readFile(folder / "b.csv").find("# rows every 5 steps from step 20\n"),
            std::string::npos);
  expectDone(run(folder, on + "-monitor_interval 5 -ts_max_steps 40"));
  EXPECT_EQ(stepsIn(folder / "b.csv"), (Lines{"20", "25", "30", "35", "40"}));
}

}  // namespace
}  // namespace nanoweft::test
