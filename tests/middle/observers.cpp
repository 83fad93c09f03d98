/// Observers: what they ask for, what they say of the run, what they write down.
#include "nanoweft/app/observers.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "middle/tubes.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/motion/verlet.hpp"

namespace nanoweft::test {
namespace {

/// Notes what it is asked to write.
class Book : public RunBook {
 public:
  RunRecord stageRecord(const char*) const override { return {}; }
  RunRecord fullRecord(const char*) const override { return {}; }
  void sync() override {}
  void writeCheckpoint(const std::string& file) override {
    written.push_back(file);
    last = step;
  }
  std::int64_t lastCheckpoint() const override { return last; }
  double checkpointSeconds() const override { return seconds; }

  std::vector<std::string> written;
  std::int64_t step = 0, last = -1;
  double seconds = 0;
};

class ObserverTest : public testing::Test {
 protected:
  ObserverContext context() {
    return {settings, nanoUnits(), tubes.boundaries, kinds, tubes.forces->pairs(), walls, held};
  }
  static BoxDrive noDrive() {
    Options options;
    return BoxDrive(options, nanoUnits());
  }
  const Kinds kinds = cnt1010(nanoUnits());
  const Walls walls;
  BoxDrive held = noDrive();
  /// The moment at which a step ends.
  Moment at(std::int64_t step) {
    tubes.state.step = book.step = step;
    tubes.state.time = verlet.dt() * static_cast<double>(step);
    return {system, verlet, limits, energies, &energies, book};
  }
  static RunRecord recordOf(const Observer& observer) {
    RunRecord record;
    observer.saveStage(record);
    observer.save(record);
    return record;
  }

