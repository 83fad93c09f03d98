#include "nanoweft/motion/residual.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nanoweft {

bool stillDriven(const State& state, const ForceField& forces, const Boundaries& boundaries) {
  return boundaries.loadsGrow(state.time) ||
         std::ranges::any_of(forces.walls().list(), [&](const Wall& w) {
           return w.driven() ? w.factor(state.time) < 1
                             : w.travels() || (w.moves() && state.time < w.stop);
         });
}

void applyBoundaries(Residual& residual, const State& state, const Boundaries& boundaries, int i) {
  for (const Boundary& b : boundaries.list()) {
    if (!(state.group[i] & 1 << b.bit)) continue;
    const double f = b.factor(state.time);
    const double force[3] = {b.force.x, b.force.y, b.force.z},
                 torque[3] = {b.torque.x, b.torque.y, b.torque.z};
    for (int c = 0; c < 3; ++c) {
      residual.force[c] += f * force[c];
      residual.torque[c] += f * torque[c];
    }
  }
  for (const Boundary& b : boundaries.list()) {
    if (!(state.group[i] & 1 << b.bit)) continue;
    for (int c = 0; c < 3; ++c) {
      if (b.fix[static_cast<std::size_t>(c)]) residual.force[c] = 0;
      if (b.fixRotation) residual.torque[c] = 0;
    }
  }
}

double largestResidual(const State& state, const ForceField& forces, const Boundaries& boundaries) {
  double largest = 0;
  for (int i = 0; i < state.owned(); ++i) {
    const Residual r = residualOf(state, boundaries, i);
    const double f2 = r.force[0] * r.force[0] + r.force[1] * r.force[1] + r.force[2] * r.force[2];
    const double t2 =
        r.torque[0] * r.torque[0] + r.torque[1] * r.torque[1] + r.torque[2] * r.torque[2];
    const double length = forces.kinds()[state.kind(i)].length;
    const double perLength2 = 1.0 / (length * length);
    const double worst = std::max(f2, t2 * perLength2);
    // A NaN counts as an infinite force, so that it never passes for equilibrium.
    largest =
        std::isfinite(worst) ? std::max(largest, worst) : std::numeric_limits<double>::infinity();
  }
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, state.comm());
  return std::sqrt(largest);
}

}  // namespace nanoweft
