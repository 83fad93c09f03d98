/// The options of the pair forces and the defaults that follow from fibre and law.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_forces.hpp"
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
/// Stands for the law between two kinds whose own laws differ.
const char* undecided = "undecided";

/// Two kinds of fibre, or twice the same, whose pair force is read.
struct Reader {
  Options& options;
  const UnitSystem& units;
  const Fibre &a, &b;
  std::string prefix;  ///< of the options meant for these two: "cnt_mw_", or nothing
  std::string chosen;  ///< law

  OptionSection of(const char* law) const {
    return {options, topic, chosen == law, "-pair is " + chosen};
  }
  bool is(const char* law) const { return chosen == law; }
  bool mixed() const { return &a != &b; }
  /// An option meant for these two, for messages.
  std::string option(const char* name) const { return "-" + prefix + name; }
  /// Distance of the axes of two fibres that touch.
  double touch() const { return a.radius + b.radius; }
};

/// What a law says between fibres of one kind; from this follow its defaults between two kinds.
struct OwnLaw {
  std::string chosen;
  VdwParameters vdw;
  double hertz = 0;
};

double geometric(double x, double y) {
  return x == y ? x : std::sqrt(x) * std::sqrt(y);
}
/// The default of a number that two kinds must agree on; NaN when they don't.
double common(double x, double y) {
  return x == y ? x : std::numeric_limits<double>::quiet_NaN();
}

/// The defaults between fibres of one kind.
VdwParameters usualVdw(const UnitSystem& units) {
  VdwParameters p;
  p.length *= units.angstrom;
  p.epsilon *= units.electronvolt;
  p.stiffness *= units.electronvolt / (units.angstrom * units.angstrom);
  return p;
}

/// The defaults between two kinds.
VdwParameters meanOf(const VdwParameters& x, const VdwParameters& y) {
  VdwParameters p = x;
  p.length = 0.5 * (x.length + y.length);
  p.epsilon = geometric(x.epsilon, y.epsilon);
  p.stiffness = geometric(x.stiffness, y.stiffness);
  p.smooth = x.smooth || y.smooth;
  p.a = common(x.a, y.a);
  p.b = common(x.b, y.b);
  p.alpha = common(x.alpha, y.alpha);
  p.beta = common(x.beta, y.beta);
  return p;
}

/// The parameters per pair of segments of length 2 lambda, without switch and cutoff.
VdwParameters readVdw(const Reader& read, const VdwParameters& usual) {
  OptionSection s = read.of("vdw");
  const UnitSystem& units = read.units;
  VdwParameters p = usual;
  const std::string perArea = std::string(units.energy) + "/" + units.length + "^2";
  p.smooth =
      s.choice("vdw_splice", p.smooth ? "smooth" : "kink", {"smooth", "kink"},
               "where the linear repulsion joins: equal stiffness, or the minimum") == "smooth";
  p.length = s.real("vdw_length", p.length, units.length,
                    "lambda: the law is one of (r - 2 rf)/lambda", positive);
  p.epsilon = s.real("vdw_epsilon", p.epsilon, units.energy,
                     "depth parameter eps of two lengths of 2 lambda", positive);
  p.a = s.real("vdw_a", p.a, "", "factor A of the repulsive power", positive);
  p.b = s.real("vdw_b", p.b, "", "factor B of the attractive power", positive);
  p.alpha = s.real("vdw_alpha", p.alpha, "", "repulsive exponent", positive);
  p.beta = s.real("vdw_beta", p.beta, "", "attractive exponent, below alpha", positive);
  p.stiffness =
      s.real("vdw_stiffness", p.stiffness, perArea.c_str(),
             "k of the repulsion of two lengths of 2 lambda: u = ... + k (r - rs)^2", positive);
  if (std::isnan(p.a + p.b + p.alpha + p.beta) && read.is("vdw"))
    throw InputError(format(
        "kinds %s and %s have different exponents or factors of the law vdw: give %s, _b, _alpha "
        "and _beta for their pairs",
        read.a.kind.c_str(), read.b.kind.c_str(), read.option("vdw_a").c_str()));
  if (p.beta >= p.alpha)
    throw InputError(format("%s %g: must be below %s %g", read.option("vdw_beta").c_str(), p.beta,
                            read.option("vdw_alpha").c_str(), p.alpha));
  p.radius = 0.5 * read.touch();
  return p;
}

