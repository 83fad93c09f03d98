/// The stable time step: chosen at the start, followed during the run, and what happens beyond it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/app/simulation.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/force/overlap.hpp"
#include "nanoweft/motion/step_limit.hpp"

namespace nanoweft {

namespace {

/// FIRE's longest step over the stable step.
constexpr double fireMargin = 0.9;

}  // namespace

double Simulation::defaultStep() {
  const double stable = evaluatesOnly() ? chainStepLimit(fibre_) : presentLimit_;
  // While FIRE runs, fibres that were apart may be pressed together.
  if (settings_.fire)
    return fireMargin * std::min(stable, bundleStepLimit(fibre_, forces_->pair()));
  if (fibre_.step > 0) return fibre_.step;
  // A restart keeps the step that was chosen at the start.
  if (restartHeader_ && restartHeader_->run.reals.contains("default_step"))
    return *(defaultStep_ = restartHeader_->run.needReals("default_step", 1)[0]);
  if (!evaluatesOnly()) defaultStep_ = 0.4 * stable;
  return 0.4 * stable;
}

void Simulation::chooseStep() {
  if (!evaluatesOnly())
    firstLimit_ = lowestLimit_ = presentLimit_ =
        presentStepLimit(*state_, *forces_, domain_->halo());
  const double dt = settings_.dt ? *settings_.dt : defaultStep();
  if (!evaluatesOnly() && dt > presentLimit_ && !settings_.unsafeStep)
    throw InputError(
        format("-ts_dt %g: beyond the stable step of this state, %.4g %s; take at most half of "
               "that (or -ts_dt_unsafe)",
               dt, presentLimit_, units_.time));
  verlet_.emplace(dt, settings_.damping);
  if (!settings_.fire) return;
  fire_.emplace(fibre_, dt);
  if (restartHeader_) {
    fire_->restore(restartHeader_->run);
    if (stepIsNew_) fire_->setLongest(*settings_.dt);
  }
  verlet_.emplace(fire_->dt(), 0.0);
}

void Simulation::followLimit() {
  presentLimit_ = presentStepLimit(*state_, *forces_, domain_->halo());
  lowestLimit_ = std::min(lowestLimit_, presentLimit_);
  if (fire_ && !settings_.unsafeStep) fire_->limit(fireMargin * presentLimit_);
  if (!fire_ && verlet_->dt() > presentLimit_ && !limitWarned_) {
    PetscPrintf(comm_,
                "warning: step %lld: -ts_dt %g is beyond the stable step of the present state, "
                "%.4g %s\n",
                static_cast<long long>(state_->step), verlet_->dt(), presentLimit_, units_.time);
    limitWarned_ = true;
  }
}

void Simulation::watchContacts() {
  if (contactWarned_ || !forces_->pair()) return;
  // Walls of tubes meet at 2 rf; a tenth of a radius is more than they, or a law's points, can
  // give.
  constexpr double deepest = 0.1;
  const double radius = fibre_.radius;
  const Overlap o = deepestOverlap(*state_, *forces_, (2.0 - deepest) * radius);
  if (std::isinf(o.distance)) return;
  contactWarned_ = true;
  PetscPrintf(comm_,
              "warning: step %lld: fibre %lld segment %d and fibre %lld segment %d overlap by %.0f "
              "%% of a radius; what the pair law says is doubtful there\n",
              static_cast<long long>(state_->step), static_cast<long long>(o.fibre[0]), o.index[0],
              static_cast<long long>(o.fibre[1]), o.index[1], 100.0 * (2.0 - o.distance / radius));
}

void Simulation::watchEnergy() {
  const Energies& e = *energies_;
  if (!std::isfinite(e.total())) reportInstability("");
  if (settings_.energyAlarm == 0) return;
  // What there was to turn into motion: the start's own energy, the work done on the fibres, and
  // what they gained by coming together; at its most, since Verlet's error stays behind when the
  // motion that made it is over. The floor keeps round-off of a scene at rest silent.
  available_ = std::max(available_, first_.elastic() + first_.kinetic + first_.rotational +
                                        std::abs(e.external - first_.external) +
                                        std::abs(e.pair - first_.pair) +
                                        1e-9 * forces_->fibre().bond.stretch * fibre_.length *
                                            fibre_.length * static_cast<double>(state_->total()));
  const double risen = e.balance() - first_.balance();
  if (risen > settings_.energyAlarm * available_)
    reportInstability(
        format(" and energy has risen by %.3g %s out of nothing", risen, units_.energy));
}

void Simulation::reportInstability(const std::string& sign) {
  // The worst segment of all ranks: not a number counts as infinitely fast.
  struct {
    double distance;
    int rank;
  } worst{-1.0, state_->rank()};
  long long segment[2] = {0, 0};
  for (int i = 0; i < state_->owned(); ++i) {
    const double* v = state_->velocity + 3 * i;
    const double* w = state_->angular + 3 * i;
    const double slide = std::hypot(v[0], v[1], v[2]),
                 turn = std::hypot(w[0], w[1], w[2]) * 0.5 * fibre_.length;
    double distance = verlet_->dt() * std::max(slide, turn);
    if (!std::isfinite(slide) || !std::isfinite(turn))
      distance = std::numeric_limits<double>::infinity();
    if (distance > worst.distance) {
      worst.distance = distance;
      segment[0] = state_->fibre[i];
      segment[1] = state_->chain[2 * i];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm_);
  MPI_Bcast(segment, 2, MPI_LONG_LONG, worst.rank, comm_);
  throw RunError(
      format("unstable at step %lld: fibre %lld segment %lld moves %.3g %s in a step of %g %s%s "
             "(stable limit when last looked at: %.4g); "
             "take a smaller -ts_dt",
             static_cast<long long>(state_->step), segment[0], segment[1], worst.distance,
             units_.length, verlet_->dt(), units_.time, sign.c_str(), presentLimit_));
}

}  // namespace nanoweft
