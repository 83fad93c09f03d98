#include "nanoweft/motion/verlet.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "nanoweft/base/threads.hpp"
#include "nanoweft/motion/masses.hpp"

namespace nanoweft {

namespace {

/// What a boundary does during a half kick, for the components of velocity and angular velocity.
struct Action {
  std::int32_t bit;
  std::array<bool, 6> fix;
  std::array<double, 6> velocity;  // at the end; of a turning group that of its centre
  std::array<double, 6> load;      // where the forces are evaluated
  // A turning group: at r from its centre its velocity is larger by
  // along e x r + inward e x (e x r), with the axis e.
  bool turns;
  Vec3d axis, centre;
  double along, inward;

  double held(std::size_t c, const State& state, int i) const {
    if (!turns || c >= 3) return velocity[c];
    const Vec3d around = cross(axis, state.position(i) - centre);
    const Vec3d v = along * around + inward * cross(axis, around);
    return velocity[c] + (c == 0 ? v.x : c == 1 ? v.y : v.z);
  }
};

/// In a half kick from `time` to `time` + h before a drift, or, with h = 0, for one that ends at
/// `time`.
Action actionOf(const Boundary& b, double time, double h) {
  const double v = b.stepFactor(time, h), f = b.factor(time);
  Action a{
      1 << b.bit,
      {b.fix[0], b.fix[1], b.fix[2], b.fixRotation, b.fixRotation, b.fixRotation},
      {v * b.velocity.x, v * b.velocity.y, v * b.velocity.z},
      {f * b.force.x, f * b.force.y, f * b.force.z, f * b.torque.x, f * b.torque.y, f * b.torque.z},
      b.spin.has_value(),
      {},
      {},
      0,
      0};
  if (!a.turns) return a;
  const double w = v * *b.spin;
  a.axis = b.axis;
  a.centre = b.centreAt(time);
  a.velocity[3] = w * b.axis.x, a.velocity[4] = w * b.axis.y, a.velocity[5] = w * b.axis.z;
  a.along = w;
  if (h == 0) return a;
  // The drift is straight and must end on the circle, so it takes the chord.
  const double s = std::sin(h * w);
  a.along = std::sin(2.0 * h * w) / (2.0 * h);
  a.inward = s * s / h;
  return a;
}

std::vector<Action> actionsAt(const Boundaries& boundaries, double time, double h) {
  std::vector<Action> actions;
  for (const Boundary& b : boundaries.list()) actions.push_back(actionOf(b, time, h));
  return actions;
}

/// |size| with the sign of x, zero for x = 0; without a branch, since signs are unpredictable.
template <class V>
NW_INLINE V signedLike(const V& size, const V& x) {
  const V zero(0.0);
  return select(x > zero, size, select(x < zero, V(-size), zero));
}

/// Kicks a component of the velocity; returns the power that damping takes out.
template <class V, class F>
NW_INLINE V damp(V& v, const V& force, const V& viscous, const F& factor, double damping) {
  using std::abs;
  const V sum = force + viscous;
  const V drag = signedLike(V(damping * abs(sum)), v);
  const V after = v + factor * (sum - drag);
  const V mean = 0.5 * (v + after);
  v = after;
  return (drag - viscous) * mean;
}

/// Makes half kicks, of whole SIMD groups where neither a boundary nor viscous damping acts.
class Kicker {
 public:
  Kicker(System& system, const std::vector<Action>& actions, double damping, double h)
      : s_(system.state),
        actions_(actions),
        mask_(system.boundaries.mask()),
        damping_(damping),
        h_(h),
        masses_(system.forces.kinds(), h),
        unit_(system.forces.energyUnit()),
        groups_(system.accounts.groups.size()) {}

  /// Segments begin <= i < end.
  void operator()(std::int32_t begin, std::int32_t end) {
    if (end - begin != laneCount || s_.viscous || !free(begin)) {
      for (std::int32_t i = begin; i < end; ++i) one(i);
    } else if (alike(begin)) {
      const Mass& m = masses_.of(s_, begin);
      group(s_.velocity + 3 * begin, s_.force + 3 * begin, [&](int) { return m.perMass; });
      group(s_.angular + 3 * begin, s_.torque + 3 * begin, [&](int) { return m.perInertia; });
    } else {
      mixed(begin);
    }
  }

