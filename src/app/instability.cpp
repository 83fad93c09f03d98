#include "nanoweft/app/instability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/gather.hpp"

namespace nanoweft {

std::string remedyOfDrift(const BoxDrive& box) {
  std::string text = "take a smaller -ts_dt";
  if (box && box.interval() > 1)
    text += format(" or -deform_interval (the box books its work every %ld steps)", box.interval());
  return text;
}

void throwUnstable(const Moment& moment, const UnitSystem& units, const std::string& sign,
                   const std::string& remedy) {
  const State& state = moment.state();
  const double dt = moment.stepper.dt();
  // The fastest segment of all ranks; a NaN counts as infinitely fast.
  double farthest = -1.0;
  long long segment[2] = {0, 0};
  for (int i = 0; i < state.owned(); ++i) {
    const double* v = state.velocity + 3 * i;
    const double* w = state.angular + 3 * i;
    const double half = 0.5 * moment.system.forces.kinds()[state.kind(i)].length;
    const double slide = std::hypot(v[0], v[1], v[2]), turn = std::hypot(w[0], w[1], w[2]) * half;
    double distance = dt * std::max(slide, turn);
    if (!std::isfinite(slide) || !std::isfinite(turn))
      distance = std::numeric_limits<double>::infinity();
    if (distance > farthest) {
      farthest = distance;
      segment[0] = state.fibre[i];
      segment[1] = state.chain[2 * i];
    }
  }
  farthest = largestOfRanks(farthest, segment, state.comm());
  throw RunError(
      format("unstable at step %lld: fibre %lld segment %lld moves %.3g %s in a step of %g %s%s "
             "(stable limit when last looked at: %.4g); %s",
             static_cast<long long>(state.step), segment[0], segment[1], farthest, units.length, dt,
             units.time, sign.c_str(), moment.limits.present, remedy.c_str()));
}

}  // namespace nanoweft