void readRange(const Reader& read, VdwParameters& p) {
  const char* unit = read.units.length;
  const bool kinds = !read.a.kind.empty();
  OptionSection distance(read.options, topic, read.is("vdw") && !kinds,
                         kinds ? "with -kinds, ranges are gaps: -pair_gap_switch, -pair_gap_cutoff"
                               : "-pair is " + read.chosen);
  OptionSection gap = read.of("vdw");
  auto place = [&](const char* name, const char* gapName, double lengths, const char* what) {
    const std::string shown = format("2 rf + %g lambda", lengths),
                      shownGap = format("%g lambda", lengths);
    const auto whole = distance.maybeReal(name, shown.c_str(), unit, what, positive);
    const auto part =
        gap.maybeReal(gapName, shownGap.c_str(), unit,
                      format("the same as a gap between surfaces: %s", what).c_str(), positive);
    if (whole && part) throw InputError(format("-%s, -%s: give one of the two", name, gapName));
    return whole ? *whole : read.touch() + part.value_or(lengths * p.length);
  };
  p.switchFrom =
      place("pair_switch", "pair_gap_switch", 4.0, "distance where the switch-off begins");
  p.cutoff = place("pair_cutoff", "pair_gap_cutoff", 6.0, "distance where pair forces end");
  if (p.cutoff <= p.switchFrom)
    throw InputError(
        kinds ? format("%s %g: must lie beyond %s %g", read.option("pair_gap_cutoff").c_str(),
                       p.cutoff - read.touch(), read.option("pair_gap_switch").c_str(),
                       p.switchFrom - read.touch())
              : format("-pair_cutoff %g: must lie beyond -pair_switch %g", p.cutoff, p.switchFrom));
}

ContactSide contactSideOf(const Fibre& f) {
  return {f.radius, f.transverse, f.poisson};
}

/// The default K between fibres of one kind.
double usualHertz(const Fibre& f, const UnitSystem& units) {
  if (f.transverse > 0) return hertzStiffness(contactSideOf(f), contactSideOf(f));
  // Nobody has measured the tube's contacts: 200 eV/A^2.5 are soft enough for its time step.
  return 200.0 * (units.electronvolt / std::pow(units.angstrom, 2.5)) *
         std::sqrt(f.radius / (6.78 * units.angstrom));
}

double readHertz(const Reader& read, double usual) {
  OptionSection s = read.of("hertz");
  const std::string unit = std::string(read.units.energy) + "/" + read.units.length + "^2.5";
  return s.real("hertz_stiffness", usual, unit.c_str(),
                "K of u = K (2 rf - r)^2.5 of two lengths of 2 rf; from -fibre_transverse_young "
                "where that is known",
                positive);
}

/// Resting distance of two fibres in units of lambda; with the paper's parameters, the paper's
/// rounded value.
double restOf(const VdwParameters& p) {
  const VdwParameters paper;
  if (p.a != paper.a || p.b != paper.b || p.alpha != paper.alpha || p.beta != paper.beta)
    return Vdw(p).restDistance() / p.length;
  return 2.0 * p.radius / p.length + restGap;
}

/// Centre distance of two parallel segments at rest whose ends are as far apart along them as the
/// law is wide; all in units of lambda.
double endsApart(double rest, double diameter, double length) {
  return std::hypot(rest, length + std::sqrt(2.0 * rest * (rest - diameter)));
}

/// Where far points begin to take over: 30 A for the (10,10) tube, for others as `endsApart`.
double farFrom(const Reader& read, const VdwParameters& p) {
  const double length = 0.5 * (read.a.length + read.b.length);
  const double own = endsApart(restOf(p), read.touch() / p.length, length / p.length),
               ofTube = endsApart(2.0 + restGap, 2.0, 2.0);
  return own / ofTube * (farPlace * p.length);
}

/// Points of near and far pairs on the segments of one of the kinds.
struct OwnPoints {
  int near, far;
};

OwnPoints readOwnPoints(const Reader& read, const Fibre& f, double rest, double from) {
  const OptionPrefix prefix(read.options, f.kind);
  OptionSection s(read.options, topic, !read.is("none"), "-pair is none");
  OptionSection range = read.of("vdw");
  const bool ranged = read.is("vdw");
  auto needed = [&](double distance, double gap, double spacing) {
    const int points = pointsNeeded(f.length, distance, gap, spacing);
    // A few points too little are better than a kernel that takes any number of them.
    if (points > mostCompiledPoints && !read.mixed() &&
        pointsNeeded(f.length, distance, gap, softSpacing) <= mostCompiledPoints)
      return mostCompiledPoints;
    return std::min(mostPairPoints, points);
  };
  const double width = lawWidth(rest, read.a, read.b);
  OwnPoints points;
  const auto given = s.maybeInteger("pair_points", "by the law's width; 5 for cnt_10_10",
                                    "points per segment", 1, mostPairPoints);
  points.near =
      given ? static_cast<int>(*given) : needed(rest, width, ranged ? nearSpacing : softSpacing);
  const int few = std::min(points.near, needed(from, from - read.touch(), farSpacing));
  points.far = static_cast<int>(
      range
          .maybeInteger("pair_far_points",
                        "by the law's width, 1 for cnt_10_10; as -pair_points where that is given",
                        "points per segment of pairs far apart", 1, points.near)
          .value_or(given || std::isinf(from) ? points.near : few));
  return points;
}

