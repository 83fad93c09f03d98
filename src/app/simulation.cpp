#include "nanoweft/app/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "nanoweft/app/provenance.hpp"
#include "nanoweft/app/signals.hpp"
#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/log.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/base/threads.hpp"
#include "nanoweft/motion/breakage.hpp"
#include "nanoweft/motion/residual.hpp"
#include "nanoweft/record/gage_stress.hpp"
#include "nanoweft/record/segment_fields.hpp"
#include "nanoweft/scene/start_check.hpp"
#include "nanoweft/state/output_target.hpp"

namespace nanoweft {

namespace {

/// What must not change from a checkpoint to its restart.
std::vector<double> fibreFingerprint(const Fibre& f) {
  return {f.radius,       f.length,     f.mass,         f.inertia,
          f.bond.stretch, f.bond.shear, f.bond.bending, f.bond.torsion};
}

constexpr std::array accountNames{"account_damped", "account_external", "account_broken"};

std::string timeColumn(const UnitSystem& units) {
  return std::string("time_") + units.time;
}

}  // namespace

Simulation::Simulation(MPI_Comm comm, Options& options, int threads, bool atMost)
    : comm_(comm),
      threads_(threads),
      threadsAsked_(threads),
      threadsAtMost_(atMost),
      restart_(readRestart(options)),
      restartHeader_(options.helpWanted() || restart_.empty()
                         ? std::nullopt
                         : std::optional(openCheckpoint(comm, restart_, options))),
      units_(readUnits(options)),
      fibre_(readFibre(options, units_)),
      pairLaw_(readPairForce(options, units_, fibre_)),
      settings_(readRunSettings(options, units_, pairLaw_ != nullptr)),
      wallLimit_(settings_.wallTime),
      breakage_(readBreakage(options, units_, fibre_, settings_.seed)),
      scene_(readScene(options, {units_, fibre_, comm, restDistance()},
                       options.helpWanted() || restartHeader_)),
      boundaries_(options, units_, fibre_, restDistance()),
      energyMonitor_(options, "energy_monitor", "energies through a viewer: ascii:FILE.csv, draw",
                     {timeColumn(units_), "stretch", "shear", "bending", "torsion", "pair",
                      "kinetic", "rotational", "total", "damped", "external", "broken"},
                     0, {1, 2, 3, 4, 5, 6, 7}),
      stressMonitor_(options, "stress_monitor",
                     "stress of a tension test through a viewer: ascii:FILE.csv, draw",
                     {timeColumn(units_), "strain", "stress_left_GPa", "stress_right_GPa",
                      "broken_bonds", "virial_xx_GPa", "virial_yy_GPa", "virial_zz_GPa",
                      "virial_xy_GPa", "virial_xz_GPa", "virial_yz_GPa"},
                     1, {2, 3}),
      driftEvent_(logEvent("NwKickDrift")),
      kickEvent_(logEvent("NwKick")),
      recordEvent_(logEvent("NwRecord")),
      fileEvent_(logEvent("NwFiles")) {
  if (restartHeader_) box_ = restartHeader_->box;
  if (scene_) box_ = scene_->box();
  Box given = box_;
  if (options.helpWanted()) given.upper = {1, 1, 1};
  readDomain(options, units_, given);
  // A restart keeps the box of its checkpoint.
  if (!restartHeader_) box_ = given;
  options.refuseUnknown();
  if (options.helpWanted()) return;
  if (stressMonitor_.wanted() && !boundaries_.tension())
    throw InputError("-stress_monitor: there is no tension test; give -tension_rate");
  if (!settings_.maxSteps && !settings_.maxTime && settings_.relaxTolerance == 0 &&
      settings_.relaxForce == 0 && !boundaries_.tension())
    throw InputError(
        "the run has no end: give -ts_max_steps, -ts_max_time, -relax_tolerance, -relax_force or "
        "-tension_rate");
  if (settings_.fire) requireRest();
  if (breakage_ && pairLaw_ && pairLaw_->exclude() > mostExcludeWithBreakage)
    throw InputError(
        format("-pair_exclude %d: at most %d with breakage (by default 20 diameters over the "
               "segment length)",
               pairLaw_->exclude(), mostExcludeWithBreakage));
  provenance_ = readProvenance(comm, options, startHeader(), restartHeader_.has_value());
  seeNewStep(options);
  checkOutputs();
  build();
}

double Simulation::restDistance() const {
  return pairLaw_ ? pairLaw_->restDistance() : usualRestDistance(fibre_, units_);
}

const StateHeader* Simulation::startHeader() const {
  return restartHeader_ ? &*restartHeader_ : scene_->header();
}

void Simulation::seeNewStep(const Options& options) {
  if (!restartHeader_ || !options.readings().at("ts_dt").byUser) return;
  const RunRecord& old = restartHeader_->run;
  // FIRE's longest step may have been shortened since it was given.
  stepIsNew_ = settings_.fire ? provenance_.options != old.texts.at(optionsText)
                              : old.needReals("time_step", 1)[0] != *settings_.dt;
}

void Simulation::requireRest() const {
  if (boundaries_.tension())
    throw InputError("-relax_method fire: a tension test moves the grips; relax first, then pull");
  for (const Boundary& b : boundaries_.list())
    if (norm(b.velocity) > 0)
      throw InputError("-relax_method fire: -" + b.name +
                       "_velocity keeps the fibres moving, so there is no rest");
}

void Simulation::checkOutputs() const {
  requireDistinctOutputs();
  const ReplaceRule rule = replaceRule();
  for (const std::string& file : {settings_.checkpointFile, settings_.stateOutput}) {
    if (file.empty()) continue;
    makeParentFolder(comm_, file);
    refuseForeignTarget(comm_, file, rule);
    requireWritable(comm_, file);
  }
  energyMonitor_.check(comm_, tableRun());
  stressMonitor_.check(comm_, tableRun());
  if (!settings_.snapshotFile.empty()) Snapshots::check(comm_, snapshotSetting());
}

void Simulation::requireDistinctOutputs() const {
  const std::pair<const char*, std::string> files[] = {
      {"-energy_monitor", energyMonitor_.fileName()},
      {"-stress_monitor", stressMonitor_.fileName()},
      {"-checkpoint_file", settings_.checkpointFile},
      {"-state_output", settings_.stateOutput}};
  std::string problem;
  if (int rank; MPI_Comm_rank(comm_, &rank) == MPI_SUCCESS && rank == 0)
    for (const auto& [option, file] : files) {
      if (file.empty()) continue;
      for (const auto& [other, theirs] : files)
        if (std::strcmp(other, option) < 0 && !theirs.empty() && isSameFile(file, theirs))
          problem = format("%s %s and %s %s are the same file", other, theirs.c_str(), option,
                           file.c_str());
      if (!settings_.snapshotFile.empty() && Snapshots::makes(settings_.snapshotFile, file))
        problem = format("%s %s is a file that -snapshot_file %s makes", option, file.c_str(),
                         settings_.snapshotFile.c_str());
    }
  agree<InputError>(comm_, problem);
}

ReplaceRule Simulation::replaceRule() const {
  ReplaceRule rule;
  rule.run = provenance_;
  rule.overwrite = settings_.overwrite;
  rule.restart = restart_;
  rule.checkpoint = checkpointProvenance();
  if (scene_ && !scene_->file().empty()) rule.inputs = {scene_->file()};
  return rule;
}

std::optional<Provenance> Simulation::checkpointProvenance() const {
  if (!restartHeader_) return std::nullopt;
  return provenanceOf(restartHeader_->run);
}

TableRun Simulation::tableRun() const {
  TableRun run;
  run.provenance = provenance_;
  run.checkpoint = checkpointProvenance();
  run.overwrite = settings_.overwrite;
  run.restart = restartHeader_.has_value();
  run.interval = settings_.monitorInterval;
  if (state_) run.step = state_->step;
  run.ends = run.restart && verlet_ && over();
  return run;
}

Snapshots::Setting Simulation::snapshotSetting() const {
  return {settings_.snapshotFile, replaceRule(), checkpointProvenance(),
          restartHeader_ ? restartHeader_->step : -1};
}

void Simulation::build() {
  const StateHeader* header = startHeader();
  const bool breaks = breakage_ || (header && header->anyBroken);
  State::Extras extras;
  extras.gap = breaks && pairLaw_;
  extras.viscous = static_cast<bool>(settings_.viscous);

  ForceField::Settings force;
  force.fibre = fibre_;
  force.pair = std::move(pairLaw_);
  force.breakage = breakage_;
  // The options are for two lengths of 2 rf: a rate per length squared.
  const double lengths = fibre_.length / fibre_.diameter();
  force.viscous = {settings_.viscous.linear * (lengths * lengths),
                   settings_.viscous.angular * (lengths * lengths)};
  force.skin = settings_.skin;
  force.threads = threads_;
  forces_ = std::make_unique<ForceField>(std::move(force), box_);

  auto state = std::make_unique<State>(comm_, box_, extras);
  if (restartHeader_) {
    requireParts(*restartHeader_, {extras.gap, extras.viscous});
    readStateRows(restart_, *restartHeader_, *state);
  } else {
    scene_->fill(*state);
  }
  state_ = std::move(state);
  requireWideBox(box_, 1.5 * fibre_.length, units_.length);
  // Before what else such a start would meet, so that the cause that is named is the cause.
  if (!restartHeader_) checkStart();
  if (forces_->pair()) requireWideBox(box_, forces_->lists().range(), units_.length);
  if (threadsAtMost_) {
    const std::int64_t busy = state_->total() / state_->ranks() / segmentsPerThread;
    threads_ = static_cast<int>(std::clamp<std::int64_t>(busy, 1, threads_));
  }
  threadsAsked_ = threads_;
  threads_ = teamGiven(threadsAsked_);
  forces_->lists().setThreads(threads_);
  if (!restartHeader_ && settings_.perturb > 0) perturb();
  const RunRecord empty;
  const RunRecord& record = header ? header->run : empty;
  boundaries_.attach(*state_, record, restartHeader_.has_value());
  if (restartHeader_) goOn(record);
  if (boundaries_.tensionGoesOn()) goOnPulling(record);
  firstStep_ = state_->step;
  firstTime_ = state_->time;
  if (restartHeader_) good_.note(restart_, firstStep_);

  domain_ = std::make_unique<Domain>(*state_, settings_.partition);
  forces_->rebuild(*state_, *domain_);
  if (breaks) {
    spreadOldBreaks(*state_, forces_->pair() ? forces_->pair()->exclude() : 0);
    forces_->rebuild(*state_, *domain_);  // the bond lists again, without the broken ones
  }
  // The first shares know nothing of the work; the next ones do, and METIS may have to help.
  for (int k = 0; k < 2 && domain_->unequal(); ++k) forces_->rebuild(*state_, *domain_);
  if (!restartHeader_ && forces_->pair() && !settings_.allowOverlap) refuseOverlap();
  chooseStep();
  openOutputs();
}

void Simulation::openOutputs() {
  // Nothing is changed before all of it may be.
  energyMonitor_.claim(comm_, tableRun());
  stressMonitor_.claim(comm_, tableRun());
  if (!settings_.snapshotFile.empty()) snapshots_.emplace(comm_, snapshotSetting());
  energyMonitor_.open();
  stressMonitor_.open();
  if (snapshots_) snapshots_->begin();
}

void Simulation::checkStart() {
  const StateHeader* file = scene_->header();
  const Box own = scene_->box();
  bool evolved = false;
  if (file)
    if (const auto it = file->run.reals.find("fibre"); it != file->run.reals.end())
      evolved = it->second == fibreFingerprint(fibre_) && own.lower == box_.lower &&
                own.upper == box_.upper && own.periodic == box_.periodic;
  const bool refuse = !evaluatesOnly() && !settings_.startUnchecked;
  for (const StartFinding& finding :
       lookAtStart(*state_, {units_, fibre_, own, scene_->asked(), file != nullptr, evolved})) {
    if (finding.refused && refuse)
      throw InputError("the start cannot be meant: " + finding.text + " (or -start_unchecked)");
    startWarnings_.push_back("at the start, " + finding.text);
  }
}

void Simulation::perturb() {
  for (int i = 0; i < state_->owned(); ++i) {
    for (int c = 0; c < 3; ++c)
      state_->pose[8 * i + c] +=
          settings_.perturb *
          normalDraw(settings_.seed + static_cast<std::uint64_t>(c) * 0x9E3779B9u,
                     Purpose::perturbation, state_->fibre[i],
                     static_cast<std::uint32_t>(state_->chain[2 * i]));
    state_->box.wrap(state_->pose + 8 * i, state_->image + 3 * i);
  }
}

void Simulation::refuseOverlap() const {
  // To evaluate a strong overlap is harmless; only points that all but coincide have no force.
  const double least = evaluatesOnly() ? 0.25 * fibre_.radius : forces_->pair()->closestSensible();
  const ClosestPair c = findClosestPair(*state_, *forces_);
  if (c.distance >= least) return;
  throw InputError(format(
      "fibres overlap: fibre %lld segment %d and fibre %lld segment %d are %.4g %s apart, and "
      "their walls meet at %.4g %s; "
      "move them apart (or -pair_allow_overlap)",
      static_cast<long long>(c.fibre[0]), c.index[0], static_cast<long long>(c.fibre[1]),
      c.index[1], c.distance, units_.length, forces_->pair()->closestSensible(), units_.length));
}

bool Simulation::evaluatesOnly() const {
  return settings_.maxSteps && *settings_.maxSteps <= state_->step;
}

double Simulation::strain() const {
  return boundaries_.tension() ? boundaries_.tension()->strain(state_->time) : 0.0;
}

bool Simulation::atEnd() const {
  if (settings_.maxSteps && state_->step >= *settings_.maxSteps) return true;
  // Half a step of slack against round-off in the sum of steps.
  if (settings_.maxTime && state_->time > *settings_.maxTime - 0.5 * verlet_->dt()) return true;
  return boundaries_.tension() && strain() >= boundaries_.tension()->maxStrain;
}

Ending Simulation::run() {
  try {
    return runToEnd();
  } catch (const RunError& failure) {
    throw RunError(std::string(failure.what()) + "; " + good_.sentence());
  }
}

Ending Simulation::stopEarly() {
  // Without a name given, one that takes no other file's place.
  const std::string file =
      settings_.checkpointFile.empty()
          ? format("checkpoint_%010lld.h5", static_cast<long long>(state_->step))
          : settings_.checkpointFile;
  if (lastCheckpoint_ != state_->step) writeCheckpoint(file);
  const std::string reason =
      timeOver_ ? "stopped: the wall time of " + shownDuration(wallLimit_.limit()) + " is over"
                : "stopped by a signal";
  PetscPrintf(comm_, "%s at step %lld; go on with -restart %s\n", reason.c_str(),
              static_cast<long long>(state_->step), file.c_str());
  return Ending::stopped;
}

Ending Simulation::runToEnd() {
  printHeader();
  begin();
  while (!over() && !stopAsked_ && !timeOver_) step();
  // A run that is over has nothing to go on with.
  if (!over()) return stopEarly();
  record();
  if (!settings_.checkpointFile.empty() && lastCheckpoint_ != state_->step)
    writeCheckpoint(settings_.checkpointFile);
  if (!settings_.stateOutput.empty()) {
    const LogScope log(fileEvent_);
    StateWriteOptions what;
    what.forces = settings_.stateForces;
    writeState(settings_.stateOutput, *state_, units_, runRecord(finalPurpose), what);
  }
  energyMonitor_.sync();
  stressMonitor_.sync();
  printSummary();
  return Ending::done;
}

void Simulation::begin() {
  ForceRequest request;
  request.energies = true;
  // The viscous forces of a checkpoint belong to velocities that are gone.
  request.viscous = !restartHeader_;
  outcome_ = forces_->evaluate(*state_, domain_->halo(), request);
  accounts_.broken.merge(outcome_.released);
  pendingBreaks_ = outcome_.broken;
  energies_ = sumEnergies(*state_, *forces_, outcome_, accounts_);
  first_ = *energies_;
  if (!std::isfinite(first_.balance()))
    throw RunError(
        "the energy of the first state is not a finite number: check the fibre's parameters and "
        "the geometry");
  watchContacts();
  for (const TableMonitor* monitor : {&energyMonitor_, &stressMonitor_})
    if (!monitor->notice().empty()) PetscPrintf(comm_, "  %s\n", monitor->notice().c_str());
  if (!restartHeader_) {
    if (settings_.relaxTolerance > 0) lastElastic_ = energies_->elastic();
    record();
    if (snapshots_) writeSnapshot();
  } else if (energyMonitor_.isNew() || stressMonitor_.isNew()) {
    record();
  }
  checkBalance();
  firstResolved_ = forces_->pairsResolved();
  wallLimit_.expectCheckpoint(static_cast<double>(state_->total()) * secondsPerSegmentWritten);
  wallStart_ = lastProgress_ = progressWall_ = MPI_Wtime();
  progressStep_ = state_->step;
}

void Simulation::step() {
  DriftReport drift;
  {
    const LogScope log(driftEvent_);
    drift = verlet_->kickAndDrift(*state_, *forces_, boundaries_, accounts_);
  }
  const int notices = agreeOn(drift);
  if (notices & unstable) reportInstability("");
  if (notices & broke)
    spreadBreaks(*state_, forces_->pair() ? forces_->pair()->exclude() : 0,
                 std::exchange(pendingBreaks_, {}));
  if (notices & released)
    forces_->rebuild(*state_, *domain_);
  else if (notices & stale)
    forces_->refresh(*state_, *domain_);

  const bool monitored =
      (energyMonitor_.wanted() || stressMonitor_.wanted()) && due(settings_.monitorInterval);
  const bool relaxCheck = settings_.relaxTolerance > 0 && due(settings_.relaxInterval);
  const bool checkpoint = !settings_.checkpointFile.empty() && due(settings_.checkpointInterval);
  ForceRequest request;
  request.energies = monitored || relaxCheck || checkpoint ||
                     (notices & (progress | stop | wallTime)) || due(energyCheckInterval) ||
                     atEnd();
  request.complete = false;
  outcome_ = forces_->evaluate(*state_, domain_->halo(), request);
  accounts_.broken.merge(outcome_.released);
  pendingBreaks_.insert(pendingBreaks_.end(), outcome_.broken.begin(), outcome_.broken.end());
  {
    const LogScope log(kickEvent_);
    if (endIsSeen(request))
      verlet_->kick(*state_, *forces_, boundaries_, accounts_);
    else
      verlet_->oweKick();
    if (fire_) {
      fire_->steer(*state_, *forces_, boundaries_, accounts_);
      verlet_.emplace(fire_->dt(), 0.0);
    }
  }
  if (due(gapCheckInterval)) releasedPairs_ = releasePairs(*state_, *forces_, *domain_);

  energies_.reset();
  if (request.energies) {
    const LogScope log(recordEvent_);
    energies_ = sumEnergies(*state_, *forces_, outcome_, accounts_);
    watchEnergy();
  }
  if (due(contactCheckInterval)) watchContacts();
  if (monitored) record();
  if (relaxCheck) {
    converged_ = lastElastic_ >= 0 && std::abs(energies_->elastic() - lastElastic_) <=
                                          settings_.relaxTolerance * energies_->elastic();
    lastElastic_ = energies_->elastic();
  }
  checkBalance();
  if (notices & progress) printProgress();
  if (snapshots_ && due(settings_.snapshotInterval)) writeSnapshot();
  if (settings_.limitInterval > 0 && due(settings_.limitInterval)) followLimit();
  if (checkpoint) writeCheckpoint(settings_.checkpointFile);
  stopAsked_ = notices & stop;
  timeOver_ = notices & wallTime;
}

bool Simulation::endIsSeen(const ForceRequest& request) const {
  return request.energies || fire_ || state_->viscous ||
         (snapshots_ && due(settings_.snapshotInterval)) ||
         (settings_.limitInterval > 0 && due(settings_.limitInterval)) ||
         (settings_.relaxForce > 0 && due(balanceCheckInterval));
}

void Simulation::checkBalance() {
  // At the same steps after a restart, which must not end earlier.
  if (settings_.relaxForce == 0 || !due(balanceCheckInterval)) return;
  balanced_ = largestResidual(*state_, *forces_, boundaries_) <= settings_.relaxForce;
  if (!balanced_ || energies_) return;
  // The last row wants the energies.
  ForceRequest request;
  request.energies = true;
  request.mayBreak = request.viscous = false;
  energies_ = sumEnergies(*state_, *forces_, forces_->evaluate(*state_, domain_->halo(), request),
                          accounts_);
}

int Simulation::agreeOn(const DriftReport& drift) {
  int notices = 0;
  if (drift.stale) notices |= stale;
  if (releasedPairs_) notices |= released;
  if (drift.unstable) notices |= unstable;
  if (stopRequested()) notices |= stop;
  if (!pendingBreaks_.empty()) notices |= broke;
  if (state_->rank() == 0 && settings_.progressSeconds > 0 &&
      MPI_Wtime() - lastProgress_ > settings_.progressSeconds)
    notices |= progress;
  if (state_->rank() == 0 && wallLimit_.over(secondsSinceStart())) notices |= wallTime;
  if (state_->ranks() > 1) MPI_Allreduce(MPI_IN_PLACE, &notices, 1, MPI_INT, MPI_BOR, comm_);
  releasedPairs_ = false;
  return notices;
}

void Simulation::record() {
  const LogScope log(recordEvent_);
  const Energies& e = *energies_;
  energyMonitor_.record(state_->step,
                        {state_->time, e.stretch, e.shear, e.bending, e.torsion, e.pair, e.kinetic,
                         e.rotational, e.total(), e.damped, e.external, e.broken});
  if (boundaries_.tension()) {
    const auto stress = boundaries_.gripStress(*state_, *forces_, units_);
    lastStress_ = 0.5 * (stress[0] + stress[1]);
    // A row that only closes a piece of the run is none of the whole run's.
    if (due(settings_.monitorInterval)) strength_ = std::max(strength_, lastStress_);
    if (stressMonitor_.wanted()) {
      const auto virial = gageStress(*state_, *domain_, *forces_, *boundaries_.tension(), units_);
      std::vector<double> row{state_->time, strain(), stress[0], stress[1],
                              static_cast<double>(e.brokenBonds)};
      row.insert(row.end(), virial.begin(), virial.end());
      stressMonitor_.record(state_->step, row);
    }
  }
}

void Simulation::writeSnapshot() {
  const LogScope log(fileEvent_);
  snapshots_->write(*state_, units_, stageRecord(snapshotPurpose),
                    segmentFields(*state_, *domain_, *forces_));
}

void Simulation::goOnPulling(const RunRecord& record) {
  strength_ = record.needReals("tension_strength", 1)[0];
  const Tension& t = *boundaries_.tension();
  if (t.before >= t.maxStrain && !evaluatesOnly())
    throw InputError(
        format("-tension_max_strain %g: the tension test that %s carries has reached a strain of "
               "%g; give a larger one, or start a test of its own with -tension_new",
               t.maxStrain, record.source.c_str(), t.before));
}

RunRecord Simulation::stageRecord(const char* purpose) const {
  RunRecord record;
  record.texts = provenanceTexts(provenance_, purpose);
  // By it a later stage knows whether its bonds are the same.
  record.reals["fibre"] = fibreFingerprint(fibre_);
  boundaries_.save(record, state_->time);
  record.reals["tension_strength"] = {strength_};
  return record;
}

RunRecord Simulation::runRecord(const char* purpose) const {
  RunRecord record = stageRecord(purpose);
  ExactSum sums[3] = {accounts_.damped, accounts_.external, accounts_.broken};
  ExactSum::reduce(sums, 3, comm_);
  for (std::size_t k = 0; k < 3; ++k)
    record.integers[accountNames[k]] =
        std::vector<std::int64_t>(sums[k].data(), sums[k].data() + 3);
  record.reals["relax_elastic"] = {lastElastic_, static_cast<double>(settings_.relaxInterval)};
  record.reals["time_step"] = {verlet_->dt()};
  if (defaultStep_) record.reals["default_step"] = {*defaultStep_};
  if (fire_) fire_->save(record);
  if (converged_)
    record.reals["ended_by_relax_tolerance"] = {settings_.relaxTolerance,
                                                static_cast<double>(settings_.relaxInterval)};
  if (balanced_) record.reals["ended_by_relax_force"] = {settings_.relaxForce};
  return record;
}

void Simulation::goOn(const RunRecord& record) {
  if (record.needReals("fibre", 8) != fibreFingerprint(fibre_))
    throw InputError("-restart " + restart_ +
                     ": its fibres have other parameters than the options say (-fibre_...)");
  if (restartHeader_->units != units_.name)
    throw InputError(format("-restart %s: it is in units %s, its options in %s", restart_.c_str(),
                            restartHeader_->units.c_str(), units_.name.c_str()));
  ExactSum* sums[3] = {&accounts_.damped, &accounts_.external, &accounts_.broken};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& account = record.needIntegers(accountNames[k], 3);
    if (state_->rank() == 0) std::ranges::copy(account, sums[k]->data());
  }
  strength_ = record.needReals("tension_strength", 1)[0];
  const auto& elastic = record.needReals("relax_elastic", 2);
  const auto interval = static_cast<double>(settings_.relaxInterval);
  // Energies are compared that lie an interval apart.
  if (elastic[1] == interval) lastElastic_ = elastic[0];
  // A run that was over is over, unless more is asked of it now.
  if (record.reals.contains("ended_by_relax_tolerance")) {
    const auto& end = record.needReals("ended_by_relax_tolerance", 2);
    converged_ = end[0] <= settings_.relaxTolerance && end[1] == interval;
  }
  if (record.reals.contains("ended_by_relax_force"))
    balanced_ = record.needReals("ended_by_relax_force", 1)[0] <= settings_.relaxForce;
}

void Simulation::writeCheckpoint(const std::string& file) {
  const LogScope log(fileEvent_);
  const double begin = secondsSinceStart();
  // What a restart expects of the tables is safe before the checkpoint is.
  energyMonitor_.sync();
  stressMonitor_.sync();
  writeState(file, *state_, units_, runRecord(checkpointPurpose));
  wallLimit_.checkpointTook(secondsSinceStart() - begin);
  lastCheckpoint_ = state_->step;
  good_.note(file, state_->step);
}

}  // namespace nanoweft
