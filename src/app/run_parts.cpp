#include "nanoweft/app/run_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "nanoweft/app/accounts_record.hpp"
#include "nanoweft/app/provenance.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/gather.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/base/threads.hpp"
#include "nanoweft/force/make_links.hpp"
#include "nanoweft/force/pair_survey.hpp"
#include "nanoweft/motion/breakage.hpp"
#include "nanoweft/scene/start_check.hpp"
#include "nanoweft/state/rest.hpp"

namespace nanoweft {

namespace {

/// With fewer segments a thread waits longer for the others than it works.
constexpr std::int64_t segmentsPerThread = 1500;

/// Coordinate over a segment's length. So far out a coordinate has still seven digits of a segment.
constexpr double farthestOverShortest = 1e9;

/// Strain of a link at the start beyond which it is worth a warning.
constexpr double noticedLinkStrain = 0.5;

/// Default time step over the stable one, and the most of that of fibres pressed together.
constexpr double usualShare = 0.4, pressedShare = 0.8;

/// For each kind eight numbers, as RunParts::fingerprint.
std::vector<double> numbersOf(const Kinds& kinds) {
  std::vector<double> numbers;
  for (const Fibre& f : kinds)
    numbers.insert(numbers.end(), {f.radius, f.length, f.mass, f.inertia, f.bond.stretch,
                                   f.bond.shear, f.bond.bending, f.bond.torsion});
  return numbers;
}

/// For each kind three numbers, as RunParts::restShapes.
std::vector<double> shapesOf(const Kinds& kinds) {
  std::vector<double> numbers;
  if (!kinds.curved()) return numbers;
  for (const Fibre& f : kinds) numbers.insert(numbers.end(), {f.rest.x, f.rest.y, f.rest.z});
  return numbers;
}

/// The kinds of those names, in their order; all as they are where the names do not fit.
Kinds inOrder(const Kinds& kinds, const std::vector<std::string>& names) {
  std::vector<Fibre> fibres;
  for (const std::string& name : names)
    for (const Fibre& f : kinds)
      if (f.kind == name) fibres.push_back(f);
  return static_cast<int>(fibres.size()) == kinds.count() ? Kinds(std::move(fibres)) : kinds;
}

/// Gives each bond the rest rotation of its kind.
void takeRestOfKinds(State& state, const Kinds& kinds) {
  for (int i = 0; i < state.owned(); ++i) setRest(state, i, kinds[state.kind(i)].restRotation());
}

/// A new run may have other walls than the one that left the state.
void forgetWallContacts(State& state) {
  const std::size_t slots = contactSlots * static_cast<std::size_t>(state.owned());
  for (std::size_t k = 0; k < slots; ++k)
    if (state.contact[k] < 0) state.contact[k] = 0, std::fill_n(state.spring + 3 * k, 3, 0.0);
}

/// For each kind of link five numbers, as RunParts::linkNumbers.
std::vector<double> linkNumbersOf(const LinkLaws& laws) {
  std::vector<double> numbers;
  for (const LinkLaw& law : laws)
    numbers.insert(numbers.end(), {law.spring ? 1.0 : 0.0, law.bond.stretch, law.bond.shear,
                                   law.bond.bending, law.bond.torsion});
  return numbers;
}

/// The laws of the kinds of those names, in their order. Without names it is that of the first.
LinkLaws inOrder(const LinkLaws& laws, const std::vector<std::string>& names) {
  if (names.empty()) return {laws[0]};
  LinkLaws theirs;
  for (const std::string& name : names)
    for (const LinkLaw& law : laws)
      if (law.kind == name) theirs.push_back(law);
  return theirs;
}

std::vector<double> restShapesOf(const RunRecord& record) {
  const auto it = record.reals.find("rest_shapes");
  return it == record.reals.end() ? std::vector<double>() : it->second;
}

}  // namespace

RunParts::RunParts(std::unique_ptr<RunPlan> thePlan, Team theTeam)
    : plan(std::move(thePlan)), team(theTeam) {
  makeForces();
  fillState();
  chooseTeam();
  findStage();
  if (!plan->checkpoint && plan->settings.perturb > 0) perturb();
  goOn();
  share();
  if (!plan->checkpoint && forces->pairs()) {
    const bool deep = plan->settings.allowOverlap || evaluatesOnly();
    if (!plan->settings.allowOverlap) refuseOverlap();
    if (deep) refuseLargeSums();
  }
  if (!plan->checkpoint && plan->kinds.several()) lookAtKinds();
  lookAtGroups();
  if (state->linked) refuseLinksOfHalfTheBox();
  if (!plan->checkpoint && state->linked) lookAtLinks();
  if (!plan->checkpoint && forces->walls() && !evaluatesOnly() && !plan->settings.startUnchecked)
    refuseInWalls();
  chooseStep();
}

void RunParts::makeForces() {
  ForceField::Settings force;
  force.kinds = plan->kinds;
  force.pairs = std::move(plan->pairs);
  force.breakage = plan->breakage;
  force.links = plan->links;
  force.walls = plan->walls;
  force.viscous = plan->settings.viscous;
  force.skin = plan->settings.skin;
  force.threads = team.asked;
  int ranks = 1;
  MPI_Comm_size(plan->comm, &ranks);
  force.foresees = ranks >= plan->settings.lateFrom;
  forces = std::make_unique<ForceField>(std::move(force), plan->box);
}

void RunParts::fillState() {
  const UnitSystem& units = plan->units;
  ExtraFields extras;
  extras.gap = plan->breaks() && forces->pairs();
  auto startHas = [&](const char* part) {
    const StateHeader* header = plan->startHeader();
    return header && header->parts.contains(part);
  };
  const bool flows = plan->kinds.yields();
  const bool shaped = startHas("rest_rotation") || (plan->scene && plan->scene->shapesRest());
  extras.rest = flows || shaped;
  extras.extension = flows || startHas("rest_extension");
  if (!plan->checkpoint && shaped && plan->kinds.curved())
    throw InputError(
        "-fibre_rest_curvature, -fibre_rest_twist: not used by this run, whose bonds have rest "
        "rotations of their own (-SCENE_rest shaped, or rest_rotation in the state file)");
  const bool rubs = forces->pairs().rubs() || forces->walls().rub();
  extras.viscous = plan->settings.viscous ||
                   ((plan->kinds.viscous() || rubs) && !plan->settings.stepper->minimises);
  extras.friction = rubs && !plan->settings.stepper->minimises;
  extras.ends = forces->pairs().touches();
  state = std::make_unique<State>(plan->comm, plan->box, extras);
  state->kinds = plan->kinds.names();
  state->linkKinds = namesOf(plan->links);
  if (plan->checkpoint) {
    requireParts(*plan->checkpoint, extras);
    readStateRows(plan->restart, *plan->checkpoint, *state);
  } else {
    plan->scene->fill(*state);
    if (flows && plan->kinds.curved()) takeRestOfKinds(*state, plan->kinds);
    if (extras.friction) forgetWallContacts(*state);
  }
  // Before the first lists: the other segment of a broken bond may be anywhere.
  if (plan->breaks()) spreadOldBreaks(*state, forces->pairs().exclude());
  if (extras.ends) {
    if (!plan->checkpoint) state->noteFreeEnds();
    state->recallFreeEnds();
  }
  requireNear(*state, farthestOverShortest * plan->kinds.shortest(), units.length);
  requireWideBox(plan->box, 3 * plan->kinds.longest(), "three segments", units.length);
  // Checked first: a bad start would fail later checks, too, and those would name another cause.
  if (!plan->checkpoint) checkStart();
  if (forces->pairs())
    requireWideBox(plan->box, 2 * forces->lists().range(),
                   "two list ranges (reach of the forces + skin)", units.length);
}

void RunParts::findStage() {
  const StateHeader* header = plan->startHeader();
  if (!header || !header->run.texts.contains(purposeText)) return;
  const auto& integers = header->run.integers;
  if (integers.contains(stageName)) stage = header->run.needIntegers(stageName, 1)[0];
  if (!plan->checkpoint) ++stage;
  if (auto& thermostat = plan->settings.thermostat) thermostat->seed = stageSeed();
}

std::uint64_t RunParts::stageSeed() const {
  return plan->settings.seed + 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(stage);
}

void RunParts::chooseTeam() {
  if (team.atMost) {
    const std::int64_t busy = state->total() / state->ranks() / segmentsPerThread;
    team.asked = static_cast<int>(std::clamp<std::int64_t>(busy, 1, team.asked));
  }
  team.given = teamGiven(team.asked);
  teamSize.emplace(team.given, plan->settings.allThreads, team.cores);
  forces->lists().setThreads(team.given);
}

void RunParts::checkStart() {
  const StateHeader* file = plan->scene->header();
  const Box own = plan->scene->box();
  bool evolved = false;
  const Kinds theirs = inOrder(plan->kinds, file ? file->kinds : std::vector<std::string>());
  if (file)
    if (const auto it = file->run.reals.find("fibre"); it != file->run.reals.end())
      evolved = it->second == numbersOf(theirs) && restShapesOf(file->run) == shapesOf(theirs) &&
                own.lower == plan->box.lower && own.upper == plan->box.upper &&
                own.periodic == plan->box.periodic;
  if (file) {
    warnings = file->strange;
    lookAtImages();
  }
  const bool refuse = !evaluatesOnly() && !plan->settings.startUnchecked;
  if (file)
    if (const auto it = file->run.reals.find("links");
        it != file->run.reals.end() &&
        it->second != linkNumbersOf(inOrder(plan->links, file->linkKinds)))
      warnings.emplace_back(
          "the run that left the state had links of another law (-link_law, -link_stretch, "
          "-link_stiffness); their rest is that of the file");
  for (const StartFinding& finding : lookAtStart(
           *state,
           {plan->units, plan->kinds, own, plan->scene->asked(), file != nullptr, evolved})) {
    if (finding.refused && refuse)
      throw InputError("the start cannot be meant: " + finding.text + " (or -start_unchecked)");
    warnings.push_back("at the start, " + finding.text);
  }
}

void RunParts::lookAtImages() {
  const State& s = *state;
  struct Place {
    double x[3] = {};
    std::int64_t fibre = -1;  ///< -1: none, or its bond to the next one is broken
  };
  auto placeOf = [&](int i) {
    const Vec3d x = s.box.unwrapped(s.pose + 8 * i, s.image + 3 * i);
    return Place{{x.x, x.y, x.z}, s.bond[i] & nextBroken ? -1 : s.fibre[i]};
  };
  // Rows are still in the order of the file: a rank's first one follows the last of another rank.
  const bool any = s.owned() > 0;
  const Place mine = any ? placeOf(s.owned() - 1) : Place{};
  std::vector<Place> lasts(static_cast<std::size_t>(s.ranks()));
  MPI_Allgather(&mine, sizeof mine, MPI_BYTE, lasts.data(), sizeof mine, MPI_BYTE, s.comm());
  Place before = any && s.rank() > 0 ? lasts[static_cast<std::size_t>(s.rank()) - 1] : Place{};
  const MinimumImage nearest(s.box);
  std::int64_t torn = 0, first = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < s.owned(); ++i) {
    const Place here = placeOf(i);
    const Vec3d way{here.x[0] - before.x[0], here.x[1] - before.x[1], here.x[2] - before.x[2]};
    // They differ by whole periods.
    if (s.chain[2 * i] > 0 && before.fibre == s.fibre[i] &&
        norm(nearest(way) - way) > plan->kinds.shortest()) {
      ++torn;
      first = std::min(first, s.fibre[i]);
    }
    before = here;
  }
  MPI_Allreduce(MPI_IN_PLACE, &torn, 1, MPI_INT64_T, MPI_SUM, s.comm());
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, s.comm());
  if (torn > 0)
    warnings.push_back(
        format("/state/image of the file tears %lld bonds of fibres (fibre %lld first): forces are "
               "right, but not what is measured along fibres; leave image out, and it is found",
               static_cast<long long>(torn), static_cast<long long>(first)));
}

