/// Ends from outside: signals and the wall time leave a checkpoint from which the run goes on as if
/// nothing had happened.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "nanoweft/app/last_checkpoint.hpp"
#include "nanoweft/app/signals.hpp"
#include "support/program.hpp"

using namespace nanoweft;
using namespace nanoweft::test;

namespace {

const std::string weave =
    "-scene weave -weave_fibres 4,4 -weave_segments 24 -damping_local 0.3 -progress_interval 0 ";
const std::string endless = weave + "-ts_max_steps 1000000000 ";

/// Shell commands that wait for `file` and then for some steps.
std::string once(const std::string& file) {
  return "for t in $(seq 600); do [ -e " + file + " ] && break; sleep 0.1; done; sleep 0.3; ";
}

// The first snapshot is written before the first step.
const std::string snapshots = "-snapshot_file s -snapshot_interval 1000000000 ";
const std::string begun = once("s_0000000000.h5");

/// The step that "... at step N; ..." names.
long stoppedAt(const std::string& output) {
  const auto at = output.find(" at step ");
  return at == std::string::npos ? -1 : std::atol(output.c_str() + at + 9);
}

/// The run wrote `file` at the step that it says, and goes on from there.
void expectGoesOn(const Folder& folder, const Outcome& stopped, const std::string& file) {
  EXPECT_EQ(stopped.status, 3) << stopped.output;
  EXPECT_NE(stopped.output.find("go on with -restart " + file), std::string::npos)
      << stopped.output;
  ASSERT_TRUE(std::filesystem::exists(folder / file)) << stopped.output;
  const long step = stoppedAt(stopped.output);
  EXPECT_GT(step, 0) << stopped.output;
  const Outcome on =
      run(folder, weave + "-ts_max_steps " + std::to_string(step + 2) + " -restart " + file);
  EXPECT_EQ(on.status, 0) << on.output;
  EXPECT_NE(on.output.find("steps 2,"), std::string::npos) << on.output;
}

/// As runBeside, without mpirun: $PID is the program itself, which meets all signals as in a
/// terminal unless `wrapper` says otherwise.
Outcome alone(const Folder& folder, const std::string& options, const std::string& beside,
              const std::string& wrapper = "env --default-signal") {
  std::ofstream(folder / "script.sh")
      << environment(folder) << '\n'
      << wrapper << " '" NANOWEFT_BINARY "' " << options << " > out.txt 2>&1 &\nPID=$!\n{ "
      << beside << "; } > beside.txt 2>&1\nwait $PID\n";
  const int status =
      std::system(("cd '" + folder.path().string() + "' && exec bash script.sh").c_str());
  return {WEXITSTATUS(status), readFile(folder / "out.txt")};
}

class StopSignal : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Signals, StopSignal,
                         testing::Values("INT", "HUP", "TERM", "USR1", "USR2", "XCPU"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(StopSignal, LeavesACheckpoint) {
  const Folder folder;
  const Outcome stopped = alone(folder, endless + snapshots + "-checkpoint_file c.h5",
                                begun + "kill -" + GetParam() + " $PID");
  EXPECT_NE(stopped.output.find("stopped by a signal"), std::string::npos) << stopped.output;
  expectGoesOn(folder, stopped, "c.h5");
}

TEST(Signals, WithoutANameLeaveACheckpointNamedByItsStep) {
  const Folder folder;
  const Outcome stopped = alone(folder, endless + snapshots, begun + "kill -TERM $PID");
  char name[40];
  std::snprintf(name, sizeof name, "checkpoint_%010ld.h5", stoppedAt(stopped.output));
  expectGoesOn(folder, stopped, name);
}

TEST(Signals, ToOneRankStopAll) {
  for (const char* name : {"INT", "USR1"}) {
    const Folder folder;
    const Outcome stopped = runBeside(folder, endless + snapshots + "-checkpoint_file c.h5", 3,
                                      begun + "kill -" + name + " $(pgrep -P $PID | tail -n 1)");
    expectGoesOn(folder, stopped, "c.h5");
  }
}

TEST_P(StopSignal, WhileOptionsAreReadEndsAtOnceWithNothingWritten) {
  const Folder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const Outcome stopped = alone(folder, endless + "-checkpoint_file c.h5 -options_file pipe",
                                std::string("sleep 2; kill -") + GetParam() + " $PID");
  EXPECT_EQ(stopped.status, 3) << stopped.output;
  EXPECT_NE(stopped.output.find("nothing has been computed"), std::string::npos) << stopped.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "c.h5"));
}

