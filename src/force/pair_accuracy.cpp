#include "nanoweft/force/pair_accuracy.hpp"

#include <algorithm>
#include <optional>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/quadrature.hpp"

namespace nanoweft {

namespace {

/// What the estimate must fall below, over the accuracy: in films, where fibres cross at all angles
/// and end, the error is up to twice the estimate.
constexpr double margin = 0.5;

/// Places that are tried for the split of a law.
constexpr int places = 8;

}  // namespace

PointChoice pointsByAccuracy(double accuracy, const Fibre& fibre, double rest, double switchFrom,
                             const MakeWithPoints& make) {
  auto errors = [&](const PointChoice& points) {
    return expectedForceErrors(*make(points), fibre);
  };
  auto enough = [&](const std::optional<ForceErrors>& found) {
    return found && found->larger() <= margin * accuracy;
  };
  int near = 1;
  for (auto found = errors({1, 1}); !enough(found); found = errors({near, near})) {
    if (!found && near == 1)
      throw InputError(format(
          "-pair_accuracy %g: the errors of this law can't be estimated, since it only attracts or "
          "is very wide or narrow beside a segment; give -pair_points instead",
          accuracy));
    if (!found)
      throw InputError(
          format("-pair_accuracy %g: not reached with %d points on a segment, and more "
                 "take too long to estimate; give -pair_points, or take shorter "
                 "segments",
                 accuracy, near - 1));
    if (near == mostPairPoints)
      throw InputError(format(
          "-pair_accuracy %g: not reached with %d points on a segment; take shorter segments",
          accuracy, near));
    ++near;
  }
  if (switchFrom <= rest) return {near, near};
  for (int more = near; more <= std::min(near + 1, mostPairPoints); ++more)
    for (int far = 1; far < std::min(near, 3); ++far)
      for (int k = 1; k < places; ++k) {
        const PointChoice split{more, far, rest + (switchFrom - rest) * k / places};
        if (enough(errors(split))) return split;
      }
  return {near, near};
}

}  // namespace nanoweft