void RunParts::perturb() {
  State& s = *state;
  const std::uint64_t seed = stageSeed();
  for (int i = 0; i < s.owned(); ++i) {
    for (int c = 0; c < 3; ++c)
      s.pose[8 * i + c] +=
          plan->settings.perturb * normalDraw(seed + static_cast<std::uint64_t>(c) * 0x9E3779B9u,
                                              Purpose::perturbation, s.fibre[i],
                                              static_cast<std::uint32_t>(s.chain[2 * i]));
    s.box.wrap(s.pose + 8 * i, s.image + 3 * i);
  }
}

void RunParts::goOn() {
  const RunRecord empty;
  const StateHeader* header = plan->startHeader();
  const RunRecord& record = header ? header->run : empty;
  Boundaries& boundaries = plan->boundaries;
  boundaries.attach(*state, record, plan->checkpoint.has_value());
  if (boundaries.booksWork()) accounts.groups.resize(boundaries.list().size());
  if (plan->checkpoint) restore(record);
  forces->walls().place(state->time);
  plan->boxDrive.attach(state->box, record, plan->checkpoint.has_value());
  if (const auto& t = plan->settings.thermostat; t && t->drawsStart && !plan->checkpoint)
    drawVelocities(*state, plan->kinds, boundaries, *t);
  if (plan->checkpoint) return;
  if (boundaries.tensionGoesOn())
    for (const auto& observer : plan->observers) observer->restoreStage(record);
  if (boundaries.tension() && !evaluatesOnly()) refuseEnded(*boundaries.tension(), record);
}

