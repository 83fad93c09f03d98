#include "nanoweft/fibre/link_law.hpp"

#include "nanoweft/base/error.hpp"

namespace nanoweft {

LinkLaw readLinkLaw(Options& options, const UnitSystem& units, const Kinds& kinds, bool inFile) {
  const char* title = "Links";
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
  const std::string none = "the state has no links (/link, or -links_density)";
  OptionSection s(options, title, linked, none);
  law.bond = kinds[0].bond;
  law.spring = s.choice("link_law", "bond", {"bond", "spring"},
                        "an EVM bond, or a spring whose ends are free to turn") == "spring";
  const std::string perArea = std::string(units.energy) + "/" + units.length + "^2";
  OptionSection spring(options, title, linked && law.spring, linked ? "-link_law is bond" : none);
  law.bond.stretch = spring
                         .maybeReal("link_stretch", "B1 of the first kind", perArea.c_str(),
                                    "stiffness of a spring", positive)
                         .value_or(law.bond.stretch);
  OptionSection bond(options, title, linked && !law.spring, linked ? "-link_law is spring" : none);
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

}  // namespace nanoweft
