#include "nanoweft/motion/step_limit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/random.hpp"

namespace nanoweft {

namespace {

/// Largest eigenvalue of a symmetric tridiagonal matrix, by bisection on Sturm counts.
double largestEigenvalue(const std::vector<double>& diagonal, const std::vector<double>& off) {
  double low = diagonal[0], high = diagonal[0];
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const double r =
        (i > 0 ? std::abs(off[i - 1]) : 0.0) + (i < off.size() ? std::abs(off[i]) : 0.0);
    low = std::max(low, diagonal[i]);
    high = std::max(high, diagonal[i] + r);
  }
  for (int k = 0; k < 100 && high - low > 1e-12 * std::abs(high); ++k) {
    const double x = 0.5 * (low + high);
    bool above = false;  // some eigenvalue exceeds x
    double d = 1.0;
    for (std::size_t i = 0; i < diagonal.size() && !above; ++i) {
      d = x - diagonal[i] - (i > 0 ? off[i - 1] * off[i - 1] / d : 0.0);
      if (d == 0) d = -1e-300;
      above = d < 0;
    }
    (above ? low : high) = x;
  }
  return high;
}

/// Dot product over all ranks, exact, so that the limit is the same on any number of ranks.
double globalDot(const std::vector<double>& a, const std::vector<double>& b, const SumUnit& unit,
                 MPI_Comm comm) {
  ExactSum sum;
  for (std::size_t k = 0; k < a.size(); ++k) sum.add(a[k] * b[k], unit);
  ExactSum::reduce(&sum, 1, comm);
  return sum.value(unit);
}

/// The mass-weighted stiffness matrix at the present pose, through its product with a vector. A
/// vector has six numbers a segment: the displacement times the root of the mass, and the rotation
/// times the root of the moment of inertia.
class Stiffness {
 public:
  Stiffness(State& state, ForceField& forces, Halo& halo)
      : state_(state),
        forces_(forces),
        halo_(halo),
        n_(static_cast<std::size_t>(state.owned())),
        scales_(scalesOf(forces.kinds())),
        pose_(state.pose, state.pose + 8 * n_) {}

  /// Sets `product` to the stiffness times q, by central differences of the forces. Collective.
  void multiply(const std::vector<double>& q, std::vector<double>& product) {
    double largest = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      const Scale& s = scaleOf(i);
      for (std::size_t c = 0; c < 6; ++c)
        largest = std::max(largest, std::abs(q[6 * i + c]) *
                                        (c >= 3 ? s.perRootInertia : s.perRootMass / s.length));
    }
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, state_.comm());
    const double step = 1e-6 / largest;  // displacements of 1e-6 segments, turns of 1e-6 radians
    product.resize(6 * n_);
    forcesAt(q, step, [&](std::size_t k, double force) { product[k] = force; });
    forcesAt(q, -step, [&](std::size_t k, double force) {
      product[k] = (force - product[k]) / (2.0 * step);
    });
  }

  /// Brings back pose and forces. Collective.
  void restore() {
    std::copy(pose_.begin(), pose_.end(), state_.pose);
    evaluate();
  }

 private:
  /// Of a segment: what makes its coordinates mass-weighted, and its length.
  struct Scale {
    double perRootMass, perRootInertia, length;
  };
  static std::vector<Scale> scalesOf(const Kinds& kinds) {
    std::vector<Scale> scales;
    for (const Fibre& f : kinds)
      scales.push_back({1.0 / std::sqrt(f.mass), 1.0 / std::sqrt(f.inertia), f.length});
    return scales;
  }
  const Scale& scaleOf(std::size_t i) const {
    return scales_[static_cast<std::size_t>(state_.kind(static_cast<int>(i)))];
  }

  void evaluate() {
    ForceRequest request;
    request.mayBreak = request.viscous = false;
    forces_.evaluate(state_, halo_, request);
  }

  /// Calls take(k, force) with each number of the mass-weighted forces at the pose displaced by
  /// `step` along q.
  template <class Take>
  void forcesAt(const std::vector<double>& q, double step, const Take& take) {
    for (std::size_t i = 0; i < n_; ++i) {
      const Scale& scale = scaleOf(i);
      const double a = step * scale.perRootMass, b = step * scale.perRootInertia;
      for (std::size_t c = 0; c < 3; ++c)
        state_.pose[8 * i + c] = pose_[8 * i + c] + a * q[6 * i + c];
      const Quatd old{pose_[8 * i + 4], pose_[8 * i + 5], pose_[8 * i + 6], pose_[8 * i + 7]};
      state_.setOrientation(static_cast<int>(i),
                            rotation({b * q[6 * i + 3], b * q[6 * i + 4], b * q[6 * i + 5]}) * old);
    }
    evaluate();
    for (std::size_t i = 0; i < n_; ++i) {
      const Scale& scale = scaleOf(i);
      for (std::size_t c = 0; c < 3; ++c) {
        take(6 * i + c, scale.perRootMass * state_.force[3 * i + c]);
        take(6 * i + 3 + c, scale.perRootInertia * state_.torque[3 * i + c]);
      }
    }
  }

  State& state_;
  ForceField& forces_;
  Halo& halo_;
  std::size_t n_;
  std::vector<Scale> scales_;  ///< of the kinds
  std::vector<double> pose_;
};

