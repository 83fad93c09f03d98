/// The options of the surface laws.
#include <cmath>
#include <limits>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/pair_reader.hpp"
#include "nanoweft/force/quadrature.hpp"

namespace nanoweft {

namespace {

using Type = SurfaceLawType;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
/// Without -..._switch, the last part of the range in which a law is switched off.
constexpr double usualSwitch = 0.7;

std::string unitOf(const Type::Parameter& p, const UnitSystem& units) {
  if (p.energy == 0 && p.length == 0) return "rad";
  const std::string energy = p.energy ? units.energy : "",
                    power = std::abs(p.length) == 1 ? "" : format("^%d", std::abs(p.length));
  if (p.length == 0) return energy;
  return energy + (p.length < 0 ? "/" : "") + units.length + power;
}

double between(Type::Rule rule, double x, double y) {
  if (x == y) return x;
  if (rule == Type::equal) return unknown;
  return rule == Type::geometric ? std::sqrt(x) * std::sqrt(y) : 0.5 * (x + y);
}

/// With defaults for what no option says, where the law has some.
Type::Values completed(const Type& type, const Type::Values& given) {
  Type::Values all;
  for (std::size_t k = 0; k < given.size(); ++k) {
    const auto fallback = type.parameters[k].fallback;
    all.push_back(std::isnan(given[k]) && fallback ? fallback(all) : given[k]);
  }
  return all;
}

/// The values that hold, where an option, the default of a law or that between kinds says them.
Type::Values readValues(const PairReader& read, const Type& type, Type::Values& values) {
  OptionSection section = read.of(type.name);
  values.resize(type.parameters.size(), unknown);
  Type::Values complete;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const Type::Parameter& p = type.parameters[k];
    const std::string unit = unitOf(p, read.units);
    const Bounds bounds{0.0, p.most, std::isinf(p.most)};
    if (const auto given = section.maybeReal(p.name, p.shown, unit.c_str(), p.help, bounds))
      values[k] = *given;
    // Where two kinds have two values that must be equal, neither holds, nor any other.
    const bool usual =
        std::isnan(values[k]) && p.fallback && !(read.mixed() && p.rule == Type::equal);
    complete.push_back(usual ? p.fallback(complete) : values[k]);
    if (read.is(type.name) && std::isnan(complete[k]))
      throw InputError(format("%s: the law %s needs it: the %s, in %s", read.option(p.name).c_str(),
                              type.name, p.help, unit.c_str()));
  }
  return complete;
}

Switch rangeOf(const PairReader& read, const Type& type, const GivenRange& given,
               const Type::Values& values) {
  Switch range;
  if (given.to)
    range.to = *given.to - read.touch();
  else if (type.usualCutoff)
    range.to = type.usualCutoff(values);
  else
    throw InputError(format(
        "%s: the law %s needs it: the gap in %s where its forces end, 10 times "
        "the gap at rest or more",
        read.option(std::string(type.name) + "_gap_cutoff").c_str(), type.name, read.units.length));
  range.from = given.from ? *given.from - read.touch() : usualSwitch * range.to;
  return range;
}

std::string describe(const PairReader& read, const Type& type, const Type::Values& values,
                     const Switch& range) {
  std::string text = type.name;
  const std::size_t own = std::string(type.name).size() + 1;
  for (std::size_t k = 0; k < values.size(); ++k)
    text += format(", %s %.5g %s", type.parameters[k].name + own, values[k],
                   unitOf(type.parameters[k], read.units).c_str());
  return text + format(", range %.6g to %.6g %s of gap", range.from, range.to, read.units.length);
}

}  // namespace

SurfaceValues surfaceValuesBetween(const SurfaceValues& a, const SurfaceValues& b) {
  SurfaceValues values;
  for (const Type& type : surfaceLaws()) {
    const Type::Values ofA = completed(type, a.at(type.name)),
                       ofB = completed(type, b.at(type.name));
    for (std::size_t k = 0; k < type.parameters.size(); ++k) {
      const Type::Parameter& p = type.parameters[k];
      // A stiffness that follows from the law within a kind does so between two kinds, too.
      const bool follows = p.rule == Type::geometric && p.fallback &&
                           (std::isnan(a.at(type.name)[k]) || std::isnan(b.at(type.name)[k]));
      values[type.name].push_back(follows ? unknown : between(p.rule, ofA[k], ofB[k]));
    }
  }
  return values;
}

GivenRange readOwnRange(const PairReader& read, const std::string& law, const GivenRange& common,
                        Both<const char*> shown) {
  OptionSection section = read.of(law);
  auto place = [&](const char* end, const char* usual, const std::optional<double>& all,
                   const std::string& help) {
    const std::string name = law + "_gap_" + end, whole = std::string("pair_gap_") + end;
    const auto gap = section.maybeReal(name, usual, read.units.length, help.c_str(), positive);
    if (gap && all)
      throw InputError(format("%s, %s: give one of the two", read.option(name).c_str(),
                              read.option(whole).c_str()));
    if (gap) requireRange(read.touch() + *gap, read, name);
    return gap ? read.touch() + *gap : all;
  };
  GivenRange range;
  range.from =
      place("switch", shown.i, common.from,
            "gap where the switch-off of " + law + " begins, where several laws have ranges");
  range.to = place("cutoff", shown.j, common.to, "gap where the forces of " + law + " end");
  return range;
}

std::optional<ReadSurfaceLaw> readSurfaceLaw(const PairReader& read, const SurfaceLawType& type,
                                             const GivenRange& common, SurfaceValues& values) {
  const Type::Values v = readValues(read, type, values[type.name]);
  const GivenRange given =
      readOwnRange(read, type.name, common, {"0.7 of the end", type.shownCutoff});
  if (!read.is(type.name)) return std::nullopt;
  const Switch range = rangeOf(read, type, given, v);
  const double ra = read.a.radius, rb = read.b.radius;
  const SurfaceProfile profile = type.profile(v, ra == rb ? ra : std::sqrt(ra * rb), range);
  if (!(range.from > profile.rest && range.to > range.from))
    throw InputError(
        format("%s: the law %s would be switched off from a gap of %g to %g %s; these "
               "must rise, and lie beyond the gap at rest, %g",
               read.option(std::string(type.name) + "_gap_cutoff").c_str(), type.name, range.from,
               range.to, read.units.length, profile.rest));
  const SurfaceLaw law(profile, range, read.touch(), read.a.length * read.b.length);
  return ReadSurfaceLaw{
      law, describe(read, type, v, range), {law.restDistance(), {profile.width, surfaceSpacing}}};
}

}  // namespace nanoweft
