/// The options of the pair forces and the defaults that follow from fibre and law.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/quadrature.hpp"
#include "nanoweft/force/vdw.hpp"

namespace nanoweft {

namespace {

/// In units of lambda: the gap at rest, and the begin and width of the far range. Written so that
/// the (10,10) tube gets exactly 17.343571 A (rest distance), 30 A and 2 A, without round-off.
constexpr double restGap = 17.343571 / 6.78 - 2.0, farPlace = 30.0 / 6.78, farWidth = 2.0 / 6.78;
/// Arc length, in diameters, within which segments of one fibre do not interact.
constexpr double excludedDiameters = 20;

const char* topic = "Pair forces";

struct Reader {
  Options& options;
  const UnitSystem& units;
  const Fibre& fibre;
  std::string chosen;  ///< law

  OptionSection of(const char* law) const {
    return {options, topic, chosen == law, "-pair is " + chosen};
  }
  bool is(const char* law) const { return chosen == law; }
};

/// The parameters per pair of segments of length 2 lambda, without switch and cutoff.
VdwParameters readVdw(const Reader& read) {
  OptionSection s = read.of("vdw");
  const UnitSystem& units = read.units;
  VdwParameters p;
  const std::string perArea = std::string(units.energy) + "/" + units.length + "^2";
  p.smooth =
      s.choice("vdw_splice", "smooth", {"smooth", "kink"},
               "where the linear repulsion joins: equal stiffness, or the minimum") == "smooth";
  p.length = s.real("vdw_length", p.length * units.angstrom, units.length,
                    "lambda: the law is one of (r - 2 rf)/lambda", positive);
  p.epsilon = s.real("vdw_epsilon", p.epsilon * units.electronvolt, units.energy,
                     "depth parameter eps of two lengths of 2 lambda", positive);
  p.a = s.real("vdw_a", p.a, "", "factor A of the repulsive power", positive);
  p.b = s.real("vdw_b", p.b, "", "factor B of the attractive power", positive);
  p.alpha = s.real("vdw_alpha", p.alpha, "", "repulsive exponent", positive);
  p.beta = s.real("vdw_beta", p.beta, "", "attractive exponent, below alpha", positive);
  p.stiffness = s.real(
      "vdw_stiffness", p.stiffness * (units.electronvolt / (units.angstrom * units.angstrom)),
      perArea.c_str(), "k of the repulsion of two lengths of 2 lambda: u = ... + k (r - rs)^2",
      positive);
  if (p.beta >= p.alpha)
    throw InputError(format("-vdw_beta %g: must be below -vdw_alpha %g", p.beta, p.alpha));
  p.radius = read.fibre.radius;
  return p;
}

void readRange(const Reader& read, VdwParameters& p) {
  OptionSection s = read.of("vdw");
  const char* unit = read.units.length;
  p.switchFrom = s.maybeReal("pair_switch", "2 rf + 4 lambda", unit,
                             "distance where the switch-off begins", positive)
                     .value_or(read.fibre.diameter() + 4.0 * p.length);
  p.cutoff = s.maybeReal("pair_cutoff", "2 rf + 6 lambda", unit, "distance where pair forces end",
                         positive)
                 .value_or(read.fibre.diameter() + 6.0 * p.length);
  if (p.cutoff <= p.switchFrom)
    throw InputError(
        format("-pair_cutoff %g: must lie beyond -pair_switch %g", p.cutoff, p.switchFrom));
}

double readHertz(const Reader& read) {
  OptionSection s = read.of("hertz");
  const Fibre& f = read.fibre;
  const double angstrom = read.units.angstrom;
  const std::string unit = std::string(read.units.energy) + "/" + read.units.length + "^2.5";
  // Nobody has measured the tube's contacts: 200 eV/A^2.5 are soft enough for its time step.
  const double usual = f.transverse > 0
                           ? hertzStiffness(f.transverse, f.poisson, f.radius)
                           : 200.0 * (read.units.electronvolt / std::pow(angstrom, 2.5)) *
                                 std::sqrt(f.radius / (6.78 * angstrom));
  return s.real("hertz_stiffness", usual, unit.c_str(),
                "K of u = K (2 rf - r)^2.5 of two lengths of 2 rf; from -fibre_transverse_young "
                "where that is known",
                positive);
}

/// Resting distance of two fibres in units of lambda; with the paper's parameters, the paper's
/// rounded value.
double restOf(const VdwParameters& p, const Fibre& fibre) {
  const VdwParameters paper;
  if (p.a != paper.a || p.b != paper.b || p.alpha != paper.alpha || p.beta != paper.beta)
    return Vdw(p).restDistance() / p.length;
  return fibre.diameter() / p.length + restGap;
}

/// Centre distance of two parallel segments at rest whose ends are as far apart along them as the
/// law is wide; all in units of lambda.
double endsApart(double rest, double diameter, double length) {
  return std::hypot(rest, length + std::sqrt(2.0 * rest * (rest - diameter)));
}

/// Where far points begin to take over: 30 A for the (10,10) tube, for others as `endsApart`.
double farFrom(const VdwParameters& p, const Fibre& f) {
  const double own = endsApart(restOf(p, f), f.diameter() / p.length, f.length / p.length),
               ofTube = endsApart(2.0 + restGap, 2.0, 2.0);
  return own / ofTube * (farPlace * p.length);
}

/// Points for near and far pairs. `vdw`: parameters of the only law that has a far range.
PointChoice readPoints(const Reader& read, double restDistance, const VdwParameters& vdw) {
  OptionSection s(read.options, topic, !read.is("none"), "-pair is none");
  const Fibre& f = read.fibre;
  const char* unit = read.units.length;
  const bool ranged = read.is("vdw");
  auto needed = [&](double distance, double gap, double spacing) {
    return std::min(mostPairPoints, pointsNeeded(f.length, distance, gap, spacing));
  };
  PointChoice points;
  const auto given = s.maybeInteger("pair_points", "by the law's width; 5 for cnt_10_10",
                                    "points per segment", 1, mostPairPoints);
  points.near =
      given ? static_cast<int>(*given)
            : needed(restDistance, lawWidth(restDistance, f), ranged ? nearSpacing : softSpacing);
  const double from = farFrom(vdw, f);
  const int few = ranged && from < vdw.cutoff
                      ? std::min(points.near, needed(from, from - f.diameter(), farSpacing))
                      : points.near;
  OptionSection range = read.of("vdw");
  points.far = static_cast<int>(
      range
          .maybeInteger("pair_far_points",
                        "by the law's width, 1 for cnt_10_10; as -pair_points where that is given",
                        "points per segment of pairs far apart", 1, points.near)
          .value_or(given ? points.near : few));
  const bool fewer = points.far < points.near;
  OptionSection far(
      read.options, topic, ranged && fewer,
      ranged ? "-pair_far_points is not below -pair_points" : "-pair is " + read.chosen);
  points.blend.from =
      far.maybeReal("pair_far_from",
                    "where ends of segments that touch are apart; 30 A for cnt_10_10", unit,
                    "centre distance from which -pair_far_points begin to take over", positive)
          .value_or(from);
  points.blend.to =
      points.blend.from + far.maybeReal("pair_far_width", "0.295 lambda; 2 A for cnt_10_10", unit,
                                        "width of the range in which they take over", positive)
                              .value_or(farWidth * vdw.length);
  if (!fewer) points.blend.from = points.blend.to = std::numeric_limits<double>::infinity();
  return points;
}

PairChoice readChoice(const Reader& read) {
  OptionSection s(read.options, topic, !read.is("none"), "-pair is none");
  PairChoice choice;
  choice.length = read.fibre.length;
  const double places = excludedDiameters * read.fibre.diameter() / read.fibre.length;
  choice.exclude = static_cast<int>(
      s.maybeInteger("pair_exclude", "20 * 2 rf / T",
                     "segments of one fibre interact from this many places apart", 2, 1000000)
          .value_or(std::clamp(static_cast<long>(std::ceil(std::min(places, 1e6) - 1e-9)), 2l,
                               1000000l)));
  OptionSection ofVdw = read.of("vdw");
  choice.single =
      ofVdw.choice("pair_precision", "double", {"double", "single"},
                   "of the law's values and of their sums over a pair's points") == "single";
  if (choice.single && !singlePrecisionPays())
    throw InputError(
        "-pair_precision single: needs a build for AVX-512 (-DNANOWEFT_ARCH=x86-64-v4 or native "
        "where the processor has it); in others it would be slower than double");
  return choice;
}

template <class Law>
PairTraits traitsOf(const Law& law, double restDistance, const std::string& description) {
  return {description,           law.cutoff(),           restDistance,
          law.closestSensible(), law.contactStiffness(), law.largestForce()};
}

std::unique_ptr<PairForce> makeVdw(const Reader& read, const VdwParameters& p, double rest,
                                   const PairChoice& choice) {
  const Vdw law(p.of(read.fibre.length));
  if (law.spliceDistance() >= p.switchFrom || law.restDistance() >= p.switchFrom)
    throw InputError(format("-pair_switch %g: must lie beyond the resting distance %g %s",
                            p.switchFrom, law.restDistance(), read.units.length));
  const char *length = read.units.length, *energy = read.units.energy;
  const std::string description = format(
      "vdw %s, eps %.5g %s, A %g, B %g, alpha %g, beta %g, lambda %.4g %s, k %.4g %s/%s^2, "
      "rest distance %.6g %s, range %.6g to %.6g %s",
      p.smooth ? "smooth" : "kink", p.epsilon, energy, p.a, p.b, p.alpha, p.beta, p.length, length,
      p.stiffness, energy, length, rest, length, p.switchFrom, p.cutoff, length);
  return makePairForce(law.table(), traitsOf(law, rest, description), choice);
}

std::unique_ptr<PairForce> makeHertz(const Reader& read, double stiffness,
                                     const PairChoice& choice) {
  const Fibre& f = read.fibre;
  const double lengths = f.length / f.diameter();
  const Hertz law(stiffness * (lengths * lengths), f.radius);
  return makePairForce(
      law,
      traitsOf(law, f.diameter(),
               format("hertz, K %.5g %s/%s^2.5, range %.6g %s", stiffness, read.units.energy,
                      read.units.length, f.diameter(), read.units.length)),
      choice);
}

}  // namespace

double usualRestDistance(const Fibre& fibre, const UnitSystem& units) {
  if (fibre.law != "vdw") return fibre.diameter();
  VdwParameters p;
  p.length *= units.angstrom;
  p.radius = fibre.radius;
  return restOf(p, fibre) * p.length;
}

std::unique_ptr<PairForce> readPairForce(Options& options, const UnitSystem& units,
                                         const Fibre& fibre) {
  OptionSection pair(options, topic);
  Reader read{
      options, units, fibre,
      pair.choice("pair", fibre.law, {"vdw", "hertz", "none"}, "law of the forces between fibres")};
  PairChoice choice = readChoice(read);
  VdwParameters vdw = readVdw(read);
  readRange(read, vdw);
  const double stiffness = readHertz(read);
  const double rest = read.is("vdw") ? restOf(vdw, fibre) * vdw.length : fibre.diameter();
  choice.points = readPoints(read, rest, vdw);
  if (read.is("vdw")) return makeVdw(read, vdw, rest, choice);
  if (read.is("hertz")) return makeHertz(read, stiffness, choice);
  return nullptr;
}

}  // namespace nanoweft
