#include "nanoweft/app/run_plan.hpp"

#include <strings.h>

#include <algorithm>

#include "nanoweft/app/provenance.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/locked_file.hpp"
#include "nanoweft/base/simd.hpp"
#include "nanoweft/motion/breakage.hpp"

namespace nanoweft {

namespace {

std::optional<StateHeader> readCheckpoint(MPI_Comm comm, const std::string& file,
                                          Options& options) {
  if (options.helpWanted() || file.empty()) return std::nullopt;
  return openCheckpoint(comm, file, options);
}

}  // namespace

// The order of the members is that in which options must be read: each may need those before.
RunPlan::RunPlan(MPI_Comm communicator, Options& options)
    : comm(communicator),
      restart(readRestart(options)),
      checkpoint(readCheckpoint(comm, restart, options)),
      units(readUnits(options)),
      kinds(readKinds(options, units)),
      pairs(readPairForces(options, units, kinds)),
      settings(readRunSettings(options, units, static_cast<bool>(pairs))),
      breakage(readBreakageOf(kinds, options, units, settings.seed)),
      scene(readScene(
          options,
          {units, kinds, comm, [this](int a, int b) { return restDistance(a, b); }, settings.seed},
          options.helpWanted() || checkpoint)),
      links(readLinkLaws(options, units, kinds, linked() || options.helpWanted())),
      walls(readWalls(options, units, kinds)),
      boundaries(options, units, kinds, restDistance(0, 0)),
      boxDrive(options, units),
      observers(
          makeObservers(options, {settings, units, boundaries, kinds, pairs, walls, boxDrive})) {
  readBox(options);
  options.refuseUnknown();
  if (options.helpWanted()) return;
  requireSameInstructions(comm, simdName);
  refuseContradictions();
  provenance = readProvenance(comm, options, startHeader(), checkpoint.has_value());
  stepIsNew = seeNewStep(options);
  requireDistinctOutputs();
  for (const auto& observer : observers) observer->check(outputContext(false));
}

bool RunPlan::linked() const {
  const StateHeader* header = checkpoint ? &*checkpoint : scene ? scene->header() : nullptr;
  return header && header->parts.contains("link");
}

double RunPlan::restDistance(int a, int b) const {
  const auto rest = pairs.restDistance(a, b);
  return rest ? *rest : usualRestDistance(kinds[a], kinds[b], units);
}

void RunPlan::readBox(Options& options) {
  if (checkpoint) box = checkpoint->box;
  if (scene) box = scene->box();
  Box given = box;
  if (options.helpWanted()) given.upper = {1, 1, 1};
  readDomain(options, units, given);
  // A restart keeps the box of its checkpoint.
  if (!checkpoint) box = given;
}

void RunPlan::refuseSharedNames() const {
  for (const LinkLaw& law : links) {
    auto differ = [&](const std::string& other, const char* option) {
      // PETSc tells no capital from a small letter in the names of options.
      if (law.kind.empty() || strcasecmp(law.kind.c_str(), other.c_str()) != 0) return;
      throw InputError("-link_kinds: '" + law.kind + "' is among " + option +
                       ", too; options of both would begin with -" + law.kind +
                       "_, so give one another name");
    };
    for (const Fibre& f : kinds) differ(f.kind, "-kinds");
    for (const Boundary& b : boundaries.list()) differ(b.name, "-bc");
    for (const Wall& w : walls) differ(w.name, "-walls");
  }
  for (const Wall& w : walls)
    if (std::ranges::any_of(boundaries.list(), [&](const Boundary& b) {
          return strcasecmp(b.name.c_str(), w.name.c_str()) == 0;
        }))
      throw InputError("-walls " + w.name +
                       ": a group of -bc has that name, and both have options -" + w.name + "_...");
}

void RunPlan::refuseForMinimiser() const {
  const std::string method = "-relax_method " + settings.stepper->name;
  if (boundaries.tension())
    throw InputError(method + ": a tension test moves the grips; relax first, then pull");
  for (const Boundary& b : boundaries.list())
    if (b.moves())
      throw InputError(method + ": -" + b.name + (b.spin ? "_spin" : "_velocity") +
                       " keeps the fibres moving, so there is no rest");
  for (const Wall& w : walls)
    if (norm(w.velocity) > 0 || w.spin != 0 || w.driven() || w.friction)
      throw InputError(method + ": the wall " + w.name + " must stand still, without friction");
  if (boxDrive) throw InputError(method + ": the box must be held, without -deform_x, _y, _z");
  if (kinds.viscous())
    throw InputError(method + ": it has no viscosity; leave out -fibre_retardation");
  if (pairs.rubs())
    throw InputError(method +
                     ": it has no friction; leave out -contact_friction and "
                     "-contact_restitution, or relax without it");
}

void RunPlan::refuseBesideShear() const {
  const char* pair = boxDrive.shears();
  if (!pair && !box.tilt) return;
  const std::string what = pair ? std::string("-deform_") + pair : "a tilted box";
  if (!walls.empty()) throw InputError(what + ": not together with -walls, which do not slide");
  if (boundaries.tension())
    throw InputError(what + ": not together with a tension test, which has grips");
}

void RunPlan::refuseWithoutRest() const {
  const bool force = settings.relaxForce > 0;
  if (!force && settings.relaxTolerance == 0) return;
  const std::string end = force ? "-relax_force: ends a run where no force is left; "
                                : "-relax_tolerance: ends a run at rest; ";
  if (boundaries.tension()) throw InputError(end + "a tension test goes on moving its grips");
  for (const Boundary& b : boundaries.list())
    if (b.moves())
      throw InputError(end + "-" + b.name + (b.spin ? "_spin" : "_velocity") + " keeps it moving");
  if (!force) return;
  for (const Wall& w : walls)
    if ((w.moves() && w.stop == 0) || w.driven())
      throw InputError(end + "the wall " + w.name + " moves");
  if (boxDrive) throw InputError(end + "it does not look at the stress of a box that is driven");
}

void RunPlan::refuseWallsAcross() const {
  for (const Wall& w : walls)
    for (int d = 0; d < 3; ++d) {
      if (!box.periodic[d]) continue;
      const double along[3] = {w.axis.x, w.axis.y, w.axis.z};
      const double part = std::abs(along[d]);
      const std::string name = "-walls " + w.name + ": ",
                        where = format("periodic along %c", "xyz"[d]);
      if (w.shape == Wall::plane && part > 1e-9)
        throw InputError(name + "the box is " + where + ", so a plane across it is no wall");
      if (w.shape == Wall::cylinder && part > 1e-9 && part < 1 - 1e-9)
        throw InputError(name + "the box is " + where +
                         ", which the cylinder's axis must follow or be across");
      if (w.shape != Wall::plane && !(w.shape == Wall::cylinder && part > 0.5) && w.inside &&
          w.radius > 0.5 * box.length(d))
        throw InputError(
            name + format("-%s_radius %g: the box is %s, where it is %g %s long; at most "
                          "half of that",
                          w.name.c_str(), w.radius, where.c_str(), box.length(d), units.length));
    }
}

void RunPlan::refuseContradictions() const {
  refuseSharedNames();
  if (!settings.maxSteps && !settings.maxTime && settings.relaxTolerance == 0 &&
      settings.relaxForce == 0 && !boundaries.tension())
    throw InputError(
        "the run has no end: give -ts_max_steps, -ts_max_time, -relax_tolerance, -relax_force or "
        "-tension_rate or -tension_program");
  if (boxDrive && boundaries.tension())
    throw InputError("-deform_x, _y, _z: not together with a tension test, which has grips");
  refuseBesideShear();
  if (minimises()) refuseForMinimiser();
  for (const Wall& w : walls)
    if (settings.relaxTolerance > 0 && w.travels() && !checkpoint)
      throw InputError("-relax_tolerance: there is no rest to end at, since the wall " + w.name +
                       " moves for ever (-" + w.name + "_stop)");
  if (const char* axis = boxDrive.endless(); axis && settings.relaxTolerance > 0 && !checkpoint)
    throw InputError(format(
        "-relax_tolerance: there is no rest to end at, since -deform_%s_rate strains the box for "
        "ever (-deform_%s_until)",
        axis, axis));
  refuseWithoutRest();
  // A restart has the box of its checkpoint, whatever is thought of it now.
  if (!checkpoint) refuseWallsAcross();
  if (settings.thermostat && settings.thermostat->kelvin > 0 &&
      (settings.relaxTolerance > 0 || settings.relaxForce > 0))
    throw InputError(
        format("-temperature %g: there is no rest to end at; leave out -relax_tolerance and "
               "-relax_force, or cool with -temperature 0",
               settings.thermostat->kelvin));
  for (const PairForces::Class& c : pairs.classes())
    if (!c.mixed() && breakage[c.first] && c.force->exclude() > mostExcludeWithBreakage) {
      const std::string& kind = kinds[c.first].kind;
      throw InputError(
          format("-%spair_exclude %d: at most %d with breakage (by default 20 diameters over the "
                 "segment length)",
                 kind.empty() ? "" : (kind + "_" + kind + "_").c_str(), c.force->exclude(),
                 mostExcludeWithBreakage));
    }
}

bool RunPlan::seeNewStep(const Options& options) const {
  if (!checkpoint || !options.readings().at("ts_dt").byUser) return false;
  const RunRecord& old = checkpoint->run;
  // A minimiser's longest step may have been shortened since it was given.
  return minimises() ? provenance.options != old.texts.at(optionsText)
                     : old.needReals("time_step", 1)[0] != *settings.dt;
}

OutputContext RunPlan::outputContext(bool over) const {
  OutputContext context;
  context.comm = comm;
  context.rule.run = provenance;
  context.open = box.periodic == std::array{false, false, false};
  context.rule.overwrite = settings.overwrite;
  context.rule.restart = restart;
  if (checkpoint) context.rule.checkpoint = provenanceOf(checkpoint->run);
  if (scene && !scene->file().empty()) context.rule.inputs = {scene->file()};
  context.restart = checkpoint.has_value();
  context.step = startHeader() ? startHeader()->step : 0;
  context.over = over;
  return context;
}

void RunPlan::requireDistinctOutputs() const {
  std::vector<Observer::Output> all;
  for (const auto& observer : observers)
    for (const Observer::Output& output : observer->outputs())
      if (!output.name.empty()) all.push_back(output);
  std::string problem;
  if (int rank; MPI_Comm_rank(comm, &rank) == MPI_SUCCESS && rank == 0)
    for (const Observer::Output& one : all)
      for (const Observer::Output& other : all) {
        if (&one == &other || one.makes) continue;
        if (other.makes ? other.makes(other.name, one.name) : false)
          problem = format("-%s %s is a file that -%s %s makes", one.option, one.name.c_str(),
                           other.option, other.name.c_str());
        else if (&other > &one && !other.makes && isSameFile(one.name, other.name))
          problem = format("-%s %s and -%s %s are the same file", one.option, one.name.c_str(),
                           other.option, other.name.c_str());
      }
  agree<InputError>(comm, problem);
}

}  // namespace nanoweft