  Tubes tubes;
  System system = tubes.system();
  Verlet verlet{10, 0.0};
  StepLimits limits;
  Energies energies;
  Book book;
  RunSettings settings;
};

TEST_F(ObserverTest, EndsAreSeenWithTheirEnergies) {
  settings.maxSteps = 30;
  const auto ends = makeEnds(context());
  EXPECT_EQ(ends->verdict(at(29)), Verdict::goOn);
  EXPECT_EQ(ends->view(at(29)), View::positions);
  EXPECT_EQ(ends->verdict(at(30)), Verdict::done);
  EXPECT_EQ(ends->view(at(30)), View::energies);
  EXPECT_EQ(ends->endReached(at(29)), "");
  EXPECT_NE(ends->endReached(at(31)), "");
}

TEST_F(ObserverTest, ATimeEndsTheRunInTheStepThatIsNearest) {
  settings.maxTime = 104;
  const auto ends = makeEnds(context());
  EXPECT_EQ(ends->verdict(at(9)), Verdict::goOn);
  EXPECT_EQ(ends->verdict(at(10)), Verdict::done);
}

TEST_F(ObserverTest, RelaxationComparesEnergiesAnIntervalApart) {
  settings.relaxTolerance = 0.1;
  settings.relaxInterval = 5;
  const auto relaxation = makeRelaxation(context());
  energies.bending = 100;
  relaxation->begin(at(0));
  EXPECT_EQ(relaxation->view(at(4)), View::positions);
  EXPECT_EQ(relaxation->view(at(5)), View::energies);
  energies.bending = 80;
  relaxation->observe(at(5));
  EXPECT_EQ(relaxation->verdict(at(5)), Verdict::goOn);
  energies.bending = 79;
  relaxation->observe(at(7));  // not due
  EXPECT_EQ(relaxation->verdict(at(7)), Verdict::goOn);
  energies.bending = 75;
  relaxation->observe(at(10));
  EXPECT_EQ(relaxation->verdict(at(10)), Verdict::done);
  EXPECT_NE(relaxation->reason(), "");
}

TEST_F(ObserverTest, AConvergedRunIsOverUnlessMoreIsAskedOfItsRestart) {
  settings.relaxTolerance = 0.1;
  settings.relaxInterval = 5;
  const auto first = makeRelaxation(context());
  energies.bending = 100;
  first->begin(at(0));
  first->observe(at(5));
  ASSERT_EQ(first->verdict(at(5)), Verdict::done);
  const RunRecord record = recordOf(*first);
  auto restarted = [&](double tolerance, long interval) {
    settings.relaxTolerance = tolerance;
    settings.relaxInterval = interval;
    const auto second = makeRelaxation(context());
    second->restore(record);
    return second->verdict(at(5));
  };
  EXPECT_EQ(restarted(0.1, 5), Verdict::done);
  EXPECT_EQ(restarted(0.2, 5), Verdict::done);
  EXPECT_EQ(restarted(0.01, 5), Verdict::goOn);
  EXPECT_EQ(restarted(0.1, 10), Verdict::goOn);
  EXPECT_EQ(restarted(0, 5), Verdict::goOn);
  EXPECT_THROW(makeRelaxation(context())->restore(RunRecord{}), InputError);
}

TEST_F(ObserverTest, ARestartComparesWithTheEnergyBeforeIt) {
  settings.relaxTolerance = 0.1;
  settings.relaxInterval = 5;
  const auto first = makeRelaxation(context());
  energies.bending = 100;
  first->begin(at(0));
  const auto second = makeRelaxation(context());
  second->restore(recordOf(*first));
  energies.bending = 95;
  second->observe(at(5));
  EXPECT_EQ(second->verdict(at(5)), Verdict::done);
  const auto third = makeRelaxation(context());
  third->restore(recordOf(*first));
  energies.bending = 80;
  third->observe(at(5));
  EXPECT_EQ(third->verdict(at(5)), Verdict::goOn);
}

TEST_F(ObserverTest, BalanceLooksAtForcesThatNothingHolds) {
  EXPECT_EQ(makeBalance(context()), nullptr);
  tubes.evaluate();
  settings.relaxForce = 1e-9;
  const auto never = makeBalance(context());
  settings.relaxForce = 1e9;
  const auto always = makeBalance(context());
  EXPECT_EQ(always->view(at(13)), View::positions);
  EXPECT_EQ(always->view(at(20)), View::motion);
  for (const auto& balance : {never.get(), always.get()}) balance->observe(at(20));
  EXPECT_EQ(never->verdict(at(20)), Verdict::goOn);
  EXPECT_EQ(always->verdict(at(20)), Verdict::done);
}

TEST_F(ObserverTest, CheckpointsAreWrittenWhenDueAndOnceAtTheEnd) {
  EXPECT_EQ(makeCheckpoints(context()), nullptr);
  settings.checkpointFile = "c.h5";
  settings.checkpointInterval = 10;
  const auto checkpoints = makeCheckpoints(context());
  checkpoints->observe(at(15));
  EXPECT_TRUE(book.written.empty());
  checkpoints->observe(at(20));
  checkpoints->finish(at(20));
  EXPECT_EQ(book.written, std::vector<std::string>{"c.h5"});
  checkpoints->finish(at(23));
  EXPECT_EQ(book.written.size(), 2);
}

TEST_F(ObserverTest, TheWallTimeKeepsWhatACheckpointTakes) {
  EXPECT_EQ(makeWallTimeStop(context()), nullptr);
  settings.wallTime = 1e6;
  const auto stop = makeWallTimeStop(context());
  EXPECT_FALSE(stop->wishes(at(1)));
  book.seconds = 2e6;
  // Rank 0 decides for all.
  EXPECT_EQ(stop->wishes(at(2)), tubes.state.rank() == 0);
  EXPECT_EQ(stop->verdict(at(2)), Verdict::goOn);
  stop->hear();
  EXPECT_EQ(stop->verdict(at(2)), Verdict::stop);
  EXPECT_EQ(stop->view(at(2)), View::motion);
}

TEST_F(ObserverTest, TheStepWatchNotesTheLowestLimit) {
  settings.limitInterval = 10;
  tubes.evaluate();
  const auto watch = makeStepWatch(context());
  limits.note(1e9);
  watch->observe(at(5));
  EXPECT_EQ(limits.present, 1e9);
  watch->observe(at(10));
  EXPECT_GT(limits.present, 20);
  EXPECT_LT(limits.present, 60);
  EXPECT_EQ(limits.lowest, limits.present);
  EXPECT_EQ(limits.first, 1e9);
}

TEST_F(ObserverTest, EnergyOutOfNothingEndsTheRun) {
  settings.energyAlarm = 0.25;
  const auto watch = makeEnergyWatch(context());
  Energies first;
  first.bending = 100;
  energies = first;
  const Moment moment{system, verlet, limits, first, &energies, book};
  watch->begin(moment);
  watch->observe(moment);
  energies.kinetic = 20;
  watch->observe(moment);
  energies.kinetic = 30;
  EXPECT_THROW(watch->observe(moment), RunError);
  energies.kinetic = 20;
  energies.pair = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(watch->observe(moment), RunError);
}

TEST_F(ObserverTest, TheListBeginsWithWhatDoubtsTheNumbers) {
  settings.checkpointFile = "c.h5";
  settings.stateOutput = "final.h5";
  settings.wallTime = 100;
  Options options;
  const Observers all = makeObservers(options, context());
  std::vector<std::string> outputs;
  for (const auto& observer : all)
    for (const auto& output : observer->outputs())
      if (!output.name.empty()) outputs.push_back(output.option);
  EXPECT_EQ(outputs, (std::vector<std::string>{"checkpoint_file", "state_output"}));
  // Energies that are no numbers end the run before anything is written.
  energies.pair = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(all.front()->observe(at(100)), RunError);
}

}  // namespace
}  // namespace nanoweft::test
