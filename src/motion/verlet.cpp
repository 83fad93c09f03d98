#include "nanoweft/motion/verlet.hpp"

#include <omp.h>

#include <cmath>
#include <vector>

namespace nanoweft {

namespace {

/// A boundary's values at the two ends of a half kick.
struct Action {
  std::int32_t bit;
  std::array<bool, 3> fix;
  bool fixRotation;
  double velocity[3];          // at the end
  double force[3], torque[3];  // where the forces are evaluated
};

std::vector<Action> actionsAt(const Boundaries& boundaries, double forceTime, double endTime) {
  std::vector<Action> actions;
  for (const Boundary& b : boundaries.list()) {
    const double v = b.factor(endTime), f = b.factor(forceTime);
    actions.push_back({1 << b.bit,
                       b.fix,
                       b.fixRotation,
                       {v * b.velocity.x, v * b.velocity.y, v * b.velocity.z},
                       {f * b.force.x, f * b.force.y, f * b.force.z},
                       {f * b.torque.x, f * b.torque.y, f * b.torque.z}});
  }
  return actions;
}

/// |size| with the sign of x, zero for x = 0; without a branch, since signs are unpredictable.
double signedLike(double size, double x) {
  return x == 0 ? 0.0 : std::copysign(size, x);
}

/// Half kicks of a run of segments.
class Kicker {
 public:
  Kicker(State& state, const ForceField& forces, const Boundaries& boundaries,
         const std::vector<Action>& actions, double damping, double h)
      : s_(state),
        actions_(actions),
        mask_(boundaries.mask()),
        damping_(damping),
        h_(h),
        perMass_(h / forces.fibre().mass),
        perInertia_(h / forces.fibre().inertia),
        mass_(forces.fibre().mass),
        inertia_(forces.fibre().inertia),
        unit_(forces.energyUnit()) {}

  void operator()(int i) {
    const auto k = static_cast<std::size_t>(3 * i);
    if (s_.group[i] & mask_) {
      bounded(i);
    } else if (damping_ > 0 || s_.viscous) {
      double damped = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double fv = s_.viscous ? s_.viscous[6 * i + static_cast<int>(c)] : 0.0;
        const double tv = s_.viscous ? s_.viscous[6 * i + 3 + static_cast<int>(c)] : 0.0;
        damped += damp(s_.velocity[k + c], s_.force[k + c], fv, perMass_);
        damped += damp(s_.angular[k + c], s_.torque[k + c], tv, perInertia_);
      }
      damped_.add(damped * h_, unit_);
    } else {
      for (std::size_t c = 0; c < 3; ++c) {
        s_.velocity[k + c] += perMass_ * s_.force[k + c];
        s_.angular[k + c] += perInertia_ * s_.torque[k + c];
      }
    }
  }

  void close(EnergyAccounts& accounts) const {
    accounts.damped.merge(damped_);
    accounts.external.merge(external_);
  }

 private:
  /// Kicks one component; returns the power that damping takes out.
  double damp(double& v, double force, double viscous, double factor) const {
    const double sum = force + viscous;
    const double drag = signedLike(damping_ * std::abs(sum), v);
    const double after = v + factor * (sum - drag);
    const double mean = 0.5 * (v + after);
    v = after;
    return (drag - viscous) * mean;
  }

  void bounded(int i) {
    double damped = 0, external = 0;
    for (int c = 0; c < 3; ++c) {
      double load = 0, couple = 0, held = 0;
      bool fixed = false, still = false;
      for (const Action& a : actions_) {
        if (!(s_.group[i] & a.bit)) continue;
        load += a.force[c];
        couple += a.torque[c];
        still = still || a.fixRotation;
        if (a.fix[static_cast<std::size_t>(c)]) fixed = true, held = a.velocity[c];
      }
      const double fv = s_.viscous ? s_.viscous[6 * i + c] : 0.0;
      const double tv = s_.viscous ? s_.viscous[6 * i + 3 + c] : 0.0;
      component(s_.velocity[3 * i + c], s_.force[3 * i + c], fv, load, fixed, held, perMass_, mass_,
                damped, external);
      component(s_.angular[3 * i + c], s_.torque[3 * i + c], tv, couple, still, 0.0, perInertia_,
                inertia_, damped, external);
    }
    damped_.add(damped * h_, unit_);
    external_.add(external * h_, unit_);
  }

