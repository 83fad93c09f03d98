/// Surfaces that are held by hydrogen bonds, e = gamma (5 (s/g)^12 - 6 (s/g)^10): the minimum is
/// -gamma at the gap s.
#include <cmath>
#include <limits>

#include "nanoweft/force/surface_law.hpp"

namespace nanoweft {

namespace {

using Values = SurfaceLawType::Values;

/// The curvature of e at its minimum.
double ownStiffness(const Values& v) {
  return 120.0 * v[0] / (v[1] * v[1]);
}

/// There e is 1e-5 of its minimum.
double usualCutoff(const Values& v) {
  return 3.75 * v[1];
}

SurfaceProfile profile(const Values& v, double radius, const Switch& range) {
  const double depth = v[0], least = v[1];
  auto beyond = [=](double g) {
    const double tenth = std::pow(least / g, 10), twelfth = tenth * (least / g) * (least / g);
    return AtGap{depth * (5.0 * twelfth - 6.0 * tenth), 60.0 * depth / g * (tenth - twelfth)};
  };
  return profileOfEnergy({least, -depth, v[2], ownStiffness(v)}, beyond, radius, range);
}

}  // namespace

SurfaceLawType hydrogenLaw() {
  constexpr double any = std::numeric_limits<double>::infinity();
  return {"hydrogen",
          {{"hydrogen_energy", "none", "energy per area gamma that parts two surfaces", 1, -2, any,
            SurfaceLawType::geometric, nullptr},
           {"hydrogen_gap", "none", "gap s at which the energy of two surfaces is least", 0, 1, any,
            SurfaceLawType::arithmetic, nullptr},
           {"hydrogen_stiffness", "120 gamma/s^2, that of the law at s",
            "stiffness per area of surfaces closer than s", 1, -4, any, SurfaceLawType::geometric,
            ownStiffness}},
          usualCutoff,
          "3.75 s",
          profile};
}

}  // namespace nanoweft
