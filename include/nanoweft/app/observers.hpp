/// The observers of a run, made from its options.
#pragma once

#include <memory>
#include <vector>

#include "nanoweft/app/settings.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "nanoweft/force/wall.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/motion/box_drive.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// What observers are made from; must outlive them.
struct ObserverContext {
  const RunSettings& settings;
  const UnitSystem& units;
  const Boundaries& boundaries;
  const Kinds& kinds;
  const PairForces& pairs;
  const Walls& walls;
  BoxDrive& boxDrive;
};

using Observers = std::vector<std::unique_ptr<Observer>>;

/// All that the options ask for, in the order in which they look at a moment. Reads the options of
/// those that have some of their own.
Observers makeObservers(Options& options, const ObserverContext& context);

// The makers; null: not wanted.

/// -energy_alarm: ends a run whose energies are no numbers or grow out of nothing.
std::unique_ptr<Observer> makeEnergyWatch(const ObserverContext& context);
/// Warns once when fibres have run into each other.
std::unique_ptr<Observer> makeContactWatch(const ObserverContext& context);
/// Warns once when a bond has flowed so far that its segments no longer stand for the fibre there.
std::unique_ptr<Observer> makeFlowWatch(const ObserverContext& context);
/// -ts_limit_interval: estimates the stable step anew and warns once when the run's is beyond it.
std::unique_ptr<Observer> makeStepWatch(const ObserverContext& context);
/// -relax_tolerance: ends a run whose elastic energy does not change any more.
std::unique_ptr<Observer> makeRelaxation(const ObserverContext& context);
/// -relax_force: ends a run where nothing feels a force.
std::unique_ptr<Observer> makeBalance(const ObserverContext& context);
/// -ts_max_steps, -ts_max_time, -tension_max_strain.
std::unique_ptr<Observer> makeEnds(const ObserverContext& context);
/// -progress_interval: prints a line now and then.
std::unique_ptr<Observer> makeProgress(const ObserverContext& context);
/// -checkpoint_file.
std::unique_ptr<Observer> makeCheckpoints(const ObserverContext& context);
/// -state_output.
std::unique_ptr<Observer> makeFinalState(const ObserverContext& context);
/// Signals stop a run.
std::unique_ptr<Observer> makeSignalStop(const ObserverContext& context);
/// -wall_time stops a run.
std::unique_ptr<Observer> makeWallTimeStop(const ObserverContext& context);

}  // namespace nanoweft
