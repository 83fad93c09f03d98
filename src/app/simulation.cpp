#include "nanoweft/app/simulation.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "nanoweft/app/accounts_record.hpp"
#include "nanoweft/app/instability.hpp"
#include "nanoweft/app/report.hpp"
#include "nanoweft/app/wall_time.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/log.hpp"
#include "nanoweft/record/gage_stress.hpp"

namespace nanoweft {

namespace {

/// A guess on the safe side until a checkpoint has been timed: 200 bytes at 50 MB/s.
constexpr double secondsPerSegmentWritten = 4e-6;

/// What ranks tell each other in each step, as bits; the wishes of observers follow. They concern
/// the forces of this step, but for `staleSoon` and the wishes, which wait for the next one.
enum Notice {
  stale = 1,
  unstable = 2,
  broke = 4,
  outdated = 8,
  crowded = 16,
  tooLong = 32,
  staleSoon = 64,
  firstWish = 128
};

/// The name of a file that is not there: `stem` and `ending`, with a number between them where such
/// files are there already. The same on all ranks.
std::string unusedName(const std::string& stem, const char* ending, const State& state) {
  int number = 1;
  auto name = [&] { return stem + (number > 1 ? format("_%d", number) : "") + ending; };
  if (state.rank() == 0)
    while (std::filesystem::exists(name())) ++number;
  MPI_Bcast(&number, 1, MPI_INT, 0, state.comm());
  return name();
}

}  // namespace

Simulation::Simulation(std::unique_ptr<RunParts> parts)
    : parts_(std::move(parts)),
      system_(parts_->system()),
      observers_(parts_->plan->observers),
      breaks_(system_.forces.pairs().exclude()),
      checkpointSeconds_(static_cast<double>(system_.state.total()) * secondsPerSegmentWritten),
      driftEvent_(logEvent("NwKickDrift")),
      kickEvent_(logEvent("NwKick")),
      repeatEvent_(logEvent("NwRepeat")),
      recordEvent_(logEvent("NwRecord")),
      fileEvent_(logEvent("NwFiles")) {
  const RunPlan& plan = *parts_->plan;
  if (plan.checkpoint) good_.note(plan.restart, system_.state.step);
  OutputContext context = plan.outputContext(plan.checkpoint && verdict() == Verdict::done);
  context.step = system_.state.step;
  // No file is changed before all observers have claimed theirs.
  for (const auto& observer : observers_) observer->claim(context);
  for (const auto& observer : observers_) observer->open();
}

Moment Simulation::moment() {
  return {system_, *parts_->stepper, parts_->limits, first_, energies_ ? &*energies_ : nullptr,
          *this};
}

Ending Simulation::run() {
  try {
    return runToEnd();
  } catch (const RunError& failure) {
    throw RunError(std::string(failure.what()) + "; " + good_.sentence());
  }
}

Ending Simulation::runToEnd() {
  const Moment start = moment();
  printHeader(*parts_, start);
  begin();
  Clock clock(start);
  parts_->teamSize->startSteps();
  while (verdict() == Verdict::goOn) {
    step();
    if (parts_->teamSize->noteStep(system_.forces.shares().size()))
      system_.forces.lists().outdate();
  }
  // `done` has precedence over `stop`: a run that is over needs no checkpoint to go on from.
  if (verdict() == Verdict::stop) return stopEarly();
  requireEnergies();
  const Moment end = moment();
  for (const auto& observer : observers_) observer->finish(end);
  sync();
  printSummary(*parts_, end, clock, parts_->teamSize->mean());
  return Ending::done;
}

void Simulation::begin() {
  ForceRequest request;
  request.energies = true;
  // A restart keeps the viscous forces of its checkpoint: the velocities that they were computed
  // from, those half a step back, are not in the file.
  request.viscous = !parts_->plan->checkpoint;
  request.ahead = parts_->stepper->dt();
  note(system_.forces.evaluate(system_.state, system_.domain.halo(), request), true);
  first_ = *energies_;
  // A restart has the stress of its checkpoint.
  if (!parts_->plan->checkpoint) measureBox();
  const Moment start = moment();
  for (const auto& observer : observers_) observer->begin(start);
}

void Simulation::step() {
  DriftReport drift;
  {
    const LogScope log(driftEvent_);
    changeBetweenSteps();
    drift = parts_->stepper->move(system_);
    parts_->plan->boxDrive.strainVelocities(system_.state);
  }
  energies_.reset();
  doAgreed(drift);
  tell(drift);
  if (!system_.forces.lists().foresees()) hearAtOnce();
  const View view = widestView();
  const ForceOutcome outcome = evaluate(view);
  system_.forces.walls().finish(system_.state.comm(), system_.state.time, parts_->stepper->dt(),
                                {system_.accounts.external, system_.accounts.damped});
  {
    const LogScope log(kickEvent_);
    parts_->stepper->finish(system_, view != View::positions);
  }
  if (view == View::energies) measureBox();
  if (breaks_.release(system_.state, system_.forces, system_.domain))
    system_.forces.lists().outdate();
  const LogScope log(recordEvent_);
  note(outcome, view == View::energies);
  const Moment end = moment();
  for (const auto& observer : observers_) observer->observe(end);
}

void Simulation::changeBetweenSteps() {
  State& state = system_.state;
  ForceField& forces = system_.forces;
  EnergyAccounts& accounts = system_.accounts;
  const double dt = parts_->stepper->dt();
  accounts.damped.merge(forces.flow(state));
  parts_->plan->boxDrive.strain(state, forces, state.time, dt, accounts.external);
  forces.walls().move(state.comm(), state.time, dt, {accounts.external, accounts.damped});
  // Bonds that broke in the last evaluation; those that break while segments move wait for the
  // next time, since not all ranks know of them yet.
  if (state.extras().ends && forces.breakage()) state.noteFreeEnds();
}

void Simulation::measureBox() {
  BoxDrive& drive = parts_->plan->boxDrive;
  const State& state = system_.state;
  if (!drive || state.step % drive.interval() != 0) return;
  drive.note(state, system_.forces,
             boxStress(state, system_.domain, system_.forces, drive.volume(state.box),
                       parts_->plan->units),
             parts_->stepper->dt(), system_.accounts.external);
}

void Simulation::doAgreed(DriftReport& drift) {
  granted_ = std::exchange(agreed_, 0);
  grant(granted_);
  if (!(granted_ & staleSoon)) return;
  // All ranks reckon with the same way, without waiting for what they have just gone.
  const ListKeeper& lists = system_.forces.lists();
  const double reckoned = farthest_ + lists.wayToDrawing();
  if (!system_.forces.redraw(system_.state, reckoned)) {
    // Shares and lists are made from positions, which must be numbers.
    int lost = drift.unstable;
    MPI_Allreduce(MPI_IN_PLACE, &lost, 1, MPI_INT, MPI_MAX, system_.state.comm());
    if (lost) throwUnstable(moment(), parts_->plan->units);
    system_.forces.rebuild(system_.state, system_.domain);
  }
  drift.stale = lists.farthest() > reckoned;
  drift.staleSoon = false;
}

void Simulation::grant(int wishes) {
  int wish = firstWish;
  for (const auto& observer : observers_) {
    if (wishes & wish) observer->hear();
    wish <<= 1;
  }
}

void Simulation::hearAtOnce() {
  const bool hold = listsHold();
  grant(std::exchange(agreed_, 0));
  if (!hold) renewLists();
}

void Simulation::tell(const DriftReport& drift) {
  const Moment now = moment();
  int mine = 0;
  if (drift.stale) mine |= stale;
  if (drift.staleSoon) mine |= staleSoon;
  if (drift.unstable) mine |= unstable;
  if (breaks_.waiting()) mine |= broke;
  if (system_.forces.lists().outdated()) mine |= outdated;
  if (system_.forces.contacts().full()) mine |= crowded;
  if (system_.forces.links().tooLong()) mine |= tooLong;
  int wish = firstWish;
  for (const auto& observer : observers_) {
    // What has just been granted is done at the end of this step.
    if (!(granted_ & wish) && observer->wishes(now)) mine |= wish;
    wish <<= 1;
  }
  notices_.begin(mine, system_.forces.lists().farthest(), system_.state.comm());
}

bool Simulation::agreesFirst(View view) const {
  const State& state = system_.state;
  // Pairs that have been released in the last step outdate the lists of all ranks.
  const bool mayOutdate = state.gap && (state.step - 1) % gapCheckInterval == 0;
  return view == View::energies || state.extras().friction || mayOutdate;
}

bool Simulation::doubts() const {
  return notices_.mine() & (stale | unstable);
}

bool Simulation::listsHold() {
  State& state = system_.state;
  heard_ = notices_.wait();
  farthest_ = notices_.largest();
  if (heard_ & unstable) throwUnstable(moment(), parts_->plan->units);
  if (heard_ & crowded)
    throw RunError(
        format("step %lld: a segment has more than %d contacts with friction, which is all "
               "that it can remember: it lies across many others, or touches segments far shorter "
               "than itself",
               static_cast<long long>(state.step), contactSlots));
  if (heard_ & tooLong)
    throw RunError(
        format("step %lld: a link is nearly half as long as the periodic box, and would soon pull "
               "at another image of its end; make the box larger, or let links break",
               static_cast<long long>(state.step)));
  if (heard_ & broke) breaks_.spread(state);
  agreed_ = heard_ & ~(firstWish - 1);
  const bool hold = !(heard_ & (stale | outdated));
  if (hold) agreed_ |= heard_ & staleSoon;
  return hold;
}

void Simulation::renewLists() {
  ForceField& forces = system_.forces;
  if ((heard_ & outdated) || !forces.redraw(system_.state))
    forces.rebuild(system_.state, system_.domain);
}

ForceOutcome Simulation::evaluate(View view) {
  ForceField& forces = system_.forces;
  Halo& halo = system_.domain.halo();
  ForceRequest request;
  request.energies = view == View::energies;
  request.complete = false;
  request.advance = request.ahead = parts_->stepper->dt();
  if (system_.forces.lists().foresees()) {
    if (!agreesFirst(view))
      request.agreement = this;
    else if (!listsHold())
      renewLists();
  }
  const ForceOutcome outcome = forces.evaluate(system_.state, halo, request);
  if (!outcome.again) return outcome;
  const LogScope log(repeatEvent_);
  renewLists();
  request.agreement = nullptr;
  return forces.evaluate(system_.state, halo, request);
}

View Simulation::widestView() {
  const Moment now = moment();
  View widest = View::positions;
  for (const auto& observer : observers_) widest = std::max(widest, observer->view(now));
  return widest;
}

void Simulation::note(const ForceOutcome& outcome, bool energies) {
  system_.accounts.broken.merge(outcome.released);
  system_.accounts.friction.merge(outcome.friction);
  system_.accounts.external.merge(outcome.external);
  system_.accounts.damped.merge(outcome.dragged);
  breaks_.note(outcome.broken);
  if (energies) energies_ = sumEnergies(system_.state, system_.forces, outcome, system_.accounts);
}

void Simulation::requireEnergies() {
  if (energies_) return;
  ForceRequest request;
  request.energies = true;
  request.mayBreak = request.viscous = false;
  note(system_.forces.evaluate(system_.state, system_.domain.halo(), request), true);
}

Verdict Simulation::verdict() {
  const Moment now = moment();
  Verdict all = Verdict::goOn;
  for (const auto& observer : observers_) {
    const Verdict one = observer->verdict(now);
    if (one == Verdict::done) return one;
    all = std::max(all, one);
  }
  return all;
}

Ending Simulation::stopEarly() {
  const State& state = system_.state;
  const auto step = static_cast<long long>(state.step);
  std::string file = parts_->plan->settings.checkpointFile, reason;
  // Without -checkpoint_file, a name with the step in it that no file has.
  if (file.empty()) file = unusedName(format("checkpoint_%010lld", step), ".h5", state);
  if (lastCheckpoint_ != state.step) writeCheckpoint(file);
  for (const auto& observer : observers_)
    if (const std::string own = observer->reason(); !own.empty()) reason = own;
  PetscPrintf(state.comm(), "%s at step %lld; go on with -restart %s\n", reason.c_str(), step,
              file.c_str());
  return Ending::stopped;
}

RunRecord Simulation::stageRecord(const char* purpose) const {
  RunRecord record;
  record.texts = provenanceTexts(parts_->plan->provenance, purpose);
  record.reals["fibre"] = parts_->fingerprint();
  if (parts_->stage > 0) record.integers[RunParts::stageName] = {parts_->stage};
  if (const auto shapes = parts_->restShapes(); !shapes.empty())
    record.reals["rest_shapes"] = shapes;
  if (const auto links = parts_->linkNumbers(); !links.empty()) record.reals["links"] = links;
  system_.boundaries.save(record, system_.state.time);
  for (const auto& observer : observers_) observer->saveStage(record);
  return record;
}

RunRecord Simulation::fullRecord(const char* purpose) const {
  RunRecord record = stageRecord(purpose);
  saveAccounts(record, system_.accounts, parts_->plan->settings.thermostat.has_value(),
               system_.state.comm());
  record.reals["time_step"] = {parts_->stepper->dt()};
  if (parts_->defaultStep) record.reals["default_step"] = {*parts_->defaultStep};
  parts_->stepper->save(record);
  system_.forces.walls().save(record, system_.state.comm());
  for (const auto& observer : observers_) observer->save(record);
  return record;
}

void Simulation::sync() {
  for (const auto& observer : observers_) observer->sync();
}

void Simulation::writeCheckpoint(const std::string& file) {
  const LogScope log(fileEvent_);
  const double begin = secondsSinceStart();
  // A checkpoint must not hold forces of which a part was left out.
  agree<RunError>(system_.state.comm(),
                  system_.forces.beyondSums() ? beyondSumsText(system_.state.step) : "");
  // Tables reach the disk before the checkpoint does, since a restart expects their rows.
  sync();
  writeState(file, system_.state, parts_->plan->units, fullRecord(checkpointPurpose));
  const double took = secondsSinceStart() - begin;
  checkpointSeconds_ = checkpointTimed_ ? std::max(took, checkpointSeconds_) : took;
  checkpointTimed_ = true;
  lastCheckpoint_ = system_.state.step;
  good_.note(file, system_.state.step);
}

}  // namespace nanoweft
