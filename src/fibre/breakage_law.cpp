#include "nanoweft/fibre/breakage_law.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nanoweft/base/random.hpp"

namespace nanoweft {

namespace {

using std::numbers::sqrt2;

/// No segment's index: the counter of a fibre's own draw.
constexpr std::uint32_t ofFibre = 0xffffffffu;

/// For exp(logTail) <= 1/2, by Newton's iteration on the logarithm of the tail, which is concave.
/// The start is not below the root, since the tail is at most exp(-x^2/2)/2; so the iteration falls
/// to the root.
double upperQuantile(double logTail) {
  const double inverseRoot2Pi = std::sqrt(0.5 * std::numbers::inv_pi);
  double x = std::sqrt(std::max(0.0, -2.0 * (logTail + std::numbers::ln2)));
  for (int k = 0; k < 60; ++k) {
    const double tail = 0.5 * std::erfc(x / sqrt2);
    const double density = inverseRoot2Pi * std::exp(-0.5 * x * x);
    const double next = x + (std::log(tail) - logTail) * tail / density;
    if (!(next < x)) break;
    x = next;
  }
  return x;
}

}  // namespace

double normalQuantileOfTail(double logTail) {
  // Beyond, the tail is too small for a number.
  logTail = std::max(logTail, -650.0);
  if (logTail <= -std::numbers::ln2) return upperQuantile(logTail);
  return -upperQuantile(std::log(-std::expm1(logTail)));
}

double BreakageLaw::normal(std::int64_t fibre, std::uint32_t counter, double draws) const {
  if (draws == 1.0) return normalDraw(seed, Purpose::breakage, fibre, counter);
  // The weakest of several: (1 - F)^draws is uniform.
  const double u = uniformPair(seed, Purpose::breakage, fibre, counter)[0];
  return normalQuantileOfTail(std::log(u) / draws);
}

double BreakageLaw::shareWithoutStrength() const {
  if (weibull && !(perFibre && scatter > 0)) return 0;
  // Of the weakest of several: 1 - (1 - F)^draws.
  auto below = [](double sigmas, double draws) {
    return -std::expm1(draws * std::log1p(-0.5 * std::erfc(sigmas / sqrt2)));
  };
  const double mains =
      weibull || deviation == 0 ? 0.0 : below(mean / deviation, perFibre ? 1.0 : diameters);
  return mains + (perFibre && scatter > 0 ? below(1.0 / scatter, diameters) : 0.0);
}

double BreakageLaw::criticalStrain(std::int64_t fibre, std::int32_t index,
                                   std::int32_t segments) const {
  const auto own = static_cast<std::uint32_t>(index);
  const std::uint32_t counter = perFibre ? ofFibre : own;
  double strain;
  if (weibull) {
    const double length = perFibre ? bondLength * segments : bondLength;
    const double u = uniformPair(seed, Purpose::breakage, fibre, counter)[0];
    strain = strain0 * std::pow(-std::log(u) * length0 / length, 1.0 / shape);
  } else {
    strain = mean + deviation * normal(fibre, counter, perFibre ? 1.0 : diameters);
  }
  if (perFibre && scatter > 0) strain *= 1.0 + scatter * normal(fibre, own, diameters);
  return strain;
}

namespace {

void readNormal(OptionSection& s, const Strength& usual, BreakageLaw& law) {
  law.mean = s.maybeReal("break_strain_mean", "of the preset, 0.3 for cnt_10_10", "",
                         "mean of the critical strains of lengths of 2 rf, or of whole fibres with "
                         "-break_per fibre",
                         positive)
                 .value_or(usual.mean);
  law.deviation =
      s.maybeReal("break_strain_std", "of the preset, 0.05 for cnt_10_10", "",
                  "standard deviation of the critical strains of lengths of 2 rf, or of whole "
                  "fibres",
                  nonNegative)
          .value_or(usual.deviation);
}

void readWeibull(OptionSection& s, const UnitSystem& units, const Strength& usual,
                 BreakageLaw& law) {
  law.shape = s.maybeReal("break_weibull_shape", "of the preset, 5 for carbon_t300", "",
                          "m of Weibull's law P = 1 - exp(-(L/L0) (strain/strain0)^m)", positive)
                  .value_or(usual.shape);
  law.strain0 = s.maybeReal("break_weibull_strain", "of the preset, 0.015 for carbon_t300", "",
                            "strain0 of Weibull's law", positive)
                    .value_or(usual.strain);
  law.length0 =
      s.maybeReal("break_weibull_length", "of the preset, 0.025 m for carbon_t300", units.length,
                  "L0 of Weibull's law: the gage that strain0 belongs to", positive)
          .value_or(usual.length);
}

}  // namespace

std::optional<BreakageLaw> readBreakage(Options& options, const UnitSystem& units,
                                        const Fibre& fibre, std::uint64_t seed) {
  const std::string title = "Breakage (on when any of these is given)";
  OptionSection s(options, title);
  bool wanted = false;
  for (const char* name :
       {"break_law", "break_strain_mean", "break_strain_std", "break_seed", "break_per",
        "break_scatter", "break_weibull_shape", "break_weibull_strain", "break_weibull_length"})
    wanted = s.given(name) || wanted;
  BreakageLaw law;
  law.bondLength = fibre.length;
  law.diameters = fibre.length / fibre.diameter();
  const Strength& usual = fibre.strength;
  law.weibull = s.choice("break_law", usual.weibull ? "weibull" : "normal", {"normal", "weibull"},
                         "distribution of the critical strains; unless given that of the preset") ==
                "weibull";
  OptionSection normal(options, title, !law.weibull, "-break_law is weibull");
  readNormal(normal, usual, law);
  OptionSection weibull(options, title, law.weibull, "-break_law is normal");
  readWeibull(weibull, units, usual, law);
  law.seed =
      static_cast<std::uint64_t>(s.maybeInteger("break_seed", "that of -seed",
                                                "seed of the critical strains", 0, 9000000000000000)
                                     .value_or(static_cast<long>(seed)));
  law.perFibre = s.choice("break_per", "bond", {"bond", "fibre"},
                          "one critical strain for each bond, or for each fibre") == "fibre";
  OptionSection along(options, title, law.perFibre, "-break_per is bond");
  law.scatter = along.real("break_scatter", 0.01, "",
                           "standard deviation along a fibre with one critical strain, over that "
                           "strain",
                           nonNegative);
  return wanted ? std::optional(law) : std::nullopt;
}

}  // namespace nanoweft
