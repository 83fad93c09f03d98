/// The loop of one run over its steps, from the first to the final state.
#pragma once

#include <memory>
#include <optional>

#include "nanoweft/app/last_checkpoint.hpp"
#include "nanoweft/app/notices.hpp"
#include "nanoweft/app/run_parts.hpp"
#include "nanoweft/motion/breakage.hpp"
#include "nanoweft/record/energies.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// How a run ended; the values are the exit statuses.
enum class Ending { done = 0, stopped = 3 };

class Simulation : private RunBook, private Agreement {
 public:
  /// Takes the output files. Throws InputError. Collective.
  explicit Simulation(std::unique_ptr<RunParts> parts);

  Ending run();

  /// The parts of the run, as they are.
  RunParts& parts() { return *parts_; }
  /// Energies of the last state for which an observer asked for them.
  const std::optional<Energies>& energies() const { return energies_; }

 private:
  Moment moment();
  Ending runToEnd();
  /// Evaluates the first state.
  void begin();
  void step();
  /// What moves or flows by itself before the segments move: rest shapes, the box, walls.
  void changeBetweenSteps();
  /// Where it is due, measures the stress for a box that is driven.
  void measureBox();
  /// Does what the ranks agreed on in the last step: draws the pairs or makes the lists anew, and
  /// hears wishes. What `drift` says of the lists then changes, too.
  void doAgreed(DriftReport& drift);
  /// Lets observers hear those of their wishes that the ranks have agreed on.
  void grant(int wishes);
  /// Waits for the notices of this step and does what they ask for.
  void hearAtOnce();
  /// Starts to tell the other ranks what this one has noticed or wishes.
  void tell(const DriftReport& drift);
  /// Must all ranks know what they have noticed before forces are computed?
  bool agreesFirst(View view) const;
  /// Makes the lists anew, or draws the pairs anew, where the notices ask for it.
  void renewLists();
  /// Evaluates the forces of a step.
  ForceOutcome evaluate(View view);
  View widestView();
  /// Takes up the outcome of an evaluation; `energies`: the outcome has them.
  void note(const ForceOutcome& outcome, bool energies);
  /// Evaluates the present state again where its energies are not known.
  void requireEnergies();
  Verdict verdict();
  /// Writes a checkpoint and says how to go on.
  Ending stopEarly();

  bool doubts() const override;
  bool listsHold() override;

  RunRecord stageRecord(const char* purpose) const override;
  RunRecord fullRecord(const char* purpose) const override;
  void sync() override;
  void writeCheckpoint(const std::string& file) override;
  std::int64_t lastCheckpoint() const override { return lastCheckpoint_; }
  double checkpointSeconds() const override { return checkpointSeconds_; }

  std::unique_ptr<RunParts> parts_;
  System system_;
  const Observers& observers_;
  Breaks breaks_;
  Notices notices_;
  double farthest_ = 0;               ///< ListKeeper::farthest of all ranks
  int heard_ = 0;                     ///< what the ranks agreed on last
  int agreed_ = 0;                    ///< the part of it that waits for the next step
  int granted_ = 0;                   ///< what this step does of it
  Energies first_;                    ///< of the first state
  std::optional<Energies> energies_;  ///< of the present state, when computed
  LastCheckpoint good_;
  std::int64_t lastCheckpoint_ = -1;
  double checkpointSeconds_;
  bool checkpointTimed_ = false;
  PetscLogEvent driftEvent_, kickEvent_, repeatEvent_, recordEvent_, fileEvent_;
};

}  // namespace nanoweft