void RunParts::refuseEnded(const Tension& t, const RunRecord& record) const {
  if (!t.over(t.start)) return;
  if (plan->boundaries.tensionGoesOn())
    throw InputError(
        format("-tension_max_strain %g: the tension test that %s carries has reached a strain of "
               "%g; give a larger one, or start a test of its own with -tension_new",
               t.maxStrain, record.source.c_str(), t.before));
  throw InputError(
      format("-tension_max_strain %g: with a rate of %g the strain goes from 0 the "
             "other way",
             t.maxStrain, t.rate));
}

void RunParts::restore(const RunRecord& record) {
  const std::string& file = plan->restart;
  if (record.needReals("fibre", fingerprint().size()) != fingerprint() ||
      restShapesOf(record) != restShapes())
    throw InputError("-restart " + file +
                     ": its fibres have other parameters than the options say (-fibre_...)");
  if (plan->checkpoint->units != plan->units.name)
    throw InputError(format("-restart %s: it is in units %s, its options in %s", file.c_str(),
                            plan->checkpoint->units.c_str(), plan->units.name.c_str()));
  restoreAccounts(accounts, record, plan->settings.thermostat.has_value(), state->rank());
  forces->walls().restore(record, state->rank());
  for (const auto& observer : plan->observers) observer->restore(record);
}

