#include "nanoweft/motion/step_limit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

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

/// Exact, so that a step chosen by the limit is the same on any number of ranks.
double globalDot(const std::vector<double>& a, const std::vector<double>& b, const SumUnit& unit,
                 MPI_Comm comm) {
  ExactSum sum;
  for (std::size_t k = 0; k < a.size(); ++k) sum.add(a[k] * b[k], unit);
  ExactSum::reduce(&sum, 1, comm);
  return sum.value(unit);
}

}  // namespace

double presentStepLimit(State& state, ForceField& forces, Halo& halo) {
  const auto n = static_cast<std::size_t>(state.owned());
  const double perRootMass = 1.0 / std::sqrt(forces.fibre().mass),
               perRootInertia = 1.0 / std::sqrt(forces.fibre().inertia);
  const std::vector<double> pose(state.pose, state.pose + 8 * n);
  ForceRequest request;
  request.mayBreak = request.viscous = false;

  /// Mass-weighted forces at the pose displaced by `step` along the mass-weighted direction q.
  auto forcesAt = [&](const std::vector<double>& q, double step, std::vector<double>& out) {
    for (std::size_t i = 0; i < n; ++i) {
      const double a = step * perRootMass, b = step * perRootInertia;
      for (std::size_t c = 0; c < 3; ++c)
        state.pose[8 * i + c] = pose[8 * i + c] + a * q[6 * i + c];
      const Quatd old{pose[8 * i + 4], pose[8 * i + 5], pose[8 * i + 6], pose[8 * i + 7]};
      state.setOrientation(static_cast<int>(i),
                           rotation({b * q[6 * i + 3], b * q[6 * i + 4], b * q[6 * i + 5]}) * old);
    }
    forces.evaluate(state, halo, request);
    out.resize(6 * n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        out[6 * i + c] = perRootMass * state.force[3 * i + c];
        out[6 * i + 3 + c] = perRootInertia * state.torque[3 * i + c];
      }
  };

  // Stiffness per mass against a chain's; contacts may be far stiffer.
  const double chain = 1e3 * 4.0 / std::pow(chainStepLimit(forces.fibre()), 2);
  const SumUnit ofStart(1e3), ofProduct(chain), ofSquare(chain * chain);

  // A random start has a part of every mode; it depends on the segments' ids alone.
  std::vector<double> q(6 * n), before(6 * n, 0.0), plus, minus;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < 6; ++c)
      q[6 * i + c] = normalDraw(c, Purpose::stepEstimate, state.row[i], 0);
  double norm = std::sqrt(globalDot(q, q, ofStart, state.comm()));
  for (double& x : q) x /= norm;

  std::vector<double> diagonal, off;
  double eigenvalue = 0;
  int settled = 0;
  for (int k = 0; k < 120; ++k) {
    double largest = 0;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const bool turns = j % 6 >= 3;
      largest = std::max(
          largest, std::abs(q[j]) * (turns ? perRootInertia : perRootMass / forces.fibre().length));
    }
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, state.comm());
    const double step = 1e-6 / largest;  // displacements of 1e-6 segments, turns of 1e-6 radians
    forcesAt(q, step, plus);
    forcesAt(q, -step, minus);
    for (std::size_t j = 0; j < q.size(); ++j) plus[j] = (minus[j] - plus[j]) / (2.0 * step);
    const double a = globalDot(q, plus, ofProduct, state.comm());
    const double b = off.empty() ? 0.0 : off.back();
    for (std::size_t j = 0; j < q.size(); ++j) plus[j] -= a * q[j] + b * before[j];
    diagonal.push_back(a);
    const double previous = eigenvalue;
    eigenvalue = largestEigenvalue(diagonal, off);
    settled = std::abs(eigenvalue - previous) < 1e-4 * std::abs(eigenvalue) ? settled + 1 : 0;
    norm = std::sqrt(globalDot(plus, plus, ofSquare, state.comm()));
    if (settled >= 4 || !(norm > 1e-9 * std::abs(eigenvalue))) break;
    before = q;
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = plus[j] / norm;
    off.push_back(norm);
  }
  std::copy(pose.begin(), pose.end(), state.pose);
  forces.evaluate(state, halo, request);
  return eigenvalue > 0 ? 2.0 / std::sqrt(eigenvalue) : std::numeric_limits<double>::infinity();
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

double bundleStepLimit(const Fibre& fibre, const PairForce* pair) {
  const double chain = chainStepLimit(fibre);
  if (!pair) return chain;
  const double contact = pair->contactStiffness() / pair->points().near;
  return 2.0 / std::sqrt(4.0 / (chain * chain) + 6.0 * contact / fibre.mass);
}

}  // namespace nanoweft
