#include "nanoweft/app/settings.hpp"

#include <algorithm>
#include <limits>

#include "nanoweft/app/wall_time.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/simd.hpp"

namespace nanoweft {

namespace {

constexpr long most = 9000000000000000;

std::optional<double> readWallTime(OptionSection& run) {
  const std::string text = run.text(
      "wall_time", "",
      "h:mm:ss, mm:ss, days-hh:mm:ss or seconds since the program's start after which the run has "
      "written a checkpoint and ended with status 3");
  if (text.empty()) return std::nullopt;
  const auto seconds = parseDuration(text);
  if (!seconds || *seconds <= 0)
    throw InputError("-wall_time '" + text +
                     "': expected a time such as 12:00:00 (h:mm:ss), 30:00 (mm:ss), 1-12:00:00 "
                     "(days-hh:mm:ss) or 1800 (s)");
  return seconds;
}

const StepperKind* readStepper(OptionSection& run) {
  std::vector<std::string> names;
  for (const StepperKind& kind : stepperKinds()) names.push_back(kind.name);
  const std::string name =
      run.choice("relax_method", names.front(), names,
                 "the way to rest: motion as it is, with what damping there is, or the minimiser "
                 "FIRE");
  return &*std::ranges::find(stepperKinds(), name, &StepperKind::name);
}

/// When a run is at rest.
void readRelaxation(Options& options, const UnitSystem& units, RunSettings& r) {
  OptionSection free = OptionSection(options, "Run").as(Role::run);
  r.relaxTolerance = free.real(
      "relax_tolerance", 0.0, "",
      "end when the elastic energy changes by less than this fraction in an interval; 0: do not",
      nonNegative);
  r.relaxForce = free.real("relax_force", 0.0, units.force,
                           "end when no segment feels a larger force, or torque over segment "
                           "length, that nothing balances; 0: do not",
                           nonNegative);
  OptionSection fire(options, "Run", r.stepper->minimises, "-relax_method is not fire");
  r.fireMaxMove = fire.maybeReal(
      "fire_max_move", "0.1 of the least diameter or segment", units.length,
      "the most that a point of a segment's surface may move in a step of FIRE", positive);
  OptionSection relax =
      OptionSection(options, "Run", r.relaxTolerance > 0, "-relax_tolerance is not set")
          .as(Role::run);
  r.relaxInterval =
      relax.integer("relax_interval", 5000, "steps between checks of -relax_tolerance", 1, most);
}

void readDamping(Options& options, const UnitSystem& units, bool pairs, RunSettings& r) {
  const bool minimises = r.stepper->minimises;
  const std::string needsNone = "-relax_method " + r.stepper->name + " brings its own damping";
  OptionSection damping(options, "Damping", !minimises, needsNone);
  r.damping =
      damping.real("damping_local", 0.0, "", "local damping c: F - c |F| sign(v)", {0.0, 1.0});
  OptionSection viscous(options, "Damping", pairs && !minimises,
                        minimises ? needsNone : "-pair is none");
  const std::string linear =
      std::string(units.force) + "/(" + units.length + "/" + units.time + ")";
  const std::string angular = std::string(units.energy) + " " + units.time;
  r.viscous.linear = viscous.real(
      "damping_viscous", 0.0, linear.c_str(),
      "viscous force between two lengths of 2 rf that interact, per difference of velocity",
      nonNegative);
  r.viscous.angular = viscous.real("damping_viscous_angular", 0.0, angular.c_str(),
                                   "viscous torque between two lengths of 2 rf that interact, per "
                                   "difference of angular velocity",
                                   nonNegative);
}

/// The launcher of an installed program has chosen by then: only the choice is checked.
void readSimd(OptionSection& parallel) {
  const std::string simd = parallel.choice(
      "simd", "auto", {"auto", "avx512", "avx2", "sse2"},
      "instruction set of the program to start, on the command line of an installed nanoweft; by "
      "default the best that the processor has");
  if (simd != "auto" && simd != simdName)
    throw InputError(
        format("-simd %s: this program is for %s; an installed nanoweft with several instruction "
               "sets takes -simd on its command line, a build has that of NANOWEFT_ARCH",
               simd.c_str(), simdName));
}

void readPartition(Options& options, RunSettings& r) {
  OptionSection parallel = OptionSection(options, "Parallel").as(Role::run);
  readSimd(parallel);
  r.allThreads = parallel.choice("threads", "auto", {"auto", "all"},
                                 "which of OMP_NUM_THREADS work: fewer while other programs take "
                                 "their cores, or all") == "all";
  const std::string kind = parallel.choice(
      "partition", "auto", {"auto", "dmda", "metis"},
      "how segments are shared among ranks: straight cuts of the cell grid, METIS on "
      "pieces of fibres, or METIS where straight cuts stay unequal");
  r.partition.kind = kind == "dmda"    ? PartitionSettings::rectilinear
                     : kind == "metis" ? PartitionSettings::metis
                                       : PartitionSettings::automatic;
  r.partition.tolerance =
      parallel.real("partition_tolerance", 1.05, "",
                    "most work of a rank over the mean before the shares are made anew", {1.0});
  const std::string agreement =
      parallel.choice("agreement", "auto", {"auto", "at_once", "late"},
                      "when ranks hear what others have noticed in a step: before they compute its "
                      "forces, or while "
                      "they do, with what can wait heard a step late; late from 128 ranks on");
  if (agreement != "auto") r.lateFrom = agreement == "late" ? 2 : std::numeric_limits<int>::max();
  OptionSection metis =
      OptionSection(options, "Parallel", kind != "dmda", "-partition is dmda").as(Role::run);
  r.partition.piece = static_cast<int>(metis.integer(
      "partition_piece", 32, "segments of a fibre that METIS keeps together", 1, 1000000));
}

void readOutputs(Options& options, RunSettings& r) {
  auto section = [&](bool active, const char* reason) {
    return OptionSection(options, "Output", active, reason).as(Role::run);
  };
  OptionSection out = section(true, "");
  r.monitorInterval =
      out.integer("monitor_interval", 100, "steps between rows of the monitors", 1, most);
  r.overwrite = out.flag("overwrite", false, "replace results that another run has written");
  r.progressSeconds = out.real("progress_interval", 5.0, "s",
                               "wall time between progress lines; 0: none", nonNegative);
  r.snapshotFile = out.text("snapshot_file", "",
                            "path of the snapshots without ending: NAME_<step>.h5 and NAME.xdmf");
  OptionSection snapshots = section(!r.snapshotFile.empty(), "-snapshot_file is not set");
  r.snapshotInterval =
      snapshots.integer("snapshot_interval", 10000, "steps between snapshots", 1, most);
  r.stateOutput = out.text("state_output", "", "state file for the final state");
  OptionSection final = section(!r.stateOutput.empty(), "-state_output is not set");
  r.stateForces = final.flag("state_forces", false,
                             "forces and torques (of bonds, pairs, walls) into -state_output");
  r.checkpointFile = out.text("checkpoint_file", "", "checkpoint, replaced each time");
  OptionSection checkpoints = section(!r.checkpointFile.empty(), "-checkpoint_file is not set");
  r.checkpointInterval =
      checkpoints.integer("checkpoint_interval", 10000, "steps between checkpoints", 1, most);
}

}  // namespace

const UnitSystem& readUnits(Options& options) {
  OptionSection s(options, "Run");
  const std::string name =
      s.choice("units", "nano", {"nano", "si"},
               "A, fs, eV, amu; or m, s, J, kg; stiffnesses and stresses in GPa");
  return name == "si" ? siUnits() : nanoUnits();
}

std::string readRestart(Options& options) {
  return OptionSection(options, "Run")
      .as(Role::run)
      .text("restart", "", "go on from this checkpoint; steps and time count on");
}

void requireSameInstructions(MPI_Comm comm, const std::string& own) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string first = own;
  int length = static_cast<int>(first.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm);
  first.resize(static_cast<std::size_t>(length));
  MPI_Bcast(first.data(), length, MPI_CHAR, 0, comm);
  agree<InputError>(
      comm, own == first
                ? ""
                : format("rank %d runs the program for %s, rank 0 that for %s, whose last bits "
                         "differ: give -simd with what all computers have",
                         rank, own.c_str(), first.c_str()));
}