void RunParts::share() {
  domain = std::make_unique<Domain>(*state, plan->settings.partition);
  forces->rebuild(*state, *domain);
  if (!plan->checkpoint &&
      std::ranges::any_of(plan->links, [](const LinkLaw& law) { return law.density > 0; })) {
    makeLinks(*state, *forces, plan->units, stageSeed());
    forces->rebuild(*state, *domain);
  }
  // The first shares know no measured work. They may be made twice more: from it, then by METIS.
  for (int k = 0; k < 2 && domain->unequal(); ++k) forces->rebuild(*state, *domain);
  if (domain->revoked()) forces->rebuild(*state, *domain);
}

void RunParts::refuseOverlap() const {
  const UnitSystem& units = plan->units;
  // A run that makes no step may have deep overlaps; only points that nearly coincide are refused,
  // since the direction of their force is lost.
  const ClosestPair c = findClosestPair(*state, *forces, [&](const PairForce& force) {
    const Both<double> radius = force.radius();
    return evaluatesOnly() ? 0.25 * std::min(radius.i, radius.j) : force.closestSensible();
  });
  if (c.distance >= c.least) return;
  throw InputError(format(
      "fibres overlap: fibre %lld segment %d and fibre %lld segment %d are %.4g %s apart, and "
      "their walls meet at %.4g %s; "
      "move them apart (or -pair_allow_overlap)",
      static_cast<long long>(c.fibre[0]), c.index[0], static_cast<long long>(c.fibre[1]),
      c.index[1], c.distance, units.length, c.sensible, units.length));
}

