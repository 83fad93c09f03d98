/// What the options ask for, read and checked as far as that goes without segments.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "nanoweft/app/observers.hpp"
#include "nanoweft/app/settings.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/provenance.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/fibre/link_law.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "nanoweft/force/wall.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/motion/box_drive.hpp"
#include "nanoweft/scene/scene.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

struct RunPlan {
  /// Reads all options. Throws InputError. With -help it only learns what options there are.
  /// Collective.
  RunPlan(MPI_Comm comm, Options& options);
  RunPlan(const RunPlan&) = delete;
  RunPlan& operator=(const RunPlan&) = delete;

  /// Distance of two fibres of such kinds that touch. Only until `pairs` has been handed to the
  /// forces.
  double restDistance(int a, int b) const;
  /// Of the file that the state comes from, or null.
  const StateHeader* startHeader() const { return checkpoint ? &*checkpoint : scene->header(); }
  /// Does the state that the run starts from have links?
  bool linked() const;
  bool breaks() const { return breakage || (startHeader() && startHeader()->anyBroken); }
  bool minimises() const { return settings.stepper->minimises; }
  /// For a run whose first step is `step`: only the forces and energies of the start are wanted.
  bool evaluatesOnly(std::int64_t step) const {
    return settings.maxSteps && *settings.maxSteps <= step;
  }
  /// What observers need to know of the run; `over`: the restarted run was over.
  OutputContext outputContext(bool over) const;

  MPI_Comm comm;
  std::string restart;                    ///< file that the run goes on from; empty: a new run
  std::optional<StateHeader> checkpoint;  ///< of that file
  const UnitSystem& units;
  Kinds kinds;
  PairForces pairs;
  RunSettings settings;
  Breakage breakage;
  std::unique_ptr<Scene> scene;  ///< null in a restart
  LinkLaws links;
  Walls walls;
  Boundaries boundaries;
  BoxDrive boxDrive;
  Observers observers;
  Box box;
  Provenance provenance;
  bool stepIsNew = false;  ///< a restart was given another time step

 private:
  void readBox(Options& options);
  void refuseContradictions() const;
  void refuseForMinimiser() const;
  /// -relax_force, where something keeps the fibres from rest.
  void refuseWithoutRest() const;
  /// Walls that a periodic box cuts.
  void refuseWallsAcross() const;
  /// Prefixes of options must tell what they belong to.
  void refuseSharedNames() const;
  void refuseBesideShear() const;
  bool seeNewStep(const Options& options) const;
  /// Throws InputError when two outputs are one file.
  void requireDistinctOutputs() const;
};

}  // namespace nanoweft
