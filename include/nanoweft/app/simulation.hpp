/// One run, from options to final state.
#pragma once

#include <memory>
#include <optional>

#include "nanoweft/app/last_checkpoint.hpp"
#include "nanoweft/app/settings.hpp"
#include "nanoweft/app/wall_time.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/provenance.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/motion/fire.hpp"
#include "nanoweft/motion/verlet.hpp"
#include "nanoweft/record/energies.hpp"
#include "nanoweft/record/snapshots.hpp"
#include "nanoweft/record/table_monitor.hpp"
#include "nanoweft/scene/scene.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// How a run ended; the values are the exit statuses.
enum class Ending { done = 0, stopped = 3 };

class Simulation {
 public:
  /// Reads all options and builds the run; throws InputError. `threads`: of each rank, or at most
  /// so many when a small scene would not keep them busy.
  Simulation(MPI_Comm comm, Options& options, int threads, bool atMost);

  /// With -help there is nothing to run.
  bool runnable() const { return state_ != nullptr; }
  Ending run();
  /// Where the run's results come from.
  const Provenance& provenance() const { return provenance_; }

 private:
  /// With fewer segments a thread waits longer for the others than it works.
  static constexpr std::int64_t segmentsPerThread = 1500;
  /// A guess on the safe side until a checkpoint has been timed: 200 bytes at 50 MB/s.
  static constexpr double secondsPerSegmentWritten = 4e-6;
  /// Steps between looks at the energy balance.
  static constexpr long energyCheckInterval = 100;
  /// Steps between looks at the depth of contacts.
  static constexpr long contactCheckInterval = 100;
  /// Steps between looks at the forces that nothing balances.
  static constexpr long balanceCheckInterval = 10;
  /// What ranks tell each other in each step, as bits.
  enum Notice {
    stale = 1,
    unstable = 2,
    stop = 4,
    progress = 8,
    broke = 16,
    released = 32,
    wallTime = 64
  };

  /// Of two fibres that touch; while the pair law has not been handed to the forces.
  double restDistance() const;
  /// Throws InputError when something keeps moving.
  void requireRest() const;
  /// Of the file that the state comes from, or null.
  const StateHeader* startHeader() const;
  /// Does a restart go on with another time step?
  void seeNewStep(const Options& options);
  void checkOutputs() const;
  /// Throws InputError when two outputs are one file.
  void requireDistinctOutputs() const;
  void build();
  void openOutputs();
  /// Refuses a start whose bonds are far from rest, or keeps a warning for the header.
  void checkStart();
  void perturb();
  void refuseOverlap() const;
  Ending runToEnd();
  /// Writes a checkpoint and says how to go on.
  Ending stopEarly();
  void begin();
  void step();
  /// Does anything need the velocities and forces of this step's end? (Energies, checkpoints, ends
  /// and progress all ask for energies.)
  bool endIsSeen(const ForceRequest& request) const;
  void checkBalance();
  int agreeOn(const DriftReport& drift);
  void record();
  void writeSnapshot();
  /// No step will be made: only the forces and energies of the start are wanted.
  bool evaluatesOnly() const;
  bool atEnd() const;
  /// At its end, or at rest.
  bool over() const { return atEnd() || converged_ || balanced_; }
  /// What there is to say of the checkpoint's run where it needs no step more.
  std::string endReached() const;
  bool due(long interval) const { return state_->step % interval == 0; }

  /// What any state file of this run says of it.
  RunRecord stageRecord(const char* purpose) const;
  /// What a run needs to go on from a checkpoint, besides. Collective.
  RunRecord runRecord(const char* purpose) const;
  /// Takes up what the checkpoint's record says. Throws InputError for what is missing.
  void goOn(const RunRecord& record);
  /// Takes up a tension test of an earlier stage. Throws InputError when there is nothing left to
  /// pull.
  void goOnPulling(const RunRecord& record);
  std::optional<Provenance> checkpointProvenance() const;
  ReplaceRule replaceRule() const;
  TableRun tableRun() const;
  Snapshots::Setting snapshotSetting() const;
  void writeCheckpoint(const std::string& file);

  double defaultStep();
  void chooseStep();
  /// Estimates the stable step anew and warns once when the run's is beyond it.
  void followLimit();
  /// Warns once when fibres have run into each other.
  void watchContacts();
  /// Ends a run whose energy grows.
  void watchEnergy();
  [[noreturn]] void reportInstability(const std::string& sign);

  void printHeader() const;
  void printRestart() const;
  void printFibre() const;
  void printPairForces() const;
  void printBreakage() const;
  void printProgress();
  void printSummary() const;
  void printDampingShare() const;
  double strain() const;

  MPI_Comm comm_;
  int threads_, threadsAsked_;  ///< the team that the runtime gives, and the one asked for
  bool threadsAtMost_;
  std::string restart_;  ///< checkpoint that the run goes on from; empty: a new run
  std::optional<StateHeader> restartHeader_;
  const UnitSystem& units_;
  Fibre fibre_;
  std::unique_ptr<PairForce> pairLaw_;
  RunSettings settings_;
  WallLimit wallLimit_;
  std::optional<BreakageLaw> breakage_;
  std::unique_ptr<Scene> scene_;
  Boundaries boundaries_;
  TableMonitor energyMonitor_, stressMonitor_;
  Box box_;
  Provenance provenance_;

  std::unique_ptr<State> state_;
  std::unique_ptr<Domain> domain_;
  std::unique_ptr<ForceField> forces_;
  std::optional<Verlet> verlet_;
  std::optional<Fire> fire_;
  std::optional<Snapshots> snapshots_;

  EnergyAccounts accounts_;
  ForceOutcome outcome_;
  std::optional<Energies> energies_;  ///< of the present step, when computed
  std::vector<std::int64_t> pendingBreaks_;
  bool releasedPairs_ = false, stopAsked_ = false, timeOver_ = false, converged_ = false,
       balanced_ = false;
  bool stepIsNew_ = false;   ///< a restart was given another time step
  double lastElastic_ = -1;  ///< at the last check of convergence
  std::int64_t lastCheckpoint_ = -1, firstStep_ = 0;
  double presentLimit_ = 0, lowestLimit_ = 0, firstLimit_ = 0, firstTime_ = 0, strength_ = 0,
         lastStress_ = 0;
  LastCheckpoint good_;
  std::optional<double> defaultStep_;  ///< when the state chose it
  bool limitWarned_ = false, contactWarned_ = false;
  std::vector<std::string> startWarnings_;
  Energies first_;        ///< of the first state
  double available_ = 0;  ///< energy that there was to turn into motion, at its most
  std::int64_t firstResolved_ = 0;
  double wallStart_ = 0, lastProgress_ = 0, progressWall_ = 0;
  std::int64_t progressStep_ = 0;
  PetscLogEvent driftEvent_, kickEvent_, recordEvent_, fileEvent_;
};

}  // namespace nanoweft