/// Points for near and far pairs. `vdw`: parameters of the only law that has a far range.
PointChoice readPoints(const Reader& read, double rest, const VdwParameters& vdw) {
  const double from = farFrom(read, vdw);
  const bool ranged = read.is("vdw");
  const double usual = ranged && from < vdw.cutoff ? from : std::numeric_limits<double>::infinity();
  const OwnPoints ofA = readOwnPoints(read, read.a, rest, usual),
                  ofB = read.mixed() ? readOwnPoints(read, read.b, rest, usual) : ofA;
  PointChoice points;
  points.near = {ofA.near, ofB.near};
  points.far = {ofA.far, ofB.far};
  const bool fewer = points.far != points.near;
  OptionSection far(
      read.options, topic, ranged && fewer,
      ranged ? "-pair_far_points is not below -pair_points" : "-pair is " + read.chosen);
  const char* unit = read.units.length;
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
  choice.length = {read.a.length, read.b.length};
  OptionSection ofVdw = read.of("vdw");
  choice.single =
      ofVdw.choice("pair_precision", "double", {"double", "single"},
                   "of the law's values and of their sums over a pair's points; pairs of two kinds "
                   "are always summed in double") == "single";
  if (choice.single && !singlePrecisionPays())
    throw InputError(
        "-pair_precision single: needs a build for AVX-512 (-DNANOWEFT_ARCH=x86-64-v4 or native "
        "where the processor has it); in others it would be slower than double");
  if (read.mixed()) return choice;
  const double places = excludedDiameters * read.a.diameter() / read.a.length;
  choice.exclude = static_cast<int>(
      s.maybeInteger("pair_exclude", "20 * 2 rf / T",
                     "segments of one fibre interact from this many places apart", 2, 1000000)
          .value_or(std::clamp(static_cast<long>(std::ceil(std::min(places, 1e6) - 1e-9)), 2l,
                               1000000l)));
  return choice;
}

template <class Law>
PairTraits traitsOf(const Reader& read, const Law& law, double restDistance,
                    const std::string& description) {
  return {description,
          law.cutoff(),
          restDistance,
          law.closestSensible(),
          {read.a.radius, read.b.radius},
          law.contactStiffness(),
          law.largestForce()};
}

std::unique_ptr<PairForce> makeVdw(const Reader& read, const VdwParameters& p, double rest,
                                   const PairChoice& choice) {
  const Vdw law(p.of(choice.length, unequalRadii(read.a.radius, read.b.radius)));
  if (law.spliceDistance() >= p.switchFrom || law.restDistance() >= p.switchFrom)
    throw InputError(read.prefix.empty()
                         ? format("-pair_switch %g: must lie beyond the resting distance %g %s",
                                  p.switchFrom, law.restDistance(), read.units.length)
                         : format("%s %g: must lie beyond the gap at rest, %g %s",
                                  read.option("pair_gap_switch").c_str(),
                                  p.switchFrom - read.touch(), law.restDistance() - read.touch(),
                                  read.units.length));
  const char *length = read.units.length, *energy = read.units.energy;
  const std::string description = format(
      "vdw %s, eps %.5g %s, A %g, B %g, alpha %g, beta %g, lambda %.4g %s, k %.4g %s/%s^2, "
      "rest distance %.6g %s, range %.6g to %.6g %s",
      p.smooth ? "smooth" : "kink", p.epsilon, energy, p.a, p.b, p.alpha, p.beta, p.length, length,
      p.stiffness, energy, length, rest, length, p.switchFrom, p.cutoff, length);
  return makePairForce(law.table(), traitsOf(read, law, rest, description), choice);
}

