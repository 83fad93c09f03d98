#include "nanoweft/force/pair_accuracy.hpp"

#include <algorithm>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/quadrature.hpp"

namespace nanoweft {

namespace {

/// What the estimate must fall below, over the accuracy: in films, where fibres cross at all angles
/// and end, the error is up to twice the estimate.
constexpr double margin = 0.5;

/// Places that are tried for the split of a law.
constexpr int places = 8;

bool keeps(double accuracy, const PairForce& force, const Fibre& fibre) {
  const auto errors = expectedForceErrors(force, fibre);
  if (!errors)
    throw InputError(format(
        "-pair_accuracy %g: the error of the law %s can't be estimated, since it only attracts or "
        "is very wide or narrow beside a segment; give -pair_points instead",
        accuracy, force.description().substr(0, force.description().find_first_of(" ,")).c_str()));
  return errors->larger() <= margin * accuracy;
}

}  // namespace

PointChoice pointsByAccuracy(double accuracy, const Fibre& fibre, double rest, double switchFrom,
                             const MakeWithPoints& make) {
  auto enough = [&](const PointChoice& points) { return keeps(accuracy, *make(points), fibre); };
  int near = 1;
  while (!enough({near, near}))
    if (++near > mostPairPoints)
      throw InputError(
          format("-pair_accuracy %g: not reached with %d points; take shorter segments", accuracy,
                 mostPairPoints));
  if (switchFrom <= rest) return {near, near};
  for (int more = near; more <= std::min(near + 1, mostPairPoints); ++more)
    for (int far = 1; far < std::min(near, 3); ++far)
      for (int k = 1; k < places; ++k) {
        const PointChoice split{more, far, rest + (switchFrom - rest) * k / places};
        if (enough(split)) return split;
      }
  return {near, near};
}

}  // namespace nanoweft
