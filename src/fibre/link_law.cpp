#include "nanoweft/fibre/link_law.hpp"

#include <algorithm>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr const char* title = "Links";
constexpr const char* noLinks = "the state has no links (/link, or -links_density)";

LinkLaw readLinkLaw(Options& options, const UnitSystem& units, const Kinds& kinds, bool inFile) {
  LinkLaw law;
  OptionSection made(options, title);
  const std::string perLength = std::string("1/") + units.length;
  law.density = made.real("links_density", 0.0, perLength.c_str(),
                          "links to be made at the start, per length of fibre, at random places "
                          "where fibres are closer than -links_distance",
                          nonNegative);
  OptionSection places(options, title, law.density > 0, "there is no -links_density");
  const auto distance =
      places.maybeReal("links_distance", "none", units.length,
                       "distance of two axes up to which -links_density ties them", positive);
  if (law.density > 0 && !distance) throw InputError("-links_density: needs -links_distance");
  law.distance = distance.value_or(0.0);
  const bool linked = inFile || law.density > 0;
  OptionSection s(options, title, linked, noLinks);
  law.bond = kinds[0].bond;
  law.spring = s.choice("link_law", "bond", {"bond", "spring"},
                        "an EVM bond, or a spring whose ends are free to turn") == "spring";
  const std::string perArea = std::string(units.energy) + "/" + units.length + "^2";
  OptionSection spring(options, title, linked && law.spring,
                       linked ? "-link_law is bond" : noLinks);
  law.bond.stretch = spring
                         .maybeReal("link_stretch", "B1 of the first kind", perArea.c_str(),
                                    "stiffness of a spring", positive)
                         .value_or(law.bond.stretch);
  OptionSection bond(options, title, linked && !law.spring,
                     linked ? "-link_law is spring" : noLinks);
  const std::string unit = perArea + "," + units.energy + "," + units.energy + "," + units.energy;
  if (const auto b = bond.reals("link_stiffness", 4, "of the bonds of the first kind", unit.c_str(),
                                "stiffnesses B1,B2,B3,B4 of an EVM link")) {
    law.bond.stretch = (*b)[0], law.bond.shear = (*b)[1];
    law.bond.bending = (*b)[2], law.bond.torsion = (*b)[3];
    if (!((*b)[0] > 0 && (*b)[1] > 0 && (*b)[3] > 0 &&
          0.25 * (*b)[1] + (*b)[2] + 0.5 * (*b)[3] > 0))
      throw InputError(
          "-link_stiffness: needs B1, B2, B4 and B2/4 + B3 + B4/2 all positive, or the link is "
          "unstable at rest");
  }
  law.breakStrain = s.maybeReal("link_break_strain", "none", "",
                                "a link breaks when it is longer by this strain", positive)
                        .value_or(law.breakStrain);
  law.breakForce = s.maybeReal("link_break_force", "none", units.force,
                               "a link breaks when its force is larger than this", positive)
                       .value_or(law.breakForce);
  return law;
}

}  // namespace

std::vector<std::string> namesOf(const LinkLaws& laws) {
  std::vector<std::string> names;
  for (const LinkLaw& law : laws) names.push_back(law.kind);
  return names;
}

LinkLaws readLinkLaws(Options& options, const UnitSystem& units, const Kinds& kinds, bool inFile) {
  OptionSection s(options, title);
  const auto names = s.words("link_kinds",
                             "names of the kinds of links, where there are several: -link_... and "
                             "-links_... of a kind are -KIND_link_... and -KIND_links_...; without "
                             "prefix they are meant for all");
  if (names.empty()) return {readLinkLaw(options, units, kinds, inFile)};
  checkPrefixes("-link_kinds", "a kind of link", names);
  LinkLaws laws;
  for (const std::string& name : names) {
    const OptionPrefix prefix(options, name);
    try {
      laws.push_back(readLinkLaw(options, units, kinds, inFile));
    } catch (const InputError& problem) {
      throw InputError("links " + name + ": " + problem.what());
    }
    laws.back().kind = name;
  }
  if (!inFile && std::ranges::none_of(laws, [](const LinkLaw& law) { return law.density > 0; }))
    throw InputError(std::string("-link_kinds is not used by this run: ") + noLinks);
  return laws;
}

}  // namespace nanoweft
