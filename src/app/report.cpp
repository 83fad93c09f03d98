#include "nanoweft/app/report.hpp"

#include <omp.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "nanoweft/app/instability.hpp"
#include "nanoweft/app/round_off.hpp"
#include "nanoweft/app/wall_time.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/simd.hpp"
#include "nanoweft/force/quadrature.hpp"
#include "nanoweft/motion/residual.hpp"
#include "nanoweft/motion/step_limit.hpp"

namespace nanoweft {

namespace {

/// Share of damping in the work of grips and loads beyond which the summary has a remark on it.
constexpr double noticedDampingShare = 0.05;
/// Excess of the distance of held segments over the gage that is warned of.
constexpr double noticedGage = 0.01;
/// Error of the energy balance, over the energy that there was, that is remarked on.
constexpr double noticedDrift = 0.05;

/// "cnt " in front of what belongs to the kind cnt; nothing where kinds have no names.
std::string ofKind(const Fibre& f) {
  return f.kind.empty() ? "" : f.kind + " ";
}

void printFibre(MPI_Comm comm, const Fibre& f, const UnitSystem& units) {
  const EvmBond& b = f.bond;
  const std::string wall = f.wall > 0 ? format("wall %g %s", f.wall, units.length) : "solid";
  // By format(): PetscPrintf would put a point behind whole numbers.
  const std::string moduli = f.elastic ? format("E %g GPa, G %g GPa, ", f.young / units.gigapascal,
                                                f.shear / units.gigapascal)
                                       : "";
  const std::string fibre = format(
      "  %sfibre: from %s, radius %g %s, %s, %sdensity %.5g kg/m^3, %.5g %s a length of 1 %s\n",
      ofKind(f).c_str(), f.preset.c_str(), f.radius, units.length, wall.c_str(), moduli.c_str(),
      f.density() / units.kilogramPerCubicMetre, f.mass / units.mass / f.length, units.massName,
      units.length);
  PetscPrintf(comm, "%s", fibre.c_str());
  PetscPrintf(comm,
              "  %ssegment: length %g %s, mass %.5g %s, inertia %.5g %s %s^2; bond: B1 %.5g, B2 "
              "%.5g, B3 %.5g, B4 %.5g\n",
              ofKind(f).c_str(), f.length, units.length, f.mass / units.mass, units.massName,
              f.inertia / units.mass, units.massName, units.length, b.stretch, b.shear, b.bending,
              b.torsion);
  if (f.kinks())
    PetscPrintf(comm, "  %skinks at an angle of %.4g rad between neighbours\n", ofKind(f).c_str(),
                2.0 * std::asin(0.5 * f.kink.angle));
  if (f.viscosity)
    PetscPrintf(comm, "  %sinternal viscosity: retardation times up to %g %s\n", ofKind(f).c_str(),
                f.retardation, units.time);
  if (f.yield) {
    std::string beyond;
    if (std::isfinite(f.yield.stretch))
      beyond = format("a strain of %.4g", f.yield.stretch / f.length);
    if (std::isfinite(f.yield.angle))
      beyond +=
          format("%san angle of %.4g rad a bond", beyond.empty() ? "" : " and ", f.yield.angle);
    PetscPrintf(comm, "  %sflows beyond %s\n", ofKind(f).c_str(), beyond.c_str());
  }
  if (!f.curved()) return;
  const std::string shape = format("  %srest shape: twist %g, curvature %g and %g 1/%s\n",
                                   ofKind(f).c_str(), f.rest.x, f.rest.y, f.rest.z, units.length);
  PetscPrintf(comm, "%s", shape.c_str());
}

/// "5", or with the kinds' names where two have their own number.
std::string pointsOf(Both<int> points, const Fibre& a, const Fibre& b) {
  return &a == &b ? format("%d", points.i)
                  : format("%d (%s), %d (%s)", points.i, a.kind.c_str(), points.j, b.kind.c_str());
}

void printPairForce(MPI_Comm comm, const PairForces::Class& c, const Kinds& kinds,
                    const UnitSystem& units) {
  const PairForce& p = *c.force;
  const Fibre &a = kinds[c.first], &b = kinds[c.second];
  const PointChoice& points = p.points();
  const std::string far =
      points.split() ? format(", %s for what reaches beyond %.6g %s",
                              pointsOf(points.far, a, b).c_str(), points.from, units.length)
                     : "";
  // In the order of -kinds, as the prefix of its options.
  const bool inOrder = c.first <= c.second;
  const std::string between =
      a.kind.empty() ? "" : " " + (inOrder ? a : b).kind + "_" + (inOrder ? b : a).kind;
  PetscPrintf(comm, "  pair forces%s: %s\n", between.c_str(), p.description().c_str());
  std::string rest;
  if (p.touches()) {
    if (!c.mixed()) PetscPrintf(comm, "    within a fibre from %d segments on\n", p.exclude());
    return;
  }
  if (!c.mixed()) {
    const auto error = expectedForceErrors(p, a);
    // A law without a gap repels from where fibres touch; its error is that of an overlap.
    const bool soft = p.restDistance() <= a.diameter();
    rest = format(", expected force error %s%s; within a fibre from %d segments (%.5g %s) on",
                  error ? format("%.2g %% (bundle), %.2g %% (crossing)", 100 * error->bundle,
                                 100 * error->crossing)
                              .c_str()
                        : "not estimated",
                  error && soft ? " at an overlap of a tenth of a radius, more at less" : "",
                  p.exclude(), p.exclude() * a.length, units.length);
  }
  PetscPrintf(comm, "    %s points a segment%s%s\n", pointsOf(points.near, a, b).c_str(),
              far.c_str(), rest.c_str());
  for (const std::string& warning : pointWarnings(p, a, b, units))
    PetscPrintf(comm, "  warning: %s\n", warning.c_str());
}

/// Ranges over the segment length below which a segment's pairs along another fibre are too few to
/// stand for a density.
constexpr double shortRange = 2.0;

void warnOfShortDamping(const RunPlan& plan, const PairForces& pairs) {
  if (!plan.settings.viscous || !pairs) return;
  for (const PairForces::Class& c : pairs.classes()) {
    const Fibre &a = plan.kinds[c.first], &b = plan.kinds[c.second];
    if (c.force->cutoff() > shortRange * std::max(a.length, b.length)) continue;
    PetscPrintf(
        plan.comm,
        "  warning: -damping_viscous acts between pairs of segments within the range of their "
        "law, %.4g %s, which is short beside segments of %.4g %s: it depends on their "
        "length\n",
        c.force->cutoff(), plan.units.length, std::max(a.length, b.length), plan.units.length);
    return;
  }
}

void printPairForces(MPI_Comm comm, const PairForces& pairs, const Kinds& kinds,
                     const UnitSystem& units) {
  if (!pairs) PetscPrintf(comm, "  pair forces: none\n");
  for (const PairForces::Class& c : pairs.classes()) {
    printPairForce(comm, c, kinds, units);
    if (!pairs.keepsApart(c.first, c.second))
      PetscPrintf(
          comm,
          "  warning: this law only attracts, and nothing keeps these fibres apart; add one "
          "that does, as in -pair capillary,contact\n");
  }
  if (!pairs || !kinds.several()) return;
  for (int i = 0; i < kinds.count(); ++i)
    for (int j = i; j < kinds.count(); ++j)
      if (!pairs.between(i, j))
        PetscPrintf(comm, "  pair forces %s_%s: none\n", kinds[i].kind.c_str(),
                    kinds[j].kind.c_str());
}

void printBreakage(MPI_Comm comm, const BreakageLaw& law, const Fibre& fibre,
                   const UnitSystem& units) {
  const std::string strain = law.weibull ? format("by Weibull's law, shape %g, %g for %g %s",
                                                  law.shape, law.strain0, law.length0, units.length)
                                         : format("of %g +- %g", law.mean, law.deviation);
  // A normal draw for a whole fibre does not depend on its length.
  const std::string gage =
      law.weibull || law.perFibre ? "" : format(" for %g %s", fibre.diameter(), units.length);
  const std::string along = law.perFibre && law.scatter > 0
                                ? format(" with a scatter of %g of it along the fibre", law.scatter)
                                : "";
  PetscPrintf(comm, "  %sbonds break at a strain %s%s, one draw per %s%s, seed %llu\n",
              ofKind(fibre).c_str(), strain.c_str(), gage.c_str(), law.perFibre ? "fibre" : "bond",
              along.c_str(), static_cast<unsigned long long>(law.seed));
  if (const double share = law.shareWithoutStrength(); share > 1e-6)
    PetscPrintf(comm,
                "  warning: %.2g %% of the draws are no strength at all, and their bonds break at "
                "once: take a smaller -break_strain_std or -break_scatter\n",
                100 * share);
}

void printLinksOf(MPI_Comm comm, std::int64_t count, const LinkLaw& law, const UnitSystem& units) {
  const std::string strength =
      (std::isinf(law.breakStrain) ? "" : format(", break at a strain of %g", law.breakStrain)) +
      (std::isinf(law.breakForce) ? "" : format(", break at %g %s", law.breakForce, units.force));
  const std::string text =
      law.spring ? format("springs of %.5g %s/%s^2", law.bond.stretch, units.energy, units.length)
                 : format("bonds with B1 %.5g, B2 %.5g, B3 %.5g, B4 %.5g", law.bond.stretch,
                          law.bond.shear, law.bond.bending, law.bond.torsion);
  PetscPrintf(comm, "  %lld %slinks: %s%s\n", static_cast<long long>(count),
              law.kind.empty() ? "" : (law.kind + " ").c_str(), text.c_str(), strength.c_str());
}

void printLinks(const RunParts& parts) {
  const State& state = *parts.state;
  const LinkLaws& laws = parts.plan->links;
  std::vector<std::int64_t> counts(laws.size(), 0);
  // Links of two ranks are held by both and counted by the owner of their first end.
  for (std::size_t k = 0; k < state.links.size(); ++k)
    if (parts.forces->links().ends(k)[0] < state.owned())
      ++counts[static_cast<std::size_t>(state.links[k].kind)];
  MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(counts.size()), MPI_INT64_T, MPI_SUM,
                state.comm());
  for (std::size_t k = 0; k < laws.size(); ++k)
    printLinksOf(state.comm(), counts[k], laws[k], parts.plan->units);
}

void printTeam(const RunParts& parts) {
  const int ranks = parts.state->ranks(), threads = parts.team.given;
  PetscPrintf(parts.plan->comm, "nanoweft %s: %d rank%s x %d thread%s, %s\n", NANOWEFT_VERSION,
              ranks, ranks > 1 ? "s" : "", threads, threads > 1 ? "s" : "", simdName);
  if (threads < parts.team.asked)
    PetscPrintf(parts.plan->comm, "  %d threads asked, the runtime gives %d\n", parts.team.asked,
                threads);
}

void printTension(const State& state, const Tension& t, const UnitSystem& units) {
  const MPI_Comm comm = state.comm();
  std::string course = t.program ? "strain " + t.program->text() : format("rate %g", t.rate);
  if (const double peak = t.peakRate();
      !t.program && std::abs(peak) < (1.0 - 1e-9) * std::abs(t.rate))
    course += format(" (%.3g at most: the way is short for its ramp)", peak);
  PetscPrintf(comm, "  tension along %c: gage %.5g %s, width %.5g %s, thickness %.4g %s, %s 1/%s\n",
              "xyz"[t.axis], t.gage, units.length, t.width, units.length, t.thickness, units.length,
              course.c_str(), units.time);
  if (t.between > (1.0 + noticedGage) * t.gage)
    PetscPrintf(
        comm,
        "  warning: the innermost segments that the grips hold are %.5g %s from each other%s, "
        "and strain is counted by the gage: it is %.2g %% too large; let the grips end at "
        "segments (-tension_grip)\n",
        t.between, units.length, state.kinds.size() > 1 ? " in one kind" : "",
        100.0 * (t.between / t.gage - 1.0));
  const HeldFibres held = heldFibres(state);
  PetscPrintf(comm,
              "    grips hold fibres: %lld both, %lld the left one only, %lld the right one\n",
              static_cast<long long>(held.both), static_cast<long long>(held.left),
              static_cast<long long>(held.right));
}

/// Overlap, over the radius, that points of a segment beside a round wall should resolve.
constexpr double wallOverlap = 0.1;

void warnOfCoarseWall(MPI_Comm comm, const Wall& w, const Kinds& kinds, const UnitSystem& units) {
  if (w.shape == Wall::plane || w.inside) return;
  for (const Fibre& f : kinds) {
    const double spacing = WallForces::pointSpacing(f),
                 wide = std::sqrt(2.0 * (w.radius + f.radius) * wallOverlap * f.radius);
    if (spacing <= wide) continue;
    PetscPrintf(comm,
                "  warning: %ssegments touch walls by points %.3g %s apart, too coarse for a wall "
                "whose touch is %.3g %s wide: forces vary along the fibre; take "
                "-%sfibre_segment_length %.3g\n",
                ofKind(f).c_str(), spacing, units.length, 2.0 * wide, units.length,
                f.kind.empty() ? "" : (f.kind + "_").c_str(), f.length * wide / spacing);
  }
}

void printWall(MPI_Comm comm, const Wall& w, const UnitSystem& units) {
  static constexpr const char* shapes[] = {"plane through", "cylinder around", "sphere around"};
  std::string text = format("  wall %s: %s %g,%g,%g %s", w.name.c_str(), shapes[w.shape], w.point.x,
                            w.point.y, w.point.z, units.length);
  if (w.shape != Wall::sphere)
    text += format(", axis %.4g,%.4g,%.4g", w.axis.x, w.axis.y, w.axis.z);
  if (w.shape != Wall::plane)
    text += format(", radius %g %s%s", w.radius, units.length, w.inside ? ", fibres inside" : "");
  const auto [least, most] = std::ranges::minmax(w.modulus);
  text += format(", E* %.4g", least / units.gigapascal);
  text += (most > least ? format(" to %.4g GPa", most / units.gigapascal) : " GPa");
  if (w.friction) text += format(", friction %g", w.friction.mu);
  if (w.driven())
    text += format(", driven by %g,%g,%g %s", w.force.x, w.force.y, w.force.z, units.force);
  else if (norm(w.velocity) > 0 || w.spin != 0)
    text += ", moves";
  PetscPrintf(comm, "%s\n", text.c_str());
}

void printThermostat(const RunPlan& plan, bool rubs) {
  const Thermostat& t = *plan.settings.thermostat;
  const std::string text =
      format("  temperature %g K by Langevin's equation, damping %g 1/%s%s, seed %llu\n", t.kelvin,
             t.damping, plan.units.time, t.drawsStart ? ", velocities drawn at the start" : "",
             static_cast<unsigned long long>(t.seed));
  PetscPrintf(plan.comm, "%s", text.c_str());
  if (t.kelvin > 0 &&
      (plan.settings.damping > 0 || plan.settings.viscous || plan.kinds.viscous() || rubs))
    PetscPrintf(plan.comm,
                "  warning: other damping takes heat out beside the thermostat, so that the fibres "
                "stay colder than %g K\n",
                t.kelvin);
}

/// Share of the stable step beyond which local damping holds back slow motion, and the least
/// damping that does: model.md, section 6.
constexpr double loose = 0.7, slight = 0.1;

bool sticks(const RunParts& parts, double stable) {
  return parts.plan->settings.damping > slight && parts.stepper->dt() > loose * stable;
}

/// One warning if the run's step is too near to the step `stable`.
void warnOfSticking(const RunParts& parts, double stable, const char* indent) {
  if (!sticks(parts, stable)) return;
  PetscPrintf(parts.plan->comm,
              "%swarning: -ts_dt %g is %.2f of the stable step; beyond %g of it slow motion "
              "sticks with -damping_local %g, and comes to rest several times later\n",
              indent, parts.stepper->dt(), parts.stepper->dt() / stable, loose,
              parts.plan->settings.damping);
}

void printStep(const RunParts& parts) {
  const RunPlan& plan = *parts.plan;
  const Stepper& stepper = *parts.stepper;
  const char* time = plan.units.time;
  const double bundle = bundleStepLimit(plan.kinds, parts.forces->pairs());
  if (parts.limits.present > 0) {
    PetscPrintf(plan.comm, "  time step %.4g %s; stable below %.4g now, %.4g for a free chain%s\n",
                stepper.dt(), time, parts.limits.present, chainStepLimit(plan.kinds),
                parts.forces->pairs()
                    ? format(", about %.4g for fibres pressed together", bundle).c_str()
                    : "");
    if (stepper.longest() > bundle)
      PetscPrintf(plan.comm,
                  "  warning: -ts_dt %g may become unstable once fibres are pressed together\n",
                  stepper.longest());
    if (stepper.dt() > parts.limits.present && !plan.settings.unsafeStep)
      PetscPrintf(plan.comm, "  warning: -ts_dt %g is beyond the stable step of this state\n",
                  stepper.dt());
    warnOfSticking(parts, parts.limits.present, "  ");
  }
  if (plan.minimises())
    PetscPrintf(plan.comm, "  relaxation by %s, step at most %.4g %s; time is no physical time\n",
                plan.settings.stepper->title.c_str(), stepper.longest(), time);
}

void printRestart(const RunParts& parts, const Moment& start) {
  const RunPlan& plan = *parts.plan;
  const RunRecord& old = plan.checkpoint->run;
  PetscPrintf(plan.comm, "  restart from %s at step %lld\n", plan.restart.c_str(),
              static_cast<long long>(start.step()));
  if (const std::string version = provenanceOf(old).version; version != plan.provenance.version)
    PetscPrintf(plan.comm, "  notice: nanoweft %s wrote the checkpoint, this is %s\n",
                version.c_str(), plan.provenance.version.c_str());
  if (plan.stepIsNew)
    PetscPrintf(plan.comm, "  notice: time step changed from %.10g to %.10g %s at this restart\n",
                parts.stepBefore, *plan.settings.dt, plan.units.time);
  for (const auto& observer : plan.observers)
    if (const std::string end = observer->endReached(start); !end.empty()) {
      PetscPrintf(plan.comm, "  nothing to do: the run of %s %s\n", plan.restart.c_str(),
                  end.c_str());
      return;
    }
}

}  // namespace