RunSettings readRunSettings(Options& options, const UnitSystem& units, bool pairs) {
  RunSettings r;
  OptionSection run(options, "Run");
  OptionSection free = run.as(Role::run);
  r.dt =
      run.as(Role::step)
          .maybeReal(
              "ts_dt",
              "20 fs for cnt_10_10, else 0.4 of the stable step, 0.8 of that of pressed fibres at "
              "most",
              units.time,
              "time step; the longest with -relax_method fire (by default from the stable limit)",
              positive);
  r.stepper = readStepper(run);
  // A minimiser's longest step follows the estimates.
  OptionSection steps = run.as(r.stepper->minimises ? Role::result : Role::run);
  r.unsafeStep = steps.flag("ts_dt_unsafe", false, "allow a step beyond the stable limit");
  r.limitInterval =
      steps.integer("ts_limit_interval", 20000,
                    "steps between estimates of the stable step; 0: at the start only", 0, most);
  r.energyAlarm = free.real("energy_alarm", 0.25, "",
                            "end as unstable when energy out of nothing exceeds this fraction of "
                            "what there was; 0: do not",
                            nonNegative);
  r.maxSteps =
      free.maybeInteger("ts_max_steps", "none",
                        "step number at which the run ends; 0: evaluate the start only", 0, most);
  r.maxTime =
      free.maybeReal("ts_max_time", "none", units.time, "time at which the run ends", nonNegative);
  r.wallTime = readWallTime(free);
  readRelaxation(options, units, r);
  r.seed = static_cast<std::uint64_t>(run.integer("seed", 1, "of all random numbers", 0, most));
  r.perturb =
      run.real("scene_perturb", 0.0, units.length,
               "standard deviation of random displacements of the starting positions", nonNegative);
  r.startUnchecked =
      free.flag("start_unchecked", false,
                "start even though bonds are so far from rest that it can hardly be meant");

  readDamping(options, units, pairs, r);
  r.thermostat = readThermostat(
      options, units, r.seed,
      r.stepper->minimises ? "-relax_method " + r.stepper->name + " seeks rest" : "");
  OptionSection pair = OptionSection(options, "Pair forces", pairs, "-pair is none").as(Role::run);
  r.skin = pair.maybeReal("pair_skin", "tuned while running", units.length,
                          "margin of the pair list", positive)
               .value_or(0.0);
  r.allowOverlap = pair.flag("pair_allow_overlap", false, "start even though fibres overlap");

  readPartition(options, r);
  readOutputs(options, r);
  return r;
}

void readDomain(Options& options, const UnitSystem& units, Box& box) {
  OptionSection s(options, "Domain");
  const Box own = box;
  if (auto v = s.reals("domain_lower", 3, "of the scene", units.length, "lower corner of the box"))
    std::copy(v->begin(), v->end(), box.lower.begin());
  if (auto v = s.reals("domain_upper", 3, "of the scene", units.length, "upper corner of the box"))
    std::copy(v->begin(), v->end(), box.upper.begin());
  if (auto v = s.flags3("domain_periodic", "of the scene", "periodic in x, y, z"))
    box.periodic = *v;
  if (own.tilt &&
      (box.lower != own.lower || box.upper != own.upper || box.periodic != own.periodic))
    throw InputError(
        "-domain_lower, -domain_upper, -domain_periodic: the box of the state is tilted by shear, "
        "and stays as it is");
  for (std::size_t d = 0; d < 3; ++d)
    if (!(box.lower[d] < box.upper[d]))
      throw InputError(
          format("-domain_lower, -domain_upper: the box has no extent along %c (%g to %g)",
                 "xyz"[d], box.lower[d], box.upper[d]));
}

}  // namespace nanoweft
