/// The parts of a run, put together from its plan: segments, forces, stepper, stable step.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nanoweft/app/run_plan.hpp"
#include "nanoweft/base/team_size.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/step_limit.hpp"
#include "nanoweft/motion/stepper.hpp"
#include "nanoweft/motion/system.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// The threads of a rank.
struct Team {
  int asked = 1;
  bool atMost = false;   ///< fewer when a small scene would not keep them busy
  int given = 1;         ///< by the runtime
  CoreWatch cores = {};  ///< since the start of this process, or of what uses it
};

struct RunParts {
  /// Makes or reads the segments and shares them among ranks. Throws InputError for a start that
  /// cannot be meant. Changes no file. Collective.
  RunParts(std::unique_ptr<RunPlan> plan, Team team);
  RunParts(const RunParts&) = delete;
  RunParts& operator=(const RunParts&) = delete;

  System system() { return {*state, *domain, *forces, plan->boundaries, accounts}; }
  bool evaluatesOnly() const { return plan->evaluatesOnly(state->step); }
  /// Numbers by which a later stage can tell whether its bonds are the same: for each kind radius,
  /// length, mass, inertia and B1 to B4.
  std::vector<double> fingerprint() const;
  /// The same of the rest shapes: for each kind twist and curvatures. Empty: all are straight.
  std::vector<double> restShapes() const;
  /// For each kind of link 1 for springs, else 0, and B1 to B4. Empty: there are no links.
  std::vector<double> linkNumbers() const;
  /// Name of `stage` in the record of a state file.
  static constexpr const char* stageName = "stage";

  std::unique_ptr<RunPlan> plan;
  Team team;
  std::optional<TeamSize> teamSize;
  std::unique_ptr<State> state;
  std::unique_ptr<Domain> domain;
  std::unique_ptr<ForceField> forces;
  std::unique_ptr<Stepper> stepper;
  EnergyAccounts accounts;
  StepLimits limits;
  std::optional<double> defaultStep;  ///< when the state chose the step
  std::int64_t stage = 0;  ///< how many runs of this program the state has gone through before
  double stepBefore = 0;   ///< of the checkpoint, where the step is new
  std::vector<std::string> warnings;  ///< of the start

 private:
  void makeForces();
  void fillState();
  void chooseTeam();
  /// Takes up what the checkpoint, or an earlier stage, says.
  void goOn();
  void restore(const RunRecord& record);
  /// Throws InputError for a tension test that is at its end when it begins.
  void refuseEnded(const Tension& tension, const RunRecord& record) const;
  void share();
  /// Refuses a start whose bonds are far from rest, or keeps a warning for the header.
  void checkStart();
  /// Keeps a warning for the header where images of a file tear fibres.
  void lookAtImages();
  void perturb();
  void refuseOverlap() const;
  /// Sets `stage`, and the seed of the thermostat.
  void findStage();
  /// -seed, for draws that a later stage must not repeat. Those of critical strains must stay.
  std::uint64_t stageSeed() const;
  /// Refuses a start whose pair forces are too large for the sums of ForceField.
  void refuseLargeSums() const;
  /// Keeps warnings for the header where no segment is of a kind, and where links that are to be
  /// made cannot join two kinds.
  void lookAtKinds();
  /// Keeps warnings for the header where a group is held along a direction in which the box moves,
  /// or loads what another one holds.
  void lookAtGroups();
  /// Keeps a warning for the header where a link is far from its rest.
  void lookAtLinks();
  void refuseLinksOfHalfTheBox() const;
  /// Refuses a start with fibres inside walls.
  void refuseInWalls() const;
  void chooseStep();
  double defaultTimeStep();
};

}  // namespace nanoweft
