#include "nanoweft/force/vdw_range.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/test_bundle.hpp"

namespace nanoweft {

namespace {

/// The pairs of the bundle: how often each square of a distance, in units of the nearest one,
/// occurs.
std::map<int, int> squaredDistances() {
  const auto places = bundlePlaces();
  std::map<int, int> count;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const int a = places[i][0] - places[j][0], b = places[i][1] - places[j][1];
      ++count[a * a + a * b + b * b];
    }
  return count;
}

/// Energy of the bundle, up to a factor that depends on `rest` alone.
double cohesion(const VdwParameters& parameters, double rest) {
  static const std::map<int, int> pairs = squaredDistances();
  const Vdw law(parameters);
  const double cutoff2 = parameters.cutoff * parameters.cutoff;
  // A small part of the law's width along a fibre; the sum then has all digits that matter.
  const double step = 0.075 * std::sqrt(2.0 * rest * (rest - 2.0 * parameters.radius));
  double sum = 0;
  for (const auto& [norm, count] : pairs) {
    const double d2 = norm * rest * rest;
    for (int k = 0; d2 + (k * step) * (k * step) < cutoff2; ++k)
      sum += count * (k == 0 ? 0.5 : 1.0) * law(d2 + (k * step) * (k * step)).energy;
  }
  return sum;
}

void setRange(double gap, VdwParameters& law) {
  const double touch = 2.0 * law.radius;
  law.switchFrom = touch + gap * law.length * 2.0 / 3.0;
  law.cutoff = touch + gap * law.length;
}

/// The same law that reaches through the whole bundle.
VdwParameters wide(VdwParameters law, double rest) {
  law.switchFrom = 2.0 * law.radius + 2.0 * bundleRings * rest;
  law.cutoff = 1.2 * law.switchFrom;
  return law;
}

}  // namespace

double cohesionLost(const VdwParameters& law, double rest) {
  const VdwParameters whole = wide(law, rest);
  if (law.cutoff >= whole.cutoff) return 0;
  return std::max(0.0, 1.0 - cohesion(law, rest) / cohesion(whole, rest));
}

void setRangeByAccuracy(double accuracy, double rest, VdwParameters& law) {
  const double whole = cohesion(wide(law, rest), rest), least = 1.0 - accuracy / 5;
  // In units of lambda; with the default exponents the widest one loses less than a thousandth.
  for (const double gap : {2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 16.0}) {
    setRange(gap, law);
    if (law.switchFrom > rest && cohesion(law, rest) / whole >= least) return;
  }
  throw InputError(
      format("-pair_accuracy %g: not reached with a range of 16 lambda, which takes %.2g %% of a "
             "bundle's cohesion; give -pair_gap_switch and -pair_gap_cutoff",
             accuracy, 100 * cohesionLost(law, rest)));
}

}  // namespace nanoweft
