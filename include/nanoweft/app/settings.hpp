/// The options of a run that belong to no module: what to start from, when to end, what to write.
#pragma once

#include <optional>
#include <string>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/motion/stepper.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

struct RunSettings {
  std::optional<double> dt;
  bool unsafeStep = false;
  long limitInterval = 20000;  ///< 0: the stable step is estimated at the start only
  double energyAlarm = 0.25;   ///< 0: off
  std::optional<long> maxSteps;
  std::optional<double> maxTime;
  std::optional<double> wallTime;        ///< seconds since the program's start
  const StepperKind* stepper = nullptr;  ///< -relax_method
  double relaxTolerance = 0;             ///< 0: does not end the run
  double relaxForce = 0;                 ///< 0: does not end the run
  long relaxInterval = 5000;
  std::optional<double> fireMaxMove;

  double damping = 0;
  ViscousDamping viscous;
  std::optional<Thermostat> thermostat;
  double skin = 0;
  bool allowOverlap = false;
  PartitionSettings partition;
  int lateFrom = 128;       ///< ranks that may hear of each other a step late
  bool allThreads = false;  ///< also where other programs take their cores
  std::uint64_t seed = 1;
  double perturb = 0;
  bool startUnchecked = false;  ///< bonds far from rest do not end the run

  long monitorInterval = 100;
  double progressSeconds = 5;
  std::string snapshotFile, checkpointFile, stateOutput;
  long snapshotInterval = 0, checkpointInterval = 0;
  bool stateForces = false;
  bool overwrite = false;  ///< results of other runs may be replaced

  bool minimises() const { return stepper && stepper->minimises; }
};

/// Reads -restart, the checkpoint to go on from (empty: a new run). To be read before all others,
/// since it brings options along.
std::string readRestart(Options& options);
/// Reads -units next, since all others depend on it.
const UnitSystem& readUnits(Options& options);
/// Throws InputError unless all ranks run the program for the same instruction set: sums in vectors
/// of other lengths have other last bits. Collective.
void requireSameInstructions(MPI_Comm comm, const std::string& own);
RunSettings readRunSettings(Options& options, const UnitSystem& units, bool pairs);
/// Replaces what -domain_lower, -domain_upper and -domain_periodic say.
void readDomain(Options& options, const UnitSystem& units, Box& box);

}  // namespace nanoweft