  void close(EnergyAccounts& accounts) const {
    accounts.damped.merge(dampedLanes_);
    accounts.damped.merge(damped_);
    accounts.external.merge(external_);
    for (std::size_t k = 0; k < groups_.size(); ++k) accounts.groups[k].merge(groups_[k]);
  }

 private:
  bool free(std::int32_t begin) const {
    std::int32_t all = 0;
    for (int k = 0; k < laneCount; ++k) all |= s_.group[begin + k];
    return !(all & mask_);
  }

  /// Are `laneCount` segments of one kind?
  bool alike(std::int32_t begin) const {
    if (!masses_.several()) return true;
    for (int k = 1; k < laneCount; ++k)
      if (s_.kind(begin + k) != s_.kind(begin)) return false;
    return true;
  }

  /// Kicks `laneCount` segments of several kinds.
  void mixed(std::int32_t begin) {
    double perMass[3 * laneCount], perInertia[3 * laneCount];
    for (int k = 0; k < laneCount; ++k) {
      const Mass& m = masses_.of(s_, begin + k);
      std::fill_n(perMass + 3 * k, 3, m.perMass);
      std::fill_n(perInertia + 3 * k, 3, m.perInertia);
    }
    auto of = [](const double* factors) {
      return [=](int k) { return Lanes(factors + k, stdx::element_aligned); };
    };
    group(s_.velocity + 3 * begin, s_.force + 3 * begin, of(perMass));
    group(s_.angular + 3 * begin, s_.torque + 3 * begin, of(perInertia));
  }

  /// Kicks `laneCount` segments. All components are kicked alike and are contiguous, so lanes go
  /// through them without regard to segments. `factors(k)`: of the components from k on.
  template <class Factors>
  NW_INLINE void group(double* velocity, const double* force, const Factors& factors) {
    for (int k = 0; k < 3 * laneCount; k += laneCount) {
      const auto factor = factors(k);
      Lanes v(velocity + k, stdx::element_aligned);
      const Lanes f(force + k, stdx::element_aligned);
      if (damping_ > 0)
        dampedLanes_.add(h_ * damp(v, f, Lanes(0.0), factor, damping_), unit_);
      else
        v += factor * f;
      v.copy_to(velocity + k, stdx::element_aligned);
    }
  }

  void one(std::int32_t i) {
    if (s_.group[i] & mask_) return bounded(i);
    const Mass& m = masses_.of(s_, i);
    for (int c = 0; c < 3; ++c) {
      component(s_.velocity[3 * i + c], s_.force[3 * i + c], viscous(i, c), m.perMass);
      component(s_.angular[3 * i + c], s_.torque[3 * i + c], viscous(i, 3 + c), m.perInertia);
    }
  }
  double viscous(std::int32_t i, int c) const { return s_.viscousOn(i, c); }

  void component(double& v, double force, double viscous, double factor) {
    if (damping_ > 0 || s_.viscous)
      damped_.add(h_ * damp(v, force, viscous, factor, damping_), unit_);
    else
      v += factor * force;
  }

  /// A component c of the motion of a segment, angular for c >= 3, and what the fibres do to it.
  struct Component {
    std::size_t c;
    double& v;
    double force, viscous, factor, inertia;
  };

  void bounded(std::int32_t i) {
    const auto [mass, inertia, perMass, perInertia] = masses_.of(s_, i);
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      actedOn(i, {k, s_.velocity[3 * i + c], s_.force[3 * i + c], viscous(i, c), perMass, mass});
      actedOn(i, {k + 3, s_.angular[3 * i + c], s_.torque[3 * i + c], viscous(i, 3 + c), perInertia,
                  inertia});
    }
  }

  void actedOn(std::int32_t i, const Component& of) {
    double load = 0;
    std::size_t holder = actions_.size();
    for (std::size_t k = 0; k < actions_.size(); ++k) {
      if (!(s_.group[i] & actions_[k].bit)) continue;
      load += actions_[k].load[of.c];
      if (actions_[k].fix[of.c]) holder = k;
    }
    if (holder < actions_.size()) return hold(of, actions_[holder].held(of.c, s_, i), holder);
    const double before = of.v;
    damped_.add(damp(of.v, of.force + load, of.viscous, of.factor, damping_) * h_, unit_);
    const double mean = 0.5 * (before + of.v);
    external_.add(load * mean * h_, unit_);
    for (std::size_t k = 0; k < groups_.size(); ++k)
      if (s_.group[i] & actions_[k].bit) groups_[k].add(actions_[k].load[of.c] * mean * h_, unit_);
  }

