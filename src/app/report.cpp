/// What a run prints: header, progress, summary.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "nanoweft/app/simulation.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/force/quadrature.hpp"
#include "nanoweft/motion/residual.hpp"
#include "nanoweft/motion/step_limit.hpp"

namespace nanoweft {

namespace {

/// Of the work of grips and loads.
constexpr double noticedDampingShare = 0.05;

std::string duration(double seconds) {
  const long s = std::lround(seconds);
  if (s < 100) return format("%ld s", s);
  if (s < 6000) return format("%ld min %02ld s", s / 60, s % 60);
  return format("%ld h %02ld min", s / 3600, s / 60 % 60);
}

}  // namespace

void Simulation::printFibre() const {
  const Fibre& f = fibre_;
  const BondParameters& b = f.bond;
  const std::string wall = f.wall > 0 ? format("wall %g %s", f.wall, units_.length) : "solid";
  // By format(): PetscPrintf would put a point behind whole numbers.
  const std::string fibre = format(
      "  fibre: from %s, radius %g %s, %s, E %g GPa, G %g GPa, density %.5g kg/m^3, %.5g %s a "
      "length "
      "of 1 %s\n",
      f.preset.c_str(), f.radius, units_.length, wall.c_str(), f.young / units_.gigapascal,
      f.shear / units_.gigapascal, f.density() / units_.kilogramPerCubicMetre,
      f.mass / units_.mass / f.length, units_.massName, units_.length);
  PetscPrintf(comm_, "%s", fibre.c_str());
  PetscPrintf(comm_,
              "  segment: length %g %s, mass %.5g %s, inertia %.5g %s %s^2; bond: B1 %.5g, B2 "
              "%.5g, B3 %.5g, B4 %.5g\n",
              f.length, units_.length, f.mass / units_.mass, units_.massName,
              f.inertia / units_.mass, units_.massName, units_.length, b.stretch, b.shear,
              b.bending, b.torsion);
}

void Simulation::printPairForces() const {
  const PairForce* p = forces_->pair();
  if (!p) {
    PetscPrintf(comm_, "  pair forces: none\n");
    return;
  }
  const PointChoice& points = p->points();
  const std::string far = points.far < points.near
                              ? format(", %d beyond %g to %g %s", points.far, points.blend.from,
                                       points.blend.to, units_.length)
                              : "";
  PetscPrintf(comm_, "  pair forces: %s\n", p->description().c_str());
  PetscPrintf(comm_,
              "    %d points a segment%s, expected force error %.2g %% (bundle); within a fibre "
              "from %d segments (%.5g %s) on\n",
              points.near, far.c_str(), 100 * expectedForceError(*p, fibre_), p->exclude(),
              p->exclude() * fibre_.length, units_.length);
  for (const std::string& warning : pointWarnings(*p, fibre_, units_))
    PetscPrintf(comm_, "  warning: %s\n", warning.c_str());
}

void Simulation::printBreakage() const {
  const BreakageLaw& law = *breakage_;
  const std::string strain = law.weibull
                                 ? format("by Weibull's law, shape %g, %g for %g %s", law.shape,
                                          law.strain0, law.length0, units_.length)
                                 : format("of %g +- %g for %g %s", law.mean, law.deviation,
                                          fibre_.diameter(), units_.length);
  const std::string along = law.perFibre && law.scatter > 0
                                ? format(" with a scatter of %g of it along the fibre", law.scatter)
                                : "";
  PetscPrintf(comm_, "  bonds break at a strain %s, one draw per %s%s, seed %llu\n", strain.c_str(),
              law.perFibre ? "fibre" : "bond", along.c_str(),
              static_cast<unsigned long long>(law.seed));
}

void Simulation::printHeader() const {
  PetscPrintf(comm_, "nanoweft %s: %d rank%s x %d thread%s\n", NANOWEFT_VERSION, state_->ranks(),
              state_->ranks() > 1 ? "s" : "", threads_, threads_ > 1 ? "s" : "");
  if (threads_ < threadsAsked_)
    PetscPrintf(comm_, "  %d threads asked, the runtime gives %d\n", threadsAsked_, threads_);
  PetscPrintf(comm_, "  %lld segments, box %g x %g x %g %s, periodic %d,%d,%d\n",
              static_cast<long long>(state_->total()), box_.length(0), box_.length(1),
              box_.length(2), units_.length, box_.periodic[0], box_.periodic[1], box_.periodic[2]);
  printFibre();
  printPairForces();
  if (breakage_) printBreakage();
  if (const auto& t = boundaries_.tension())
    PetscPrintf(
        comm_, "  tension along %c: gage %.5g %s, width %.5g %s, thickness %.4g %s, rate %g 1/%s\n",
        "xyz"[t->axis], t -> gage, units_.length, t->width, units_.length, t->thickness,
        units_.length, t->rate, units_.time);
  const double bundle = bundleStepLimit(fibre_, forces_->pair());
  if (presentLimit_ > 0)
    PetscPrintf(comm_,
                "  time step %.4g %s; stable below %.4g now, %.4g for a free chain, about %.4g for "
                "fibres pressed together\n",
                verlet_->dt(), units_.time, presentLimit_, chainStepLimit(fibre_), bundle);
  if (presentLimit_ > 0 && (fire_ ? fire_->longest() : verlet_->dt()) > bundle)
    PetscPrintf(comm_,
                "  warning: -ts_dt %g may become unstable once fibres are pressed together\n",
                fire_ ? fire_->longest() : verlet_->dt());
  if (fire_)
    PetscPrintf(comm_, "  relaxation by FIRE, step at most %.4g %s; time is no physical time\n",
                fire_->longest(), units_.time);
  if (boundaries_.tensionGoesOn())
    PetscPrintf(
        comm_,
        "  tension goes on from strain %.5g of an earlier stage: gage %.5g %s, width %.5g %s\n",
        boundaries_.tension()->before, boundaries_.tension()->gage, units_.length,
        boundaries_.tension()->width, units_.length);
  for (const std::string& warning : startWarnings_)
    PetscPrintf(comm_, "  warning: %s\n", warning.c_str());
  if (restartHeader_) printRestart();
}

void Simulation::printRestart() const {
  const RunRecord& old = restartHeader_->run;
  PetscPrintf(comm_, "  restart from %s at step %lld\n", restart_.c_str(),
              static_cast<long long>(state_->step));
  if (const std::string version = provenanceOf(old).version; version != provenance_.version)
    PetscPrintf(comm_, "  notice: nanoweft %s wrote the checkpoint, this is %s\n", version.c_str(),
                provenance_.version.c_str());
  if (stepIsNew_)
    PetscPrintf(comm_, "  notice: time step changed from %.10g to %.10g %s at this restart\n",
                fire_ ? old.needReals("fire", 3)[1] : old.needReals("time_step", 1)[0],
                *settings_.dt, units_.time);
  if (const std::string end = endReached(); !end.empty())
    PetscPrintf(comm_, "  nothing to do: %s\n", end.c_str());
}

std::string Simulation::endReached() const {
  const std::string run = "the run of " + restart_;
  const auto step = static_cast<long long>(state_->step);
  const auto& t = boundaries_.tension();
  if (converged_ || balanced_) return format("%s had converged at step %lld", run.c_str(), step);
  if (t && strain() >= t->maxStrain)
    return format("%s had reached a strain of %.4g at step %lld", run.c_str(), strain(), step);
  return atEnd() ? "the checkpoint is at or beyond the end that the options set" : "";
}

void Simulation::printProgress() {
  const double now = MPI_Wtime();
  const Energies& e = *energies_;
  const double perStep = (now - progressWall_) / static_cast<double>(std::max<std::int64_t>(
                                                     1, state_->step - progressStep_));
  const double perDay = 86400.0 / perStep * verlet_->dt() * units_.secondsPerTime * 1e9;
  // Steps left by whichever end can be foreseen.
  double left = std::numeric_limits<double>::infinity();
  if (settings_.maxSteps) left = static_cast<double>(*settings_.maxSteps - state_->step);
  if (settings_.maxTime) left = std::min(left, (*settings_.maxTime - state_->time) / verlet_->dt());
  if (const auto& t = boundaries_.tension())
    left = std::min(left, (t->maxStrain - t->strain(state_->time)) / (t->rate * verlet_->dt()));
  std::string line = format("step %lld  time %.5g %s  elastic %.6g  pair %.6g  kinetic %.4g %s",
                            static_cast<long long>(state_->step), state_->time, units_.time,
                            e.elastic(), e.pair, e.kinetic + e.rotational, units_.energy);
  if (boundaries_.tension())
    line += format("  strain %.1f %%  broken %lld", 100 * strain(),
                   static_cast<long long>(e.brokenBonds));
  line += format("  %.3g ns/day", perDay);
  if (std::isfinite(left))
    line += format("  %s %s", settings_.relaxTolerance > 0 ? "at most" : "left",
                   duration(left * perStep).c_str());
  PetscPrintf(comm_, "%s\n", line.c_str());
  lastProgress_ = progressWall_ = now;
  progressStep_ = state_->step;
}

void Simulation::printSummary() const {
  const double wall = MPI_Wtime() - wallStart_;
  const auto steps = static_cast<double>(state_->step - firstStep_);
  const Energies& e = *energies_;
  if (converged_)
    PetscPrintf(comm_,
                "converged: the elastic energy changed by less than %g of itself in %ld steps\n",
                settings_.relaxTolerance, settings_.relaxInterval);
  if (balanced_)
    PetscPrintf(comm_, "converged: no force that nothing balances exceeds %g %s\n",
                settings_.relaxForce, units_.force);
  if (fire_ || settings_.relaxForce > 0)
    PetscPrintf(comm_, "largest force that nothing balances: %.4g %s\n",
                largestResidual(*state_, *forces_, boundaries_), units_.force);
  PetscPrintf(comm_,
              "energies (%s): stretch %.10g, shear %.10g, bending %.10g, torsion %.10g, pair "
              "%.10g, kinetic %.6g, rotational %.6g\n",
              units_.energy, e.stretch, e.shear, e.bending, e.torsion, e.pair, e.kinetic,
              e.rotational);
  if (steps == 0) return;
  std::int64_t resolved = forces_->pairsResolved() - firstResolved_;
  MPI_Allreduce(MPI_IN_PLACE, &resolved, 1, MPI_INT64_T, MPI_SUM, comm_);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  long memory = usage.ru_maxrss;
  MPI_Allreduce(MPI_IN_PLACE, &memory, 1, MPI_LONG, MPI_SUM, comm_);
  PetscPrintf(comm_, "steps %.0f, simulated time %.6g %s, wall time %s\n", steps,
              state_->time - firstTime_, units_.time, duration(wall).c_str());
  PetscPrintf(comm_,
              "speed: %.4g segment-steps/s, %.4g pairs/s, %.4g ns/day; %lld list rebuilds, "
              "imbalance %.3f, peak memory %.0f MB\n",
              steps * static_cast<double>(state_->total()) / wall,
              static_cast<double>(resolved) / wall,
              (state_->time - firstTime_) * units_.secondsPerTime * 1e9 / wall * 86400.0,
              static_cast<long long>(forces_->lists().rebuilds()), domain_->imbalance(),
              static_cast<double>(memory) / 1024.0);
  if (state_->ranks() > 1) {
    const Domain::Census census = domain_->census(*state_);
    PetscPrintf(comm_,
                "partition: %s, imbalance of work %.3f, %.4g ghosts a segment, %lld bonds cut\n",
                domain_->partition(), domain_->imbalance(),
                static_cast<double>(census.ghosts) / static_cast<double>(state_->total()),
                static_cast<long long>(census.cutBonds));
  }
  PetscPrintf(comm_,
              "energy balance: total + damped + broken - external drifted by %.3g %s (damped %.6g, "
              "external %.6g, broken %.6g)\n",
              e.balance() - first_.balance(), units_.energy, e.damped, e.external, e.broken);
  printDampingShare();
  if (lowestLimit_ < firstLimit_)
    PetscPrintf(comm_, "stable step: %.4g %s at the start, %.4g at the lowest\n", firstLimit_,
                units_.time, lowestLimit_);
  if (boundaries_.tension())
    PetscPrintf(comm_, "strain %.2f %%, strength %.4g GPa, broken bonds %lld\n", 100 * strain(),
                std::max(strength_, lastStress_), static_cast<long long>(e.brokenBonds));
  // Round-off of balanced forces is far below this; stray fibres in the grips feel nothing else.
  if (boundaries_.tension() && std::max(strength_, lastStress_) < 1e-9)
    PetscPrintf(
        comm_,
        "warning: the grips have felt no force: nothing joins them (-tension_ends says where "
        "the piece ends when stray fibres lie beyond)\n");
}

void Simulation::printDampingShare() const {
  const double damped = energies_->damped, work = energies_->external;
  const bool local = settings_.damping > 0;
  if ((!local && !settings_.viscous) || !(work > 0)) return;
  const double share = damped / work;
  PetscPrintf(comm_, "damping took %.3g %% of the work of grips and loads\n", 100 * share);
  const bool moved = boundaries_.tension() ||
                     std::ranges::any_of(boundaries_.list(),
                                         [](const Boundary& b) { return norm(b.velocity) > 0; });
  if (local && moved && share > noticedDampingShare)
    PetscPrintf(
        comm_,
        "  remark: -damping_local %g weakens every force that moves a segment, however slow "
        "the motion; forces measured at what is moved contain that share, so measure them "
        "with a smaller one\n",
        settings_.damping);
}

}  // namespace nanoweft