  /// Adds the powers that damping takes out and the boundary brings in.
  void component(double& v, double force, double viscous, double load, bool fixed, double held,
                 double factor, double inertia, double& damped, double& external) const {
    if (fixed) {
      // The holder brings in what the held body gains beyond the work of the forces on it.
      const double mean = 0.5 * (v + held);
      external += inertia * (held - v) / h_ * mean - (force + viscous) * mean;
      damped -= viscous * mean;
      v = held;
      return;
    }
    const double before = v;
    damped += damp(v, force + load, viscous, factor);
    external += load * 0.5 * (before + v);
  }

  State& s_;
  const std::vector<Action>& actions_;
  std::int32_t mask_;
  double damping_, h_, perMass_, perInertia_, mass_, inertia_;
  SumUnit unit_;
  ExactSum damped_, external_;
};

}  // namespace

DriftReport Verlet::kickAndDrift(State& state, const ForceField& forces,
                                 const Boundaries& boundaries, EnergyAccounts& accounts) const {
  const double h = 0.5 * dt_;
  const auto actions = actionsAt(boundaries, state.time, state.time + h);
  // Half a segment in a step is far beyond any stable motion.
  const double farthest = 0.5 * forces.fibre().length / dt_;
  const double fastest2 = farthest * farthest;
  const bool tracks = forces.tracksMotion();
  const auto& shares = forces.shares();
  std::vector<DriftReport> reports(shares.size());
#pragma omp parallel num_threads(static_cast <int>(shares.size()))
  {
    const auto t = static_cast<std::size_t>(omp_get_thread_num());
    Kicker kick(state, forces, boundaries, actions, damping_, h);
    DriftReport report;
    for (std::int32_t i = shares[t].begin; i < shares[t].end; ++i) {
      kick(i);
      double* x = state.pose + 8 * i;
      const double* v = state.velocity + 3 * i;
      const double* w = state.angular + 3 * i;
      for (int c = 0; c < 3; ++c) x[c] += dt_ * v[c];
      state.box.wrap(x, state.image + 3 * i);
      state.setOrientation(
          i, renormalised(rotation({dt_ * w[0], dt_ * w[1], dt_ * w[2]}) * state.orientation(i)));
      if (tracks && forces.moved(x, i)) report.stale = true;
      const double turn2 = dt_ * dt_ * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
      // Written so that a NaN counts as unstable.
      if (!(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < fastest2 && turn2 < 1.0))
        report.unstable = true;
    }
    reports[t] = report;
#pragma omp critical
    kick.close(accounts);
  }
  state.time += dt_;
  ++state.step;
  DriftReport all;
  for (const DriftReport& r : reports) {
    all.stale = all.stale || r.stale;
    all.unstable = all.unstable || r.unstable;
  }
  return all;
}

void Verlet::kick(State& state, const ForceField& forces, const Boundaries& boundaries,
                  EnergyAccounts& accounts) const {
  const auto actions = actionsAt(boundaries, state.time, state.time);
  const auto& shares = forces.shares();
#pragma omp parallel num_threads(static_cast <int>(shares.size()))
  {
    const auto t = static_cast<std::size_t>(omp_get_thread_num());
    Kicker kick(state, forces, boundaries, actions, damping_, 0.5 * dt_);
    for (std::int32_t i = shares[t].begin; i < shares[t].end; ++i) kick(i);
#pragma omp critical
    kick.close(accounts);
  }
}

}  // namespace nanoweft