void printHeader(const RunParts& parts, const Moment& start) {
  const RunPlan& plan = *parts.plan;
  const UnitSystem& units = plan.units;
  const Box& box = plan.box;
  const auto& tension = plan.boundaries.tension();
  printTeam(parts);
  PetscPrintf(plan.comm, "  %lld segments, box %g x %g x %g %s, periodic %d,%d,%d\n",
              static_cast<long long>(parts.state->total()), box.length(0), box.length(1),
              box.length(2), units.length, box.periodic[0], box.periodic[1], box.periodic[2]);
  if (const Tilt& tilt = box.tilt)
    PetscPrintf(plan.comm, "  tilted: images across %c slide along %c by %g %s\n",
                "xyz"[tilt.across], "xyz"[tilt.along], tilt.way, units.length);
  if (const std::string packing = plan.scene ? plan.scene->packing(box) : ""; !packing.empty())
    PetscPrintf(plan.comm, "  %s\n", packing.c_str());
  for (const Fibre& fibre : plan.kinds) printFibre(plan.comm, fibre, units);
  printPairForces(plan.comm, parts.forces->pairs(), plan.kinds, units);
  warnOfShortDamping(plan, parts.forces->pairs());
  for (int k = 0; k < plan.kinds.count(); ++k)
    if (const auto& law = plan.breakage[k]) printBreakage(plan.comm, *law, plan.kinds[k], units);
  if (parts.state->linked) printLinks(parts);
  if (tension) printTension(*parts.state, *tension, units);
  if (plan.settings.thermostat) printThermostat(plan, parts.state->extras().friction);
  for (const Wall& wall : plan.walls) {
    printWall(plan.comm, wall, units);
    warnOfCoarseWall(plan.comm, wall, plan.kinds, units);
  }
  if (plan.boxDrive) PetscPrintf(plan.comm, "  box: %s\n", plan.boxDrive.text().c_str());
  printStep(parts);
  if (plan.boundaries.tensionGoesOn())
    PetscPrintf(
        plan.comm,
        "  tension goes on from strain %.5g of an earlier stage: gage %.5g %s, width %.5g %s\n",
        tension->before, tension->gage, units.length, tension->width, units.length);
  for (const std::string& warning : parts.warnings)
    PetscPrintf(plan.comm, "  warning: %s\n", warning.c_str());
  if (plan.checkpoint) printRestart(parts, start);
}