void RunParts::refuseLargeSums() const {
  const StrongestSum s = findStrongestSum(*state, *forces);
  if (s.share < 1.0) return;
  throw InputError(format(
      "fibres overlap so much that the pair forces on fibre %lld segment %d are beyond what is "
      "summed, four times that of two segments deep in each other; move them apart",
      static_cast<long long>(s.fibre), s.index));
}

void RunParts::lookAtKinds() {
  std::vector<int> present(static_cast<std::size_t>(plan->kinds.count()), 0);
  for (int i = 0; i < state->owned(); ++i) present[static_cast<std::size_t>(state->kind(i))] = 1;
  MPI_Allreduce(MPI_IN_PLACE, present.data(), plan->kinds.count(), MPI_INT, MPI_MAX, state->comm());
  for (int k = 0; k < plan->kinds.count(); ++k)
    if (!present[static_cast<std::size_t>(k)])
      warnings.push_back(format(
          "no fibre is of the kind %s, which yet decides on the step and the lists; what a scene's "
          "fibres are of is said by its own option of kinds, such as -weave_kinds",
          plan->kinds[k].kind.c_str()));
  if (std::ranges::none_of(plan->links, [](const LinkLaw& law) { return law.density > 0; })) return;
  for (int i = 0; i < plan->kinds.count(); ++i)
    for (int j = i; j < plan->kinds.count(); ++j)
      if (present[static_cast<std::size_t>(i)] && present[static_cast<std::size_t>(j)] &&
          !forces->pairs().between(i, j))
        warnings.push_back(format(
            "-links_density makes no links between %s and %s: they have no pair law, from whose "
            "lists links are made",
            plan->kinds[i].kind.c_str(), plan->kinds[j].kind.c_str()));
}

void RunParts::lookAtGroups() {
  for (const Boundary& b : plan->boundaries.list())
    for (int d = 0; d < 3; ++d)
      if (b.fix[static_cast<std::size_t>(d)] && plan->boxDrive.carries(d))
        warnings.push_back(
            format("%s is held along %c against the box, which carries all segments that way as it "
                   "is driven",
                   b.name.c_str(), "xyz"[d]));
  for (std::string& lost : plan->boundaries.lostLoads(*state)) warnings.push_back(std::move(lost));
}

void RunParts::lookAtLinks() {
  const StateHeader* file = plan->scene->header();
  // A run of this program has strained what it left.
  if (!file || file->run.reals.contains("links")) return;
  struct {
    long long fibre[2] = {0, 0};
    int index[2] = {0, 0};
    double length = 0, rest = 0;
  } link;
  double worst = noticedLinkStrain;
  for (std::size_t k = 0; k < state->links.size(); ++k) {
    const Link& l = state->links[k];
    if (l.broken || forces->links().ends(k)[0] >= state->owned()) continue;
    const double length = norm(forces->links().resolve(*state, forces->nearest(), k).separation);
    if (const double strain = std::abs(length / l.length - 1.0); strain > worst) {
      worst = strain;
      link = {{l.fibre[0], l.fibre[1]}, {l.index[0], l.index[1]}, length, l.length};
    }
  }
  if (largestOfRanks(worst, link, state->comm()) == noticedLinkStrain) return;
  warnings.push_back(format(
      "at the start, the link of fibre %lld segment %d to fibre %lld segment %d is %.4g %s long, "
      "and %.4g at rest (link/rest_length)",
      link.fibre[0], link.index[0], link.fibre[1], link.index[1], link.length, plan->units.length,
      link.rest));
}

void RunParts::refuseLinksOfHalfTheBox() const {
  struct {
    long long fibre[2] = {0, 0};
    int index[2] = {0, 0};
    double length = 0;
  } link;
  double most = LinkForces::mostOfHalf;
  for (std::size_t k = 0; k < state->links.size(); ++k) {
    const Link& l = state->links[k];
    if (l.broken || forces->links().ends(k)[0] >= state->owned()) continue;
    const Vec3d way = forces->links().resolve(*state, forces->nearest(), k).separation;
    if (const double share = forces->nearest().shareOfHalf(way); share > most) {
      most = share;
      link = {{l.fibre[0], l.fibre[1]}, {l.index[0], l.index[1]}, norm(way)};
    }
  }
  if (largestOfRanks(most, link, state->comm()) == LinkForces::mostOfHalf) return;
  throw InputError(format(
      "the link of fibre %lld segment %d to fibre %lld segment %d is %.4g %s long, half of the "
      "periodic box, so that two images of its end are as near; make the box larger",
      link.fibre[0], link.index[0], link.fibre[1], link.index[1], link.length, plan->units.length));
}