  void hold(const Component& of, double held, std::size_t holder) {
    // The boundary brings in what the held segment gains beyond the work of the forces on it.
    const double mean = 0.5 * (of.v + held);
    const double work =
        (of.inertia * (held - of.v) / h_ * mean - (of.force + of.viscous) * mean) * h_;
    external_.add(work, unit_);
    if (!groups_.empty()) groups_[holder].add(work, unit_);
    damped_.add(-of.viscous * mean * h_, unit_);
    of.v = held;
  }

  State& s_;
  const std::vector<Action>& actions_;
  std::int32_t mask_;
  double damping_, h_;
  Masses masses_;
  SumUnit unit_;
  ExactLanes dampedLanes_;
  ExactSum damped_, external_;
  std::vector<ExactSum> groups_;  // as EnergyAccounts::groups
};

/// Moves segments by a whole step and reports whether lists are stale or the motion is unstable.
class Drifter {
 public:
  Drifter(State& state, const ForceField& forces, double dt)
      : s_(state),
        forces_(forces),
        dt_(dt),
        ahead_(forces.lists().foresees() ? foresight * dt : 0.0),
        tracks_(forces.lists().tracksMotion()),
        wraps_(state.box.periodic[0] || state.box.periodic[1] || state.box.periodic[2]) {
    // Half a segment in a step is far beyond any stable motion.
    const double farthest = 0.5 * forces.kinds().shortest() / dt_;
    fastest2_ = farthest * farthest;
  }

  /// Segments begin <= i < end.
  void operator()(std::int32_t begin, std::int32_t end) {
    // `group` reads four doubles for each three, so another segment must follow.
    if (end - begin == laneCount && end < s_.owned())
      group(begin);
    else
      for (std::int32_t i = begin; i < end; ++i) one(i);
  }
  const DriftReport& report() const { return report_; }

 private:
  void one(std::int32_t i) {
    double* x = s_.pose + 8 * i;
    const double* v = s_.velocity + 3 * i;
    const double* w = s_.angular + 3 * i;
    for (int c = 0; c < 3; ++c) x[c] += dt_ * v[c];
    if (wraps_) s_.box.wrap(x, s_.image + 3 * i);
    s_.setOrientation(
        i, renormalised(rotation({dt_ * w[0], dt_ * w[1], dt_ * w[2]}) * s_.orientation(i)));
    if (tracks_) track(i);
    const double turn2 = dt_ * dt_ * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    // Written so that a NaN counts as unstable.
    if (!(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < fastest2_ && turn2 < 1.0))
      report_.unstable = true;
  }

  NW_INLINE static Vec3<Lanes> triples(const double* from) {
    const auto c = loadRows<3>(from, [](std::size_t lane) { return 3 * lane; });
    return {c[0], c[1], c[2]};
  }

  void group(std::int32_t begin) {
    const Vec3<Lanes> v = triples(s_.velocity + 3 * begin);
    const Lanes dt(dt_);
    const Vec3<Lanes> turn = dt * triples(s_.angular + 3 * begin);
    // Segments that are too fast for smallRotation, or NaN, are moved one by one.
    if (!stdx::all_of(0.25 * dot(turn, turn) < Lanes(smallHalfAngle2) &&
                      dot(v, v) < Lanes(fastest2_))) {
      for (int k = 0; k < laneCount; ++k) one(begin + k);
      return;
    }
    double* pose = s_.pose + 8 * begin;
    const auto c = loadRows<8>(pose, [](std::size_t lane) { return 8 * lane; });
    const Vec3<Lanes> x{c[0] + dt * v.x, c[1] + dt * v.y, c[2] + dt * v.z};
    const Quat<Lanes> q = renormalised(smallRotation(turn) * Quat<Lanes>{c[4], c[5], c[6], c[7]});
    const Lanes moved[8] = {x.x, x.y, x.z, c[3], q.w, q.x, q.y, q.z};
    LaneIntegers column[8];
    std::memcpy(column, moved, sizeof column);
    Row row[laneCount];
    toRows<8>(column, row);
    std::memcpy(pose, row, sizeof row);
    if (wraps_)
      for (int k = 0; k < laneCount; ++k) s_.box.wrap(pose + 8 * k, s_.image + 3 * (begin + k));
    if (!tracks_ || report_.stale) return;
    for (int k = 0; k < laneCount; ++k) track(begin + k);
  }

