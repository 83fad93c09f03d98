#include "nanoweft/fibre/material.hpp"

#include <numbers>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

using std::numbers::pi;

double Fibre::crossSection() const {
  return wall > 0 ? 2.0 * pi * wall * radius : pi * radius * radius;
}

double Fibre::secondMoment() const {
  const double r2 = radius * radius;
  return wall > 0 ? pi * wall * radius * (r2 + 0.25 * wall * wall) : 0.25 * pi * r2 * r2;
}

void Fibre::derive() {
  const double bend = bendingRigidity() / length, twist = torsionalRigidity() / length;
  inertia = (wall > 0 ? 1.0 : 0.5) * mass * radius * radius;
  bond = {length, young * crossSection() / length, 12.0 * bend, -2.0 * bend - 0.5 * twist, twist};
}

Fibre cnt1010(const UnitSystem& units) {
  const bool si = units.name == "si";
  const double angstrom = si ? 1e-10 : 1.0;
  Fibre f;
  f.radius = 6.78 * angstrom;
  f.wall = 3.35 * angstrom;
  f.length = 13.56 * angstrom;
  f.young = 1029.0 * units.gigapascal;
  f.shear = 459.0 * units.gigapascal;
  f.mass = 2649.0 * (si ? codata::atomicMass : units.mass);
  f.derive();
  return f;
}

namespace {

/// A PAN-based carbon fibre such as T300: solid, 7 um thick, 230 GPa, 1760 kg/m^3 (the maker's data
/// sheet, Toray T300); the shear modulus is that along the fibre's axis, about 15 GPa.
Fibre carbonT300(const UnitSystem& units) {
  const double metre = units.name == "si" ? 1.0 : 1e10;
  Fibre f;
  f.radius = 3.5e-6 * metre;
  f.wall = 0;
  f.length = 2.0 * f.radius;
  f.young = 230.0 * units.gigapascal;
  f.shear = 15.0 * units.gigapascal;
  const double kilograms = 1760.0 * pi * 3.5e-6 * 3.5e-6 * 7e-6;
  f.mass = units.name == "si" ? kilograms : kilograms / codata::atomicMass * units.mass;
  f.derive();
  return f;
}

}  // namespace

Fibre readFibre(Options& options, const UnitSystem& units) {
  OptionSection s(options, "Fibre");
  const std::string preset = s.choice("fibre_preset", "cnt_10_10", {"cnt_10_10", "carbon_t300"},
                                      "material and cross-section to start from");
  Fibre f = preset == "carbon_t300" ? carbonT300(units) : cnt1010(units);
  const char* fromPreset = "of the preset";
  const double massPerLength = f.mass / f.length;
  f.radius = s.maybeReal("fibre_radius", fromPreset, units.length, "radius rf", positive)
                 .value_or(f.radius);
  f.wall = s.maybeReal("fibre_wall", fromPreset, units.length,
                       "wall of a thin-walled tube; 0: a solid round fibre", nonNegative)
               .value_or(f.wall);
  if (auto e = s.maybeReal("fibre_young", fromPreset, "GPa", "Young's modulus E", positive))
    f.young = *e * units.gigapascal;
  if (auto g = s.maybeReal("fibre_shear", fromPreset, "GPa", "shear modulus G", positive))
    f.shear = *g * units.gigapascal;
  const auto length = s.maybeReal("fibre_segment_length", "2 rf of the preset", units.length,
                                  "length T of a segment = rest length of a bond", positive);
  if (length)
    f.length = *length;
  else if (s.given("fibre_radius"))
    f.length = 2.0 * f.radius;
  f.mass = massPerLength * f.length;
  if (auto m = s.maybeReal("fibre_segment_mass", "of the preset, scaled with T", units.massName,
                           "mass of a segment", positive))
    f.mass = *m * units.mass;
  if (2.0 * f.radius < f.wall)
    throw InputError(
        format("-fibre_wall %g: thicker than the fibre (radius %g)", f.wall, f.radius));
  f.derive();
  if (auto inertia = s.maybeReal("fibre_segment_inertia", "m rf^2 (tube), m rf^2/2 (solid)",
                                 (std::string(units.massName) + " " + units.length + "^2").c_str(),
                                 "moment of inertia of a segment, equal about all axes", positive))
    f.inertia = *inertia * units.mass;
  const std::string stiffnessUnit = format("%s/%s^2,%s,%s,%s", units.energy, units.length,
                                           units.energy, units.energy, units.energy);
  if (auto b = s.reals("fibre_bond_stiffness", 4, "from E, G and the cross-section",
                       stiffnessUnit.c_str(), "bond stiffnesses B1,B2,B3,B4 as they are")) {
    f.bond = {f.length, (*b)[0], (*b)[1], (*b)[2], (*b)[3]};
    // Positive definite: stretching, both bending modes and twisting cost energy.
    const double antisymmetric = 0.25 * (*b)[1] + (*b)[2] + 0.5 * (*b)[3];
    if (!((*b)[0] > 0 && (*b)[1] > 0 && antisymmetric > 0 && (*b)[3] > 0))
      throw InputError(
          "-fibre_bond_stiffness: needs B1, B2, B4 and B2/4 + B3 + B4/2 all positive, or the bond "
          "is "
          "unstable at rest");
  }
  return f;
}

}  // namespace nanoweft