/// A random vector of length one over all ranks, so that it has a part of every mode. It depends on
/// the segments' ids alone.
std::vector<double> randomDirection(const State& state) {
  const auto n = static_cast<std::size_t>(state.owned());
  std::vector<double> q(6 * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < 6; ++c)
      q[6 * i + c] = normalDraw(c, Purpose::stepEstimate, state.row[i], 0);
  const double norm = std::sqrt(globalDot(q, q, SumUnit(1e3), state.comm()));
  for (double& x : q) x /= norm;
  return q;
}

/// Limit for a mode of frequency 2/step that is damped with retardation time t: the viscous force
/// is that of half a step earlier, so x'' = -w^2 x - t w^2 x' is stable up to 4 = 2 t w^2 dt + w^2
/// dt^2.
double withViscosity(double step, double t) {
  return t > 0 ? step * (step / (std::hypot(t, step) + t)) : step;
}

double slowest(const Kinds& kinds) {
  double longest = 0;
  for (const Fibre& f : kinds) longest = std::max(longest, f.retardation);
  return longest;
}

/// A segment beside an endless parallel fibre, at the distance d of their axes, whose segments
/// repeat after `period`.
PairAction besideLine(const PairForce& force, double d, double period) {
  PairAction sum;
  const int images = static_cast<int>(force.reach() / period) + 1;
  for (int k = -images; k <= images; ++k) {
    const PairAction one =
        force.average(force.points().near, {k * period, d, 0}, {1, 0, 0}, {1, 0, 0});
    sum.energy += one.energy;
    sum.force += one.force;
  }
  return sum;
}

/// Largest stiffness of such a segment between rest and where fibres come that fall together from
/// afar: there the pair has its energy back. Fibres that do not attract each other come as deep as
/// a twentieth of the thinner one's radius.
double pressedStiffness(const PairForce& force, double period) {
  const double rest = force.restDistance(), step = 0.005 * (rest - force.closestSensible()),
               thinner = std::min(force.radius().i, force.radius().j);
  const bool attracts = besideLine(force, rest, period).energy < 0;
  double stiffest = 0, before = besideLine(force, rest, period).force.y;
  for (int k = 1; k < 200; ++k) {
    const PairAction at = besideLine(force, rest - k * step, period);
    stiffest = std::max(stiffest, (before - at.force.y) / step);
    before = at.force.y;
    if (attracts ? at.energy >= 0 : k * step >= 0.05 * thinner) break;
  }
  return stiffest;
}

}  // namespace