/// Every step takes longer than the interval.
TEST(Progress, AWishIsGrantedOnceAlsoWhenItIsHeardLate) {
  for (const auto& [agreement, lines] : {std::pair("at_once", 10), std::pair("late", 5)}) {
    const Folder folder;
    const Outcome done = run(folder,
                             std::string("-weave_fibres 4,4 -weave_segments 24 -ts_max_steps 10 "
                                         "-progress_interval 1e-6 -agreement ") +
                                 agreement,
                             2);
    int found = 0;
    for (auto at = done.output.find("\nstep "); at != std::string::npos;
         at = done.output.find("\nstep ", at + 1))
      ++found;
    EXPECT_EQ(found, lines) << done.output;
  }
}

TEST(Signals, ToMpirunIsPassedOn) {
  const Folder folder;
  expectGoesOn(folder,
               runBeside(folder, endless + snapshots + "-checkpoint_file c.h5", 3,
                         begun + "kill -USR1 $PID"),
               "c.h5");
}

TEST(Signals, UnderNohupAClosedTerminalDoesNotStopARun) {
  const Folder folder;
  const Outcome stopped = alone(folder, endless + snapshots + "-checkpoint_file c.h5",
                                begun +
                                    "kill -HUP $PID; sleep 1; kill -0 $PID && touch alive; "
                                    "kill -TERM $PID",
                                "env --default-signal --ignore-signal=HUP");
  EXPECT_TRUE(std::filesystem::exists(folder / "alive"));
  expectGoesOn(folder, stopped, "c.h5");
}

TEST(Signals, ACrashIsOneLine) {
  for (const char* name : {"SEGV", "BUS", "FPE", "ILL", "ABRT"}) {
    const Folder folder;
    const Outcome crashed = alone(folder, endless + snapshots, begun + "kill -" + name + " $PID");
    EXPECT_GT(crashed.status, 128) << crashed.output;
    const auto at =
        crashed.output.find("nanoweft: error: rank 0 crashed by SIG" + std::string(name));
    ASSERT_NE(at, std::string::npos) << crashed.output;
    EXPECT_EQ(crashed.output.find('\n', at), crashed.output.size() - 1) << crashed.output;
  }
}

TEST(Signals, AReaderThatGoesAwayDoesNotEndARun) {
  const Folder folder;
  const std::string command = "cd '" + folder.path().string() + "' && (" + environment(folder) +
                              "; '" NANOWEFT_BINARY "' " + weave +
                              "-ts_max_steps 50 -state_output final.h5; echo $? > status) | true";
  EXPECT_EQ(std::system(command.c_str()), 0);
  for (int k = 0; k < 600 && readFile(folder / "status").empty(); ++k) usleep(100000);
  EXPECT_EQ(readFile(folder / "status"), "0\n");
  EXPECT_TRUE(std::filesystem::exists(folder / "final.h5"));
}

