/// A liquid bridge at each crossing, of a given volume V (Rabinovich et al., Langmuir 21, 10992
/// (2005)): the force of a crossing is -C (1 - g/sqrt(g^2 + b)), C = 4 pi gamma cos(theta) R,
/// b = V/(pi R), and -C where surfaces touch. It is the slope of the energy
/// -C (sqrt(g^2 + b) - g), which the switch multiplies.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "nanoweft/force/surface_law.hpp"

namespace nanoweft {

namespace {

using Values = SurfaceLawType::Values;
using std::numbers::pi;

/// The gap at which a bridge ruptures.
double usualCutoff(const Values& v) {
  return (1.0 + 0.5 * v[1]) * std::cbrt(v[2]);
}

double perfectWetting(const Values&) {
  return 0.0;
}

SurfaceProfile profile(const Values& v, double radius, const Switch& range) {
  const double pull = 4.0 * pi * v[0] * std::cos(v[1]) * radius, b = v[2] / (pi * radius);
  // Of the energy of a crossing.
  auto energy = [=](double g) {
    if (g <= 0.0) return AtGap{pull * (g - std::sqrt(b)), pull, 0.0};
    const double root = std::sqrt(g * g + b);
    return AtGap{-pull * b / (root + g), pull * b / (root * (root + g)),
                 -pull * b / (root * root * root)};
  };
  auto p = [=](double g) {
    const AtGap e = energy(g);
    double s, ds;
    range.factor(g, s, ds);
    return AtGap{-0.5 / pi * (e.slope * s + e.value * ds),
                 -0.5 / pi * (e.curvature * s + 2.0 * e.slope * ds + e.value * range.curvature(g))};
  };
  // Forces change most in the switch, or near contact where the bridge is thin.
  const double width = std::min((range.to - range.from) / 6.0, std::sqrt(b) / 3.0);
  // The slope of p has a kink where the switch ends.
  return {p, 0.0, 0.0, width, false, 3e-4};
}

}  // namespace

SurfaceLawType capillaryLaw() {
  constexpr double any = std::numeric_limits<double>::infinity();
  return {"capillary",
          {{"capillary_tension", "none", "surface tension gamma of the liquid", 1, -2, any,
            SurfaceLawType::equal, nullptr},
           {"capillary_angle", "0", "contact angle theta of the liquid", 0, 0, 1.57,
            SurfaceLawType::equal, perfectWetting},
           {"capillary_volume", "none", "volume V of the bridge at a crossing", 0, 3, any,
            SurfaceLawType::equal, nullptr}},
          usualCutoff,
          "(1 + theta/2) V^(1/3), where a bridge ruptures",
          profile};
}

}  // namespace nanoweft
