#include "nanoweft/motion/fire.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nanoweft/base/threads.hpp"
#include "nanoweft/motion/masses.hpp"
#include "nanoweft/motion/residual.hpp"

namespace nanoweft {

namespace {
// The parameters of Bitzek et al.; the least step is that of Guenole et al., Comput. Mater. Sci.
// 175, 109584 (2020).
constexpr double firstMixing = 0.1, mixingFactor = 0.99, growth = 1.1, shrink = 0.5;
constexpr std::int64_t patience = 5;                  // steps downhill before the step grows
constexpr double firstStep = 0.25, leastStep = 0.02;  // of the longest
constexpr double usualMove = 0.1;                     // of a diameter or segment

}  // namespace

Fire::Fire(const Kinds& kinds, double longest, std::optional<double> farthest)
    : verlet_(firstStep * longest, 0.0), longest_(longest), mixing_(firstMixing) {
  // An exact sum holds terms from 1e-22 to 1e5 times the scale of its unit. With these scales it
  // holds forces from 1e-12 to 36 times the force that doubles a bond's length.
  double forceScale = 0, speedScale = 0, least = kinds.shortest();
  for (const Fibre& fibre : kinds) {
    const double force = fibre.bond.stretch * fibre.length;
    forceScale = std::max(forceScale, 0.01 * force * force / fibre.mass);
    speedScale = std::max(speedScale, 0.01 * force * fibre.length);
    halves_.push_back(std::max(0.5 * fibre.length, fibre.radius));
    least = std::min(least, fibre.diameter());
  }
  farthest_ = farthest.value_or(usualMove * least);
  forceUnit_ = SumUnit(forceScale);
  speedUnit_ = SumUnit(speedScale);
  powerUnit_ = SumUnit(std::sqrt(forceScale * speedScale));
}

void Fire::limit(double dt) {
  setLongest(std::min(longest_, dt));
}

void Fire::setLongest(double dt) {
  longest_ = dt;
  verlet_.setStep(std::min(verlet_.dt(), longest_));
}

DriftReport Fire::move(System& system) {
  // The first step follows from the state that the run starts from; `finish` limits all others.
  if (!std::exchange(started_, true)) {
    double keep = 1, push = 0, dt = verlet_.dt();
    brake(slope(system), keep, push, dt);
    if (keep < 1) turn(system, keep, push);
    verlet_.setStep(dt);
  }
  return verlet_.move(system);
}

void Fire::brake(const Slope& slope, double& keep, double& push, double& dt) const {
  const double speed = keep * slope.fastest + push * slope.hardest;
  if (dt * (speed + 0.5 * dt * slope.hardest) <= farthest_) return;
  // The forces alone move a point by at most half of it.
  if (dt * dt * slope.hardest > farthest_) dt = std::sqrt(farthest_ / slope.hardest);
  const double scale = std::min(1.0, (farthest_ / dt - 0.5 * dt * slope.hardest) / speed);
  keep *= scale;
  push *= scale;
}

void Fire::finish(System& system, bool) {
  verlet_.finish(system, true);
  const Slope s = slope(system);
  double keep = 0, push = 0, dt = verlet_.dt();
  if (s.power >= 0) {
    keep = 1.0 - mixing_;
    push = s.force2 > 0 ? mixing_ * std::sqrt(s.speed2 / s.force2) : 0.0;
    if (++downhill_ > patience) {
      dt = std::min(growth * dt, longest_);
      mixing_ *= mixingFactor;
    }
  } else {  // also when a sum overflowed
    dt = std::max(shrink * dt, leastStep * longest_);
    mixing_ = firstMixing;
    downhill_ = 0;
  }
  brake(s, keep, push, dt);
  turn(system, keep, push);
  verlet_.setStep(dt);
}

Fire::Slope Fire::slope(const System& system) const {
  const State& s = system.state;
  const Masses masses(system.forces.kinds());
  const auto& shares = system.forces.shares();
  ExactSum sums[3];
  double most[2] = {0, 0};
  onShares(shares.size(), [&](std::size_t t) {
    const Share share = shares[t];
    ExactSum mine[3];
    double fastest = 0, hardest = 0;
    for (std::int32_t i = share.begin; i < share.end; ++i) {
      const auto [mass, inertia, perMass, perInertia] = masses.of(s, i);
      const Residual r = residualOf(s, system.boundaries, i);
      const double* v = s.velocity + 3 * i;
      const double* w = s.angular + 3 * i;
      double power = 0, v2 = 0, w2 = 0, f2 = 0, t2 = 0;
      for (int c = 0; c < 3; ++c) {
        power += r.force[c] * v[c] + r.torque[c] * w[c];
        v2 += v[c] * v[c];
        w2 += w[c] * w[c];
        f2 += r.force[c] * r.force[c];
        t2 += r.torque[c] * r.torque[c];
      }
      mine[0].add(power, powerUnit_);
      mine[1].add(mass * v2 + inertia * w2, speedUnit_);
      mine[2].add(perMass * f2 + perInertia * t2, forceUnit_);
      const double half = halves_[halves_.size() > 1 ? static_cast<std::size_t>(s.kind(i)) : 0];
      fastest = std::max(fastest, std::sqrt(v2) + half * std::sqrt(w2));
      hardest = std::max(hardest, perMass * std::sqrt(f2) + half * perInertia * std::sqrt(t2));
    }
#pragma omp critical
    {
      for (int k = 0; k < 3; ++k) sums[k].merge(mine[k]);
      most[0] = std::max(most[0], fastest), most[1] = std::max(most[1], hardest);
    }
  });
  ExactSum::reduce(sums, 3, s.comm());
  MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, s.comm());
  return {sums[0].value(powerUnit_), sums[1].value(speedUnit_), sums[2].value(forceUnit_), most[0],
          most[1]};
}

void Fire::turn(System& system, double keep, double push) const {
  State& s = system.state;
  const Masses masses(system.forces.kinds());
  const SumUnit& unit = system.forces.energyUnit();
  const auto& shares = system.forces.shares();
  onShares(shares.size(), [&](std::size_t t) {
    const Share share = shares[t];
    ExactSum removed;
    for (std::int32_t i = share.begin; i < share.end; ++i) {
      const auto [mass, inertia, perMass, perInertia] = masses.of(s, i);
      const Residual r = residualOf(s, system.boundaries, i);
      double* v = s.velocity + 3 * i;
      double* w = s.angular + 3 * i;
      double v2 = 0, w2 = 0;  // what the squares lose
      for (int c = 0; c < 3; ++c) {
        const double newV = keep * v[c] + push * perMass * r.force[c];
        const double newW = keep * w[c] + push * perInertia * r.torque[c];
        v2 += v[c] * v[c] - newV * newV;
        w2 += w[c] * w[c] - newW * newW;
        v[c] = newV;
        w[c] = newW;
      }
      removed.add(0.5 * (mass * v2 + inertia * w2), unit);
    }
#pragma omp critical
    system.accounts.damped.merge(removed);
  });
}

void Fire::save(RunRecord& record) const {
  record.reals["fire"] = {verlet_.dt(), longest_, mixing_};
  record.integers["fire_downhill"] = {downhill_};
}

void Fire::restore(const RunRecord& record) {
  const auto& reals = record.needReals("fire", 3);
  verlet_.setStep(reals[0]);
  longest_ = reals[1];
  mixing_ = reals[2];
  downhill_ = record.needIntegers("fire_downhill", 1)[0];
  started_ = true;
}

}  // namespace nanoweft