TEST(SignalsDeathTest, ASecondInterruptEndsAtOnce) {
  EXPECT_EXIT(
      {
        std::signal(SIGINT, SIG_DFL);
        catchSignals();
        raise(SIGINT);
        if (stopRequested()) raise(SIGINT);
        std::_Exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(SignalsDeathTest, ATerminationSentTwiceWithinAMomentCountsOnce) {
  EXPECT_EXIT(
      {
        catchSignals();
        raise(SIGTERM);
        raise(SIGTERM);
        std::_Exit(stopRequested() ? 7 : 0);
      },
      testing::ExitedWithCode(7), "");
  EXPECT_EXIT(
      {
        catchSignals();
        raise(SIGTERM);
        sleep(3);
        raise(SIGTERM);
        std::_Exit(0);
      },
      testing::KilledBySignal(SIGTERM), "");
}

class SignalsOnRanks : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Ends, SignalsOnRanks, testing::Values(1, 3));

TEST_P(SignalsOnRanks, TheWallTimeLeavesACheckpoint) {
  const Folder folder;
  const Outcome stopped =
      run(folder, endless + "-checkpoint_file c.h5 -wall_time 0:06", GetParam());
  EXPECT_NE(stopped.output.find("stopped: the wall time of 0:00:06 is over"), std::string::npos)
      << stopped.output;
  expectGoesOn(folder, stopped, "c.h5");
}

TEST_P(SignalsOnRanks, WithoutANameOfItsOwnTheCheckpointTakesNoOtherFilesName) {
  const Folder folder;
  for (int step = 0; step < 20000; ++step) {
    char name[40];
    std::snprintf(name, sizeof name, "checkpoint_%010d.h5", step);
    writeText(folder / name, "of another run");
  }
  // Some hundred steps, fewer than there are files.
  const Outcome stopped = run(folder,
                              "-weave_fibres 60,60 -weave_segments 300 -ts_max_steps 1000000 "
                              "-wall_time 0:08",
                              GetParam());
  EXPECT_EQ(stopped.status, 3) << stopped.output;
  const auto at = stopped.output.find("go on with -restart checkpoint_");
  ASSERT_NE(at, std::string::npos) << stopped.output;
  EXPECT_NE(stopped.output.find("_2.h5", at), std::string::npos) << stopped.output;
}

TEST_P(SignalsOnRanks, AWallTimeThatIsNoTimeIsRefused) {
  const Folder folder;
  for (const char* wrong : {"1:99", "0", "soon", "''"}) {
    const Outcome outcome = run(folder, endless + "-wall_time " + wrong, GetParam());
    EXPECT_EQ(outcome.status, 1) << outcome.output;
    EXPECT_TRUE(outcome.output.starts_with("nanoweft: error: -wall_time")) << outcome.output;
  }
}

TEST_P(SignalsOnRanks, AFailedRestartNamesTheCheckpointThatIsGood) {
  const Folder folder;
  ASSERT_EQ(run(folder, weave + "-ts_max_steps 5 -checkpoint_file c.h5").status, 0);
  const Outcome failed =
      run(folder, weave + "-ts_max_steps 5000 -restart c.h5 -ts_dt 3000 -ts_dt_unsafe", GetParam());
  EXPECT_EQ(failed.status, 2) << failed.output;
  EXPECT_NE(failed.output.find("; the checkpoint c.h5 of step 5 is good\n"), std::string::npos)
      << failed.output;
}

TEST(LastCheckpoints, AreNamedAsTheyAre) {
  const Folder folder;
  LastCheckpoint last;
  EXPECT_EQ(last.sentence(), "there is no checkpoint");
  const std::string file = folder / "c.h5";
  writeText(file, "a");
  last.note(file, 40);
  EXPECT_EQ(last.sentence(), "the checkpoint " + file + " of step 40 is good");
  writeText(folder / "d.h5", "another");
  std::filesystem::rename(folder / "d.h5", file);
  EXPECT_EQ(last.sentence(),
            "the checkpoint " + file + " of step 40 has been changed by others since");
  std::filesystem::remove(file);
  EXPECT_EQ(last.sentence(), "the checkpoint " + file + " of step 40 has been removed since");
}

}  // namespace