void RunParts::refuseInWalls() const {
  // Deeper than a radius, the fibre's axis is inside the wall.
  const WallForces::Depth d = forces->walls().deepest(*state, forces->nearest());
  if (d.radii <= 1.0) return;
  throw InputError(
      format("fibre %lld segment %d is %.3g of its radii deep in the wall %s; move one of them (or "
             "-start_unchecked)",
             static_cast<long long>(d.fibre), d.index, d.radii,
             plan->walls[static_cast<std::size_t>(d.wall)].name.c_str()));
}

double RunParts::defaultTimeStep() {
  // Where nothing is held at the start, bonds and contacts may come.
  double stable = chainStepLimit(plan->kinds);
  if (std::isfinite(limits.present) && limits.present > 0) stable = limits.present;
  // Fibres that are apart may be pressed together later.
  const double pressed = bundleStepLimit(plan->kinds, forces->pairs());
  if (plan->minimises()) return adaptedShare * std::min(stable, pressed);
  // The shortest of the presets' steps, when all kinds have one.
  double usual = std::numeric_limits<double>::infinity();
  for (const Fibre& f : plan->kinds) usual = std::min(usual, f.step);
  if (usual > 0) return usual;
  // A restart keeps the step that was chosen at the start.
  if (plan->checkpoint && plan->checkpoint->run.reals.contains("default_step"))
    return *(defaultStep = plan->checkpoint->run.needReals("default_step", 1)[0]);
  const double step = std::min(usualShare * stable, pressedShare * pressed);
  if (!evaluatesOnly()) defaultStep = step;
  return step;
}

void RunParts::chooseStep() {
  const RunSettings& settings = plan->settings;
  if (!evaluatesOnly()) limits.note(presentStepLimit(*state, *forces, domain->halo()));
  const double dt = settings.dt ? *settings.dt : defaultTimeStep();
  // A run that has gone on beyond the stable step, with a warning, goes on so after a restart.
  const bool chosen = !plan->checkpoint || plan->stepIsNew;
  const bool judged = !evaluatesOnly() && !settings.unsafeStep && chosen;
  if (judged && !(limits.present > 0) && !plan->minimises())
    throw InputError(
        "the stable step cannot be estimated: something (a contact, a link, a wall) is more than "
        "1e5 times as stiff as the bonds of the fibres, or a parameter is out of all proportion "
        "(or -ts_dt_unsafe)");
  if (judged && limits.present > 0 && dt > limits.present)
    throw InputError(
        format("-ts_dt %g: beyond the stable step of this state, %.4g %s; take at most half of "
               "that (or -ts_dt_unsafe)",
               dt, limits.present, plan->units.time));
  for (const Wall& w : plan->walls)
    if (dt * w.drag > 2.0 * w.mass && w.driven() && chosen && !evaluatesOnly())
      throw InputError(
          format("-ts_dt %g: -%s_drag stops the wall within it; at most twice its mass "
                 "over its drag, %.4g %s",
                 dt, w.name.c_str(), 2.0 * w.mass / w.drag, plan->units.time));
  stepper = settings.stepper->make(
      plan->kinds, {dt, settings.damping, settings.thermostat, settings.fireMaxMove});
  if (!plan->checkpoint) return;
  stepper->restore(plan->checkpoint->run);
  if (!plan->stepIsNew) return;
  stepBefore =
      stepper->adapts() ? stepper->longest() : plan->checkpoint->run.needReals("time_step", 1)[0];
  stepper->setLongest(*settings.dt);
}

std::vector<double> RunParts::restShapes() const {
  return shapesOf(plan->kinds);
}

std::vector<double> RunParts::linkNumbers() const {
  return state->linked ? linkNumbersOf(plan->links) : std::vector<double>();
}

std::vector<double> RunParts::fingerprint() const {
  return numbersOf(plan->kinds);
}

}  // namespace nanoweft