Clock::Clock(const Moment& start)
    : wall(MPI_Wtime()),
      time(start.state().time),
      step(start.step()),
      resolved(start.system.forces.pairsResolved()) {}

namespace {

void printEnd(const RunParts& parts, const Moment& end) {
  const RunPlan& plan = *parts.plan;
  const UnitSystem& units = plan.units;
  const Energies& e = *end.energies;
  for (const auto& observer : plan.observers)
    if (const std::string reason = observer->reason(); !reason.empty())
      PetscPrintf(plan.comm, "%s\n", reason.c_str());
  if (plan.minimises() || plan.settings.relaxForce > 0)
    PetscPrintf(plan.comm, "largest force that nothing balances: %.4g %s\n",
                largestResidual(end.state(), end.system.forces, plan.boundaries), units.force);
  const std::string walls = plan.walls.empty() ? "" : format(", walls %.10g", e.walls);
  PetscPrintf(plan.comm,
              "energies (%s): stretch %.10g, shear %.10g, bending %.10g, torsion %.10g, pair "
              "%.10g%s, kinetic %.6g, rotational %.6g\n",
              units.energy, e.stretch, e.shear, e.bending, e.torsion, e.pair, walls.c_str(),
              e.kinetic, e.rotational);
}

void printSpeed(const RunParts& parts, const Moment& end, const Clock& clock, double team) {
  const MPI_Comm comm = parts.plan->comm;
  const UnitSystem& units = parts.plan->units;
  const double wall = MPI_Wtime() - clock.wall, time = end.state().time - clock.time;
  const auto steps = static_cast<double>(end.step() - clock.step);
  std::int64_t resolved = end.system.forces.pairsResolved() - clock.resolved;
  MPI_Allreduce(MPI_IN_PLACE, &resolved, 1, MPI_INT64_T, MPI_SUM, comm);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  long memory = usage.ru_maxrss;
  MPI_Allreduce(MPI_IN_PLACE, &memory, 1, MPI_LONG, MPI_SUM, comm);
  PetscPrintf(comm, "steps %.0f, simulated time %.6g %s, wall time %s\n", steps, time, units.time,
              roundedDuration(wall).c_str());
  PetscPrintf(comm,
              "speed: %.4g segment-steps/s, %.4g pairs/s, %.4g ns/day; %lld list rebuilds, "
              "imbalance %.3f, peak memory %.0f MB\n",
              steps * static_cast<double>(end.state().total()) / wall,
              static_cast<double>(resolved) / wall,
              time * units.secondsPerTime * 1e9 / wall * 86400.0,
              static_cast<long long>(parts.forces->lists().rebuilds()), parts.domain->imbalance(),
              static_cast<double>(memory) / 1024.0);
  const int threads = parts.team.given;
  if (team < 0.95 * threads)
    PetscPrintf(comm, "threads: %.3g of %d worked on average, since %s\n", team, threads,
                threads > omp_get_num_procs()
                    ? "there are fewer cores"
                    : "their cores were taken (-threads all would wait for them)");
  if (end.state().ranks() == 1) return;
  const Domain::Census census = parts.domain->census(*parts.state);
  PetscPrintf(comm,
              "partition: %s, imbalance of work %.3f, %.4g ghosts a segment, %lld bonds cut\n",
              parts.domain->partition(), parts.domain->imbalance(),
              static_cast<double>(census.ghosts) / static_cast<double>(end.state().total()),
              static_cast<long long>(census.cutBonds));
}

/// Do bonds, contacts, walls or a bath fill the account `damped`, too? Then nobody knows the share
/// of -damping_local and -damping_viscous.
bool othersDamp(const RunPlan& plan, const PairForces& pairs) {
  return plan.kinds.yields() || plan.kinds.viscous() || plan.settings.thermostat || pairs.damps() ||
         std::ranges::any_of(plan.walls, [](const Wall& w) { return w.friction.restitution < 1; });
}

void printDampingShare(const RunParts& parts, const Energies& e) {
  const RunPlan& plan = *parts.plan;
  const double damping = plan.settings.damping;
  const bool local = damping > 0;
  if ((!local && !plan.settings.viscous) || othersDamp(plan, parts.forces->pairs())) return;
  // Beyond that it has taken what the start brought along, such as the strain of a weave's crimp.
  if (!(e.external > 0) || e.damped > e.external) return;
  const double share = e.damped / e.external;
  PetscPrintf(plan.comm, "damping took %.3g %% of the work of %s%s\n", 100 * share,
              plan.walls.empty() ? "grips and loads" : "grips, loads and walls",
              plan.boxDrive ? " and of what drives the box" : "");
  const bool moved =
      plan.boundaries.tension() ||
      std::ranges::any_of(plan.boundaries.list(), [](const Boundary& b) { return b.moves(); });
  if (local && moved && share > noticedDampingShare && e.broken > 0)
    PetscPrintf(plan.comm,
                "  remark: part of that share is the recoil of what broke; forces measured at what "
                "is moved contain what -damping_local %g had taken before\n",
                damping);
  else if (local && moved && share > noticedDampingShare)
    PetscPrintf(
        plan.comm,
        "  remark: -damping_local %g weakens every force that moves a segment, however slow "
        "the motion; forces measured at what is moved contain that share, so measure them "
        "with a smaller one\n",
        damping);
}

/// A minimiser's path is no motion, and a thermostat turns over more than what there was.
void remarkOnDrift(const RunParts& parts, const Moment& end, std::int64_t steps) {
  if (parts.plan->minimises()) return;
  const Energies &e = *end.energies, &first = end.first;
  const double drift = std::abs(e.balance() - first.balance());
  // What each step adds to an account is rounded to the grid of exact sums.
  const double grid = SumUnit(parts.plan->kinds.energyScale()).grid(),
               lost = 0.5 * grid * static_cast<double>(parts.state->total() * steps);
  // A run that came to rest has little left of what it began with.
  auto ownOf = [](const Energies& of) { return of.elastic() + of.kinetic + of.rotational; };
  if (const double own = std::max(ownOf(e), ownOf(first)) + std::abs(e.external - first.external);
      drift > noticedDrift * own && drift <= lost) {
    PetscPrintf(
        parts.plan->comm,
        "  warning: that is %.2g %% of the energy that there was: external, damped and heat "
        "lose what a step adds for a segment below %.2g %s (1e-22 of B1 T^2); motion and "
        "energies are right\n",
        100.0 * drift / own, 0.5 * grid, parts.plan->units.energy);
    return;
  }
  if (parts.plan->settings.thermostat) return;
  const double there = first.elastic() + first.kinetic + first.rotational +
                       std::abs(e.external - first.external) + std::abs(e.pair - first.pair);
  if (drift >
      std::max(noticedDrift * there, roundOff(parts.plan->kinds, parts.state->total(), first.pair)))
    PetscPrintf(parts.plan->comm,
                "  warning: that is %.2g %% of the energy that there was to turn into motion; %s\n",
                100.0 * drift / there, remedyOfDrift(parts.plan->boxDrive).c_str());
}

}  // namespace