std::unique_ptr<PairForce> makeHertz(const Reader& read, double stiffness,
                                     const PairChoice& choice) {
  const double lengths =
      (choice.length.i / read.a.diameter()) * (choice.length.j / read.b.diameter());
  const Hertz law(stiffness * lengths, 0.5 * read.touch());
  return makePairForce(
      law,
      traitsOf(read, law, read.touch(),
               format("hertz, K %.5g %s/%s^2.5, range %.6g %s", stiffness, read.units.energy,
                      read.units.length, read.touch(), read.units.length)),
      choice);
}

/// Reads all that concerns two kinds, with the law's defaults between them; `law` gets what holds.
std::unique_ptr<PairForce> readOne(Reader& read, OwnLaw& law) {
  OptionSection pair(read.options, topic);
  read.chosen =
      pair.choice("pair", law.chosen, {"vdw", "hertz", "none"}, "law of the forces between fibres");
  law.chosen = read.chosen;
  if (read.chosen == undecided)
    throw InputError(format("kinds %s and %s have different pair laws: give %s vdw, hertz or none",
                            read.a.kind.c_str(), read.b.kind.c_str(), read.option("pair").c_str()));
  PairChoice choice = readChoice(read);
  VdwParameters vdw = readVdw(read, law.vdw);
  readRange(read, vdw);
  law.vdw = vdw;
  law.hertz = readHertz(read, law.hertz);
  const double rest = read.is("vdw") ? restOf(vdw) * vdw.length : read.touch();
  choice.points = readPoints(read, rest, vdw);
  if (read.is("vdw")) return makeVdw(read, vdw, rest, choice);
  if (read.is("hertz")) return makeHertz(read, law.hertz, choice);
  return nullptr;
}

struct KindWithLaw {
  const Fibre& fibre;
  const OwnLaw& law;
};

/// The default K between two kinds: from their moduli, as much softer or stiffer as the kinds' own.
double hertzBetween(const KindWithLaw& one, const KindWithLaw& other, const UnitSystem& units) {
  const auto& [a, ofA] = one;
  const auto& [b, ofB] = other;
  if (!(a.transverse > 0 && b.transverse > 0)) return geometric(ofA.hertz, ofB.hertz);
  return hertzStiffness(contactSideOf(a), contactSideOf(b)) *
         geometric(ofA.hertz / usualHertz(a, units), ofB.hertz / usualHertz(b, units));
}

/// The defaults between two kinds.
OwnLaw between(const KindWithLaw& one, const KindWithLaw& other, const UnitSystem& units) {
  const OwnLaw &ofA = one.law, &ofB = other.law;
  OwnLaw law;
  law.chosen = ofA.chosen == ofB.chosen                       ? ofA.chosen
               : ofA.chosen == "none" || ofB.chosen == "none" ? "none"
                                                              : undecided;
  law.vdw = meanOf(ofA.vdw, ofB.vdw);
  law.hertz = hertzBetween(one, other, units);
  return law;
}

}  // namespace

double usualRestDistance(const Fibre& a, const Fibre& b, const UnitSystem& units) {
  if (a.law != "vdw" || b.law != "vdw") return a.radius + b.radius;
  VdwParameters p = usualVdw(units);
  p.radius = 0.5 * (a.radius + b.radius);
  return restOf(p) * p.length;
}

PairForces readPairForces(Options& options, const UnitSystem& units, const Kinds& kinds) {
  std::vector<PairForces::Class> classes;
  auto keep = [&](int first, int second, std::unique_ptr<PairForce> force) {
    if (force) classes.push_back({first, second, std::move(force)});
  };
  std::vector<OwnLaw> own;
  for (int k = 0; k < kinds.count(); ++k) {
    const Fibre& f = kinds[k];
    const std::string name = f.kind.empty() ? "" : f.kind + "_" + f.kind;
    const OptionPrefix prefix(options, name);
    Reader read{options, units, f, f, name.empty() ? "" : name + "_", ""};
    own.push_back({f.law, usualVdw(units), usualHertz(f, units)});
    keep(k, k, readOne(read, own.back()));
  }
  for (int i = 0; i < kinds.count(); ++i)
    for (int j = i + 1; j < kinds.count(); ++j) {
      const std::string name = kinds[i].kind + "_" + kinds[j].kind;
      const OptionPrefix prefix(options, name);
      OwnLaw law = between({kinds[i], own[static_cast<std::size_t>(i)]},
                           {kinds[j], own[static_cast<std::size_t>(j)]}, units);
      const bool swap = kinds[j].length > kinds[i].length;
      const int first = swap ? j : i, second = swap ? i : j;
      Reader read{options, units, kinds[first], kinds[second], name + "_", ""};
      keep(first, second, readOne(read, law));
    }
  return PairForces(std::move(classes));
}

}  // namespace nanoweft
