/// The options of the pair forces and the defaults that follow from fibre and law.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/contact_read.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_accuracy.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "nanoweft/force/pair_reader.hpp"
#include "nanoweft/force/quadrature.hpp"
#include "nanoweft/force/vdw.hpp"
#include "nanoweft/force/vdw_range.hpp"

namespace nanoweft {

namespace {

/// Arc length, in diameters, within which segments of one fibre do not interact.
constexpr double excludedDiameters = 20;

constexpr const char* topic = PairReader::topic;
/// Stands for the law between two kinds whose own laws differ.
const std::vector<std::string> undecided{"undecided"};

/// What a law says between fibres of one kind; from this follow its defaults between two kinds.
struct OwnLaw {
  std::vector<std::string> chosen;
  VdwParameters vdw;
  double hertz = 0;
  SurfaceValues surface;
  FrictionLaw friction;
  std::optional<double> accuracy;
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
VdwParameters readVdw(const PairReader& read, const VdwParameters& usual) {
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

/// The chosen laws that reach beyond contact.
std::vector<std::string> rangedLaws(const PairReader& read) {
  std::vector<std::string> ranged;
  if (read.is("vdw")) ranged.push_back("vdw");
  for (const SurfaceLawType& type : surfaceLaws())
    if (read.is(type.name)) ranged.push_back(type.name);
  return ranged;
}

/// The range by -pair_..., meant for the only law that has one.
GivenRange readRange(const PairReader& read) {
  const char* unit = read.units.length;
  const bool kinds = !read.a.kind.empty();
  const auto ranged = rangedLaws(read);
  const std::string reason =
      "-pair is " + read.laws() +
      (ranged.size() < 2 ? "" : ": give -" + ranged[0] + "_gap_... or -" + ranged[1] + "_gap_...");
  OptionSection distance(
      read.options, topic, ranged.size() == 1 && !kinds,
      kinds ? "with -kinds, ranges are gaps: -pair_gap_switch, -pair_gap_cutoff" : reason);
  OptionSection gap(read.options, topic, ranged.size() == 1, reason);
  auto place = [&](const char* name, const char* gapName, int lengths,
                   const char* what) -> std::optional<double> {
    const std::string shown = format("2 rf + %d lambda", lengths),
                      shownGap = format("%d lambda", lengths);
    const auto whole = distance.maybeReal(name, shown.c_str(), unit, what, positive);
    const auto part =
        gap.maybeReal(gapName, shownGap.c_str(), unit,
                      format("the same as a gap between surfaces: %s", what).c_str(), positive);
    if (whole && part) throw InputError(format("-%s, -%s: give one of the two", name, gapName));
    const auto distance = whole ? whole : part ? std::optional(read.touch() + *part) : std::nullopt;
    requireRange(distance, read, whole ? name : gapName);
    return distance;
  };
  GivenRange range;
  range.from = place("pair_switch", "pair_gap_switch", 4, "distance where the switch-off begins");
  range.to = place("pair_cutoff", "pair_gap_cutoff", 6, "distance where pair forces end");
  return range;
}

void readVdwRange(const PairReader& read, const GivenRange& common, VdwParameters& p) {
  const GivenRange given = readOwnRange(read, "vdw", common, {"4 lambda", "6 lambda"});
  p.switchFrom = given.from.value_or(read.touch() + 4.0 * p.length);
  p.cutoff = given.to.value_or(read.touch() + 6.0 * p.length);
  const double least = 1e-3 * p.length;
  if (const double gap = restOf(p) * p.length - read.touch(); read.is("vdw") && !(gap > least))
    throw InputError(format(
        "-vdw_a, -vdw_b, -vdw_alpha, -vdw_beta: surfaces would rest %.3g %s from each other; "
        "at least %.3g",
        gap, read.units.length, least));
  if (read.accuracy && !read.mixed() && read.is("vdw") && !given.from && !given.to)
    setRangeByAccuracy(*read.accuracy, restOf(p) * p.length, p);
  if (read.is("vdw") && p.cutoff <= p.switchFrom)
    throw InputError(
        !read.a.kind.empty()
            ? format("%s %g: must lie beyond %s %g", read.option("pair_gap_cutoff").c_str(),
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

double readHertz(const PairReader& read, double usual) {
  OptionSection s = read.of("hertz");
  const std::string unit = std::string(read.units.energy) + "/" + read.units.length + "^2.5";
  return s.real("hertz_stiffness", usual, unit.c_str(),
                "K of u = K (2 rf - r)^2.5 of two lengths of 2 rf; from -fibre_transverse_young "
                "where that is known",
                positive);
}

/// `accuracy`: between two kinds that of both; within one it becomes what is read.
void readAccuracy(PairReader& read, std::optional<double>& accuracy) {
  OptionSection s(read.options, topic,
                  !read.mixed() && (read.is("hertz") || !rangedLaws(read).empty()),
                  read.mixed() ? "between kinds the points follow from the laws' widths"
                               : "-pair is " + read.laws());
  const auto given = s.maybeReal(
      "pair_accuracy", "none", "",
      "largest rms error of forces in a bundle and at a crossing, over their rms; chooses "
      "-pair_points, far points and the range of vdw (between kinds they follow from the laws' "
      "widths)",
      {1e-6, 1.0});
  if (!read.mixed()) accuracy = given;
  read.accuracy = accuracy;
}

/// Up to this distance of axes over their gap, both at rest, single precision is taken for exact
/// enough where fibres are pressed, too; a (10,10) tube has 4.6, and mwcnt_100_50 with 54 an error
/// of 1e-4 of the energy.
constexpr double mostOverGap = 30;

/// `rest`: distance of axes at rest by the law vdw.
PairChoice readChoice(const PairReader& read, double rest) {
  OptionSection s(read.options, topic, !read.is("none"), "-pair is none");
  PairChoice choice;
  choice.length = {read.a.length, read.b.length};
  OptionSection ofVdw = read.of("vdw");
  // Its error is a millionth, the least accuracy that may be asked for, unless the repulsion of
  // fibres far thicker than their gap begins on a steep part of the table.
  const bool enough = read.accuracy && !read.mixed() && read.is("vdw") && singlePrecisionPays() &&
                      rest <= mostOverGap * (rest - read.touch());
  choice.single =
      ofVdw.choice(
          "pair_precision", enough ? "single" : "double", {"double", "single"},
          "of the law's values and of their sums over a pair's points, in double always for "
          "more than 9 points and between segments of different lengths; with -pair_accuracy "
          "single where the build is for AVX-512 and fibres are at most 30 times as far apart as "
          "their surfaces") == "single";
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
PairTraits traitsOf(const PairReader& read, const Law& law, double restDistance,
                    const LawWidth& width, const std::string& description) {
  return {description,
          law.cutoff(),
          restDistance,
          law.closestSensible(),
          {read.a.radius, read.b.radius},
          law.contactStiffness(),
          law.largestForce(),
          width};
}

/// `lost`: share of a bundle's cohesion.
std::unique_ptr<PairForce> makeVdw(const PairReader& read, const VdwParameters& p, double rest,
                                   double lost, const PairChoice& choice) {
  const Vdw law(p.of(choice.length, unequalRadii(read.a.radius, read.b.radius)));
  if (choice.single && !read.accuracy && read.a.kind.empty() &&
      !compiled(choice.points.near, choice.length))
    throw InputError(
        format("-pair_precision single: has no effect with %d points a segment; at most %d have it "
               "(-pair_points)",
               choice.points.near.i, mostCompiledPoints));
  if (law.spliceDistance() >= p.switchFrom || law.restDistance() >= p.switchFrom)
    throw InputError(read.prefix.empty()
                         ? format("-pair_switch %g: must lie beyond the resting distance %g %s",
                                  p.switchFrom, law.restDistance(), read.units.length)
                         : format("%s %g: must lie beyond the gap at rest, %g %s",
                                  read.option("pair_gap_switch").c_str(),
                                  p.switchFrom - read.touch(), law.restDistance() - read.touch(),
                                  read.units.length));
  const char *length = read.units.length, *energy = read.units.energy;
  if (const double least = Vdw(p).leastStiffness(); p.smooth && p.stiffness < least)
    throw InputError(format(
        "%s %g: softer than the law itself where fibres rest, so its repulsion would replace "
        "the well; take %.4g %s/%s^2 at least, or %s kink",
        read.option("vdw_stiffness").c_str(), p.stiffness, least, energy, length,
        read.option("vdw_splice").c_str()));
  const std::string taken =
      read.mixed() ? "" : format(", which takes %.2g %% of a bundle's cohesion", 100 * lost);
  const std::string description = format(
      "vdw %s, eps %.5g %s, A %g, B %g, alpha %g, beta %g, lambda %.4g %s, k %.4g %s/%s^2, "
      "rest distance %.6g %s, range %.6g to %.6g %s%s%s",
      p.smooth ? "smooth" : "kink", p.epsilon, energy, p.a, p.b, p.alpha, p.beta, p.length, length,
      p.stiffness, energy, length, rest, length, p.switchFrom, p.cutoff, length, taken.c_str(),
      choice.single && compiled(choice.points.near, choice.length) ? ", single precision" : "");
  const LawWidth width{lawWidth(rest, read.a, read.b), nearSpacing};
  return makePairForce(law.table(), traitsOf(read, law, rest, width, description), choice);
}

std::unique_ptr<PairForce> makeHertz(const PairReader& read, double stiffness,
                                     const PairChoice& choice) {
  const double lengths =
      (choice.length.i / read.a.diameter()) * (choice.length.j / read.b.diameter());
  const Hertz law(stiffness * lengths, 0.5 * read.touch());
  const LawWidth width{lawWidth(read.touch(), read.a, read.b), softSpacing};
  return makePairForce(
      law,
      traitsOf(read, law, read.touch(), width,
               format("hertz, K %.5g %s/%s^2.5, range %.6g %s", stiffness, read.units.energy,
                      read.units.length, read.touch(), read.units.length)),
      choice);
}

std::unique_ptr<PairForce> makeSurface(const PairReader& read, const ReadSurfaceLaw& found,
                                       const PairChoice& choice) {
  PairTraits traits =
      traitsOf(read, found.law, found.need.rest, found.need.width, found.description);
  traits.keepsApart = found.law.keepsApart();
  return makePairForce(found.law.table(), traits, choice);
}

/// Reads which laws hold, in the order of the table of names.
void readChosen(PairReader& read, std::vector<std::string>& laws) {
  std::vector<std::string> names{"vdw", "hertz"};
  for (const SurfaceLawType& type : surfaceLaws()) names.push_back(type.name);
  names.insert(names.end(), {"contact", "none"});
  OptionSection pair(read.options, topic);
  const auto given = pair.choices(
      "pair", laws, names,
      "law of the forces between fibres, unless given that of the preset; several, with commas "
      "between, add");
  if (given == undecided)
    throw InputError(format("kinds %s and %s have different pair laws: give %s",
                            read.a.kind.c_str(), read.b.kind.c_str(), read.option("pair").c_str()));
  for (const std::string& name : names)
    if (std::ranges::find(given, name) != given.end()) read.chosen.push_back(name);
  if (read.is("none") && given.size() > 1)
    throw InputError(
        format("%s %s: none stands alone", read.option("pair").c_str(), read.laws().c_str()));
  laws = read.chosen;
}

/// A law's force with the points that options say, or that keep the accuracy asked for.
using MakeForce = std::function<std::unique_ptr<PairForce>(const PairChoice&)>;
std::unique_ptr<PairForce> makeWithPoints(const PairReader& read, const PointNeed& need,
                                          PairChoice choice, const MakeForce& make) {
  if (read.accuracy && !read.mixed())
    choice.points = pointsByAccuracy(*read.accuracy, read.a, need.rest, need.switchFrom,
                                     [&](const PointChoice& points) {
                                       PairChoice tried = choice;
                                       tried.points = points;
                                       return make(tried);
                                     });
  return make(choice);
}

/// Reads all that concerns two kinds, with the law's defaults between them; `law` gets what holds.
/// The pair forces of all laws.
std::vector<std::unique_ptr<PairForce>> readOne(PairReader& read, OwnLaw& law) {
  readChosen(read, law.chosen);
  readAccuracy(read, law.accuracy);
  VdwParameters vdw = readVdw(read, law.vdw);
  PairChoice choice = readChoice(read, restOf(vdw) * vdw.length);
  const GivenRange range = readRange(read);
  readVdwRange(read, range, vdw);
  law.vdw = vdw;
  law.hertz = readHertz(read, law.hertz);
  std::vector<ReadSurfaceLaw> surfaces;
  for (const SurfaceLawType& type : surfaceLaws())
    if (auto found = readSurfaceLaw(read, type, range, law.surface))
      surfaces.push_back(std::move(*found));
  std::vector<std::unique_ptr<PairForce>> forces;
  auto keep = [&](const PointNeed& need, const PairChoice& with, const MakeForce& make) {
    forces.push_back(makeWithPoints(read, need, with, make));
  };
  if (read.is("vdw")) {
    const double rest = restOf(vdw) * vdw.length;
    const PointNeed need{rest, {lawWidth(rest, read.a, read.b), nearSpacing}, vdw.switchFrom};
    choice.points = readPoints(read, need);
    const double lost = cohesionLost(vdw, rest);
    keep(need, choice, [&](const PairChoice& c) { return makeVdw(read, vdw, rest, lost, c); });
  }
  const PointNeed soft{read.touch(), {lawWidth(read.touch(), read.a, read.b), softSpacing}};
  choice.points = read.is("vdw") ? nearPoints(read, soft) : readPoints(read, soft);
  PairChoice inDoubles = choice;
  inDoubles.single = false;
  if (read.is("hertz"))
    keep(soft, inDoubles, [&](const PairChoice& c) { return makeHertz(read, law.hertz, c); });
  for (const ReadSurfaceLaw& found : surfaces) {
    inDoubles.points = nearPoints(read, found.need);
    keep(found.need, inDoubles, [&](const PairChoice& c) { return makeSurface(read, found, c); });
  }
  if (auto contact = readContact(read, choice, law.friction)) forces.push_back(std::move(contact));
  return forces;
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
  const std::vector<std::string> none{"none"};
  law.chosen = ofA.chosen == ofB.chosen                   ? ofA.chosen
               : ofA.chosen == none || ofB.chosen == none ? none
                                                          : undecided;
  if (ofA.accuracy && ofB.accuracy) law.accuracy = ofA.accuracy;
  law.vdw = meanOf(ofA.vdw, ofB.vdw);
  law.hertz = hertzBetween(one, other, units);
  law.surface = surfaceValuesBetween(ofA.surface, ofB.surface);
  law.friction.mu = common(ofA.friction.mu, ofB.friction.mu);
  law.friction.tangential = common(ofA.friction.tangential, ofB.friction.tangential);
  law.friction.restitution = common(ofA.friction.restitution, ofB.friction.restitution);
  return law;
}

}  // namespace

void requireRange(const std::optional<double>& distance, const PairReader& read,
                  const std::string& name) {
  if (const double most = 1e9 * read.touch(); distance && *distance > most)
    throw InputError(format("-%s: forces that reach to %g %s; at most %g", name.c_str(), *distance,
                            read.units.length, most));
}

double usualRestDistance(const Fibre& a, const Fibre& b, const UnitSystem& units) {
  if (a.law != "vdw" || b.law != "vdw") return a.radius + b.radius;
  VdwParameters p = usualVdw(units);
  p.radius = 0.5 * (a.radius + b.radius);
  return restOf(p) * p.length;
}

PairForces readPairForces(Options& options, const UnitSystem& units, const Kinds& kinds) {
  std::vector<PairForces::Class> classes;
  auto keep = [&](int first, int second, std::vector<std::unique_ptr<PairForce>> forces) {
    for (auto& force : forces) classes.push_back({first, second, std::move(force)});
  };
  std::vector<OwnLaw> own;
  for (int k = 0; k < kinds.count(); ++k) {
    const Fibre& f = kinds[k];
    const std::string name = f.kind.empty() ? "" : f.kind + "_" + f.kind;
    const OptionPrefix prefix(options, name);
    PairReader read{options, units, f, f, name.empty() ? "" : name + "_", {}};
    own.push_back({{f.law}, usualVdw(units), usualHertz(f, units), {}, {}, {}});
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
      PairReader read{options, units, kinds[first], kinds[second], name + "_", {}};
      keep(first, second, readOne(read, law));
    }
  return PairForces(std::move(classes));
}

}  // namespace nanoweft