  void track(std::int32_t i) {
    const ListKeeper& lists = forces_.lists();
    const double* p = s_.pose + 8 * i;
    if (ahead_ > 0) {
      if (!lists.movesSoon(p, s_.velocity + 3 * i, s_.angular + 3 * i, ahead_, i)) return;
      report_.staleSoon = true;
    }
    if (lists.moved(p, i)) report_.stale = true;
  }

  /// Steps that segments are followed ahead: one, and some of another since they may speed up.
  static constexpr double foresight = 1.2;

  State& s_;
  const ForceField& forces_;
  double dt_, ahead_, fastest2_;
  bool tracks_, wraps_;
  DriftReport report_;
};

/// Calls `work(begin, end)` for one SIMD group of a thread's share after the other.
template <class Work>
void inGroups(Share share, const Work& work) {
  for (std::int32_t begin = share.begin; begin < share.end; begin += laneCount)
    work(begin, std::min(begin + laneCount, share.end));
}

std::optional<HeatBath> makeBath(System& system, const std::optional<Thermostat>& thermostat,
                                 double dt, HeatBath::Half half) {
  if (!thermostat) return std::nullopt;
  return HeatBath(
      system.state, system.forces.kinds(), system.boundaries,
      {*thermostat, std::exp(-0.5 * dt * thermostat->damping), half, system.forces.energyUnit()});
}

}  // namespace

DriftReport Verlet::move(System& system) {
  State& state = system.state;
  ForceField& forces = system.forces;
  const double h = 0.5 * dt_;
  const auto actionsThen = actionsAt(system.boundaries, state.time, 0.0);
  const auto actions = actionsAt(system.boundaries, state.time, h);
  const auto& shares = forces.shares();
  std::vector<DriftReport> reports(shares.size());
  {
    ForcePass pass(forces, state, ForcePass::move);
    onShares(shares.size(), [&](std::size_t t) {
      Kicker second(system, actionsThen, damping_, h);
      Kicker first(system, actions, damping_, h);
      Drifter drift(state, forces, dt_);
      auto bath = makeBath(system, thermostat_, dt_, HeatBath::first);
      // Segments of a chunk, so few that they still are in the cache when their bonds follow.
      constexpr std::int32_t stretch = 64 * laneCount;
      for (Share part{shares[t].begin, 0}; part.begin < shares[t].end; part.begin = part.end) {
        part.end = std::min(part.begin + stretch, shares[t].end);
        inGroups(part, [&](std::int32_t begin, std::int32_t end) {
          if (owed_) {
            pass.handOver(begin, end);
            second(begin, end);
          }
          if (bath) (*bath)(begin, end);
          first(begin, end);
          // The bonds of the new positions and the next evaluation add to zero.
          std::fill(state.force + 3 * begin, state.force + 3 * end, 0.0);
          std::fill(state.torque + 3 * begin, state.torque + 3 * end, 0.0);
          drift(begin, end);
        });
        pass.moved(t, part.end);
      }
      reports[t] = drift.report();
#pragma omp critical
      {
        second.close(system.accounts);
        first.close(system.accounts);
        if (bath) bath->close(system.accounts);
      }
    });
  }
  owed_ = false;
  state.time += dt_;
  ++state.step;
  DriftReport all;
  for (const DriftReport& r : reports) {
    all.stale = all.stale || r.stale;
    all.staleSoon = all.staleSoon || r.staleSoon;
    all.unstable = all.unstable || r.unstable;
  }
  return all;
}

void Verlet::finish(System& system, bool seen) {
  State& state = system.state;
  // Runs with viscous damping or a thermostat end each step at its step.
  owed_ = !seen && !state.viscous && !thermostat_;
  if (owed_) return;
  const auto actions = actionsAt(system.boundaries, state.time, 0.0);
  const auto& shares = system.forces.shares();
  ForcePass pass(system.forces, state, ForcePass::look);
  onShares(shares.size(), [&](std::size_t t) {
    Kicker kick(system, actions, damping_, 0.5 * dt_);
    auto bath = makeBath(system, thermostat_, dt_, HeatBath::second);
    inGroups(shares[t], [&](std::int32_t begin, std::int32_t end) {
      pass.handOver(begin, end);
      kick(begin, end);
      if (bath) (*bath)(begin, end);
    });
#pragma omp critical
    {
      kick.close(system.accounts);
      if (bath) bath->close(system.accounts);
    }
  });
}

}  // namespace nanoweft