double presentStepLimit(State& state, ForceField& forces, Halo& halo) {
  Stiffness stiffness(state, forces, halo);
  // Scale of the exact sums: 1e3 times a chain's omega^2, since contacts may be far stiffer.
  double chain = 0;
  for (const Fibre& f : forces.kinds())
    chain = std::max(chain, 4e3 / std::pow(chainStepLimit(f), 2));
  const SumUnit ofProduct(chain), ofSquare(chain * chain);
  // A run's memory is largest here, so none of these is copied.
  std::vector<double> q = randomDirection(state), before(q.size(), 0.0), next;
  std::vector<double> diagonal, off;
  double eigenvalue = 0, norm = 0;
  int settled = 0;
  for (int k = 0; k < 120; ++k) {
    stiffness.multiply(q, next);
    const double a = globalDot(q, next, ofProduct, state.comm());
    const double b = off.empty() ? 0.0 : off.back();
    for (std::size_t j = 0; j < q.size(); ++j) next[j] -= a * q[j] + b * before[j];
    diagonal.push_back(a);
    const double previous = eigenvalue;
    eigenvalue = largestEigenvalue(diagonal, off);
    settled = std::abs(eigenvalue - previous) < 1e-4 * std::abs(eigenvalue) ? settled + 1 : 0;
    norm = std::sqrt(globalDot(next, next, ofSquare, state.comm()));
    // A smaller norm is round-off of the sums: few segments have no more directions.
    if (settled >= 4 || !(norm > 1e-6 * std::abs(eigenvalue))) break;
    q.swap(before);
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = next[j] / norm;
    off.push_back(norm);
  }
  stiffness.restore();
  // A driven wall moves as well, and is bound to the segments that it touches: the largest
  // eigenvalue of all is at most the sum of theirs and the wall's.
  if (eigenvalue > 0) eigenvalue += forces.walls().stiffest(state, forces.nearest());
  // Sums beyond their range are no numbers: something is more than 1e5 times as stiff as the bonds.
  if (!std::isfinite(eigenvalue) || !std::isfinite(norm))
    return std::numeric_limits<double>::quiet_NaN();
  if (!(eigenvalue > 0)) return std::numeric_limits<double>::infinity();
  return withViscosity(2.0 / std::sqrt(eigenvalue),
                       state.extras().viscous ? slowest(forces.kinds()) : 0.0);
}

double chainStepLimit(const Fibre& fibre) {
  const EvmBond& b = fibre.bond;
  const double bend = 0.25 * b.shear + b.bending + 0.5 * b.torsion;
  double largest = std::max(4.0 * b.stretch / fibre.mass, 4.0 * b.torsion / fibre.inertia);
  constexpr int steps = 2000;
  for (int k = 1; k <= steps; ++k) {
    const double phase = std::numbers::pi * k / steps, c = std::cos(phase), s = std::sin(phase);
    const double ww = 2.0 * b.shear / (b.length * b.length) * (1.0 - c) / fibre.mass;
    const double tt = (0.25 * b.shear * (2.0 + 2.0 * c) + bend * (2.0 - 2.0 * c)) / fibre.inertia;
    const double wt = b.shear / b.length * s / std::sqrt(fibre.mass * fibre.inertia);
    largest = std::max(largest, 0.5 * (ww + tt) + std::hypot(0.5 * (ww - tt), wt));
  }
  return 2.0 / std::sqrt(largest);
}

double chainStepLimit(const Kinds& kinds) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Fibre& fibre : kinds)
    lowest = std::min(lowest, withViscosity(chainStepLimit(fibre), fibre.retardation));
  return lowest;
}

double bundleStepLimit(const Kinds& kinds, const PairForces& pairs) {
  double lowest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kinds.count(); ++k) {
    const double chain = chainStepLimit(kinds[k]), retardation = kinds[k].retardation;
    lowest = std::min(lowest, withViscosity(chain, retardation));
    // Pressed along its whole length, a segment turns with K T^2/12 as well.
    const double length = kinds[k].length,
                 turning = std::max(1.0, kinds[k].mass * length * length / 12 / kinds[k].inertia);
    for (int other = 0; other < kinds.count(); ++other) {
      double contact = 0;  // laws add, and so do their stiffnesses
      for (const auto& c : pairs.classes()) {
        if (!c.between(k, other)) continue;
        const Both<int> n = c.force->points().near;
        double stiffness = c.force->contactStiffness() / std::max(n.i, n.j);
        if (!c.force->touches() && c.force->keepsApart())
          stiffness = std::max(stiffness, pressedStiffness(*c.force, kinds[other].length));
        contact += turning * c.force->sticking() * stiffness;
      }
      if (!(contact > 0)) continue;
      const double pressed = 2.0 / std::sqrt(4.0 / (chain * chain) + 6.0 * contact / kinds[k].mass),
                   bonds = pressed / chain;  // share of the bonds in the frequency
      lowest = std::min(lowest, withViscosity(pressed, retardation * bonds * bonds));
    }
  }
  return lowest;
}

}  // namespace nanoweft
