/// The interface of observers: objects that look at a run while it goes on, write it down or end it
/// (tables, snapshots, checkpoints, progress, watches, ends).
///
/// A run calls all observers in the order of its list. A new one is one file and one line in
/// app/observers.cpp. All calls but `wishes` are made on all ranks alike, so they may be
/// collective.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/provenance.hpp"
#include "nanoweft/motion/step_limit.hpp"
#include "nanoweft/motion/stepper.hpp"
#include "nanoweft/motion/system.hpp"
#include "nanoweft/record/energies.hpp"
#include "nanoweft/state/output_target.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// How much of a step's end an observer looks at; each value includes those before it.
enum class View {
  positions,  ///< always there
  motion,     ///< velocities and forces of the step's end, too
  energies,   ///< and the energies
};

/// The run, for observers that write it down.
class RunBook {
 public:
  virtual ~RunBook() = default;
  /// What a snapshot says of the run: where it comes from, and what a later stage goes on with.
  virtual RunRecord stageRecord(const char* purpose) const = 0;
  /// The same and all that a restart needs. Collective.
  virtual RunRecord fullRecord(const char* purpose) const = 0;
  /// Returns when all that observers have written is on the disk. Throws RunError. Collective.
  virtual void sync() = 0;
  /// Throws RunError. Collective.
  virtual void writeCheckpoint(const std::string& file) = 0;
  /// Step of the last checkpoint that this process has written; -1: none.
  virtual std::int64_t lastCheckpoint() const = 0;
  /// Seconds that a checkpoint takes; a guess until one has been written.
  virtual double checkpointSeconds() const = 0;
};

/// A run at the end of a step, or at its start.
struct Moment {
  System& system;
  Stepper& stepper;
  StepLimits& limits;
  const Energies& first;     ///< of the first state
  const Energies* energies;  ///< null where no observer asked for them
  RunBook& book;

  const State& state() const { return system.state; }
  std::int64_t step() const { return system.state.step; }
};

/// What an observer has to say on whether the run goes on.
enum class Verdict {
  goOn,
  done,  ///< the run is over: the final state is written
  stop,  ///< the run is interrupted: a checkpoint is written
};

/// What observers need to know of the run before they touch their files.
struct OutputContext {
  MPI_Comm comm = MPI_COMM_NULL;
  ReplaceRule rule;
  bool restart = false;
  std::int64_t step = -1;  ///< that a restart goes on from
  bool over = false;       ///< the restarted run was over
  bool open = false;       ///< the box is periodic in no direction
};

class Observer {
 public:
  virtual ~Observer() = default;

  // Before the run.

  /// A file that it will write, or the name of several.
  struct Output {
    const char* option;
    std::string name;
    bool (*makes)(const std::string& name, const std::string& file) = nullptr;  ///< null: one file
  };
  virtual std::vector<Output> outputs() const { return {}; }
  /// Throws InputError for outputs that cannot be written or must not be replaced. Changes nothing.
  virtual void check(const OutputContext&) const {}
  /// Takes its files for this run alone. Throws InputError. Their content does not change yet.
  virtual void claim(const OutputContext&) {}
  virtual void open() {}
  /// `restore` takes up what a checkpoint says; `restoreStage` what the file of an earlier stage
  /// says whose tension test goes on. Both throw InputError for what is missing.
  virtual void restore(const RunRecord&) {}
  virtual void restoreStage(const RunRecord&) {}
  /// Why the restarted run has nothing to do, in words that follow its name; or nothing.
  virtual std::string endReached(const Moment&) const { return ""; }

  // During the run.

  /// At the first state, which has all energies.
  virtual void begin(const Moment&) {}
  /// Has this rank something to tell the others (a signal, the time)? If any rank has, `hear` is
  /// called on all ranks in the next step, before its forces are computed.
  virtual bool wishes(const Moment&) { return false; }
  virtual void hear() {}
  /// What it looks at in the step that is being made; State::step and time are those of its end.
  virtual View view(const Moment&) const { return View::positions; }
  virtual void observe(const Moment&) {}
  virtual Verdict verdict(const Moment&) const { return Verdict::goOn; }

  // At the end.

  /// The run is over: writes what belongs to its last state.
  virtual void finish(const Moment&) {}
  /// Why the run ends, for people; or nothing.
  virtual std::string reason() const { return ""; }
  /// Prints lines for the summary of a run that has made steps.
  virtual void summarise(const Moment&) const {}

  // Whenever a file for a later stage, or a checkpoint, is written.

  virtual void saveStage(RunRecord&) const {}
  virtual void save(RunRecord&) const {}
  /// Returns when all that it has written is on the disk. Throws RunError.
  virtual void sync() {}
};

/// Steps that are multiples of an interval.
inline bool isDue(const Moment& moment, long interval) {
  return moment.step() % interval == 0;
}

}  // namespace nanoweft
