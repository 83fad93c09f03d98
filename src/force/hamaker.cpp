/// Surfaces that attract by a Hamaker constant A, to their minimum at the gap g0:
/// e = -A/(12 pi g^2) (1 - (g0/g)^6/4).
#include <cmath>
#include <limits>
#include <numbers>

#include "nanoweft/force/surface_law.hpp"

namespace nanoweft {

namespace {

using Values = SurfaceLawType::Values;

/// The curvature of e at its minimum.
double ownStiffness(const Values& v) {
  return v[0] / (std::numbers::pi * std::pow(v[1], 4));
}

SurfaceProfile profile(const Values& v, double radius, const Switch& range) {
  const double least = v[1], factor = v[0] / (12.0 * std::numbers::pi);
  auto beyond = [=](double g) {
    const double sixth = std::pow(least / g, 6);
    return AtGap{-factor / (g * g) * (1.0 - 0.25 * sixth),
                 2.0 * factor / (g * g * g) * (1.0 - sixth)};
  };
  return profileOfEnergy({least, -0.75 * factor / (least * least), v[2], ownStiffness(v)}, beyond,
                         radius, range);
}

}  // namespace

SurfaceLawType hamakerLaw() {
  constexpr double any = std::numeric_limits<double>::infinity();
  return {"hamaker",
          {{"hamaker_constant", "none", "Hamaker constant A of the two surfaces", 1, 0, any,
            SurfaceLawType::geometric, nullptr},
           {"hamaker_gap", "none", "gap g0 at which the energy of two surfaces is least", 0, 1, any,
            SurfaceLawType::arithmetic, nullptr},
           {"hamaker_stiffness", "A/(pi g0^4), that of the law at g0",
            "stiffness per area of surfaces closer than g0", 1, -4, any, SurfaceLawType::geometric,
            ownStiffness}},
          nullptr,
          "none",
          profile};
}

}  // namespace nanoweft