void printSummary(const RunParts& parts, const Moment& end, const Clock& clock, double team) {
  const RunPlan& plan = *parts.plan;
  const Energies& e = *end.energies;
  printEnd(parts, end);
  if (end.step() == clock.step) return;
  const bool relaxes = plan.settings.relaxTolerance > 0 || plan.settings.relaxForce > 0;
  if (relaxes &&
      std::ranges::all_of(plan.observers, [](const auto& o) { return o->reason().empty(); }))
    PetscPrintf(plan.comm, "not converged: the run was over before\n");
  printSpeed(parts, end, clock, team);
  const bool heated = plan.settings.thermostat.has_value(), rubs = end.state().extras().friction;
  const std::string others = (rubs ? format(", friction %.6g", e.friction) : "") +
                             (heated ? format(", heat %.6g", e.heat) : "");
  PetscPrintf(plan.comm,
              "energy balance: total + damped + broken%s - external%s drifted by %.3g %s (damped "
              "%.6g, external %.6g, broken %.6g%s)\n",
              rubs ? " + friction" : "", heated ? " - heat" : "", e.balance() - end.first.balance(),
              plan.units.energy, e.damped, e.external, e.broken, others.c_str());
  remarkOnDrift(parts, end, end.step() - clock.step);
  printDampingShare(parts, e);
  if (parts.limits.lowest < parts.limits.first) {
    PetscPrintf(plan.comm, "stable step: %.4g %s at the start, %.4g at the lowest\n",
                parts.limits.first, plan.units.time, parts.limits.lowest);
    // The header has warned of the first one; steps that adapt keep their share of each.
    if (!parts.stepper->adapts() && !sticks(parts, parts.limits.first))
      warnOfSticking(parts, parts.limits.lowest, "");
  }
  for (const auto& observer : plan.observers) observer->summarise(end);
}

}  // namespace nanoweft
