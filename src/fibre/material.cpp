#include "nanoweft/fibre/material.hpp"

#include <algorithm>
#include <numbers>
#include <vector>

#include "nanoweft/base/error.hpp"
#include "nanoweft/fibre/presets.hpp"

namespace nanoweft {

using std::numbers::pi;

double Fibre::crossSection() const {
  return wall > 0 ? 2.0 * pi * wall * middleRadius() : pi * radius * radius;
}

double Fibre::secondMoment() const {
  const double r = middleRadius(), r2 = r * r;
  return wall > 0 ? pi * wall * r * (r2 + 0.25 * wall * wall) : 0.25 * pi * r2 * r2;
}

void Fibre::derive() {
  const double bend = bendingRigidity() / length, twist = torsionalRigidity() / length;
  inertia = middle > 0 ? mass * (middle * middle + 0.25 * wall * wall)
                       : (wall > 0 ? 1.0 : 0.5) * mass * radius * radius;
  bond = {length, young * crossSection() / length, 12.0 * bend, -2.0 * bend - 0.5 * twist, twist};
}

namespace {

std::vector<double> whatTheStepDependsOn(const Fibre& f) {
  return {f.radius,       f.length,     f.mass,         f.inertia,
          f.bond.stretch, f.bond.shear, f.bond.bending, f.bond.torsion};
}

/// Reads what the preset's cross-section and moduli are replaced by.
void readSection(Options& options, OptionSection& s, const UnitSystem& units, Fibre& f) {
  const char* fromPreset = "of the preset";
  f.radius = s.maybeReal("fibre_radius", fromPreset, units.length, "radius rf", positive)
                 .value_or(f.radius);
  f.wall = s.maybeReal("fibre_wall", fromPreset, units.length,
                       "wall of a thin-walled tube; 0: a solid round fibre", nonNegative)
               .value_or(f.wall);
  if (f.diameter() < f.wall)
    throw InputError(
        format("-fibre_wall %g: thicker than the fibre (radius %g)", f.wall, f.radius));
  f.elastic = !s.given("fibre_bond_stiffness");
  OptionSection elastic(options, "Fibre", f.elastic,
                        "-fibre_bond_stiffness gives a bond's stiffnesses");
  if (auto e = elastic.maybeReal("fibre_young", fromPreset, "GPa", "Young's modulus E", positive))
    f.young = *e * units.gigapascal;
  if (auto g = elastic.maybeReal("fibre_shear", fromPreset, "GPa", "shear modulus G", positive))
    f.shear = *g * units.gigapascal;
  if (auto e = s.maybeReal("fibre_transverse_young", fromPreset, "GPa",
                           "Young's modulus across the axis, for contacts", positive))
    f.transverse = *e * units.gigapascal;
  f.poisson = s.maybeReal("fibre_poisson", "of the preset, or 0.3", "",
                          "Poisson's ratio across the axis, for contacts", {-0.999, 0.5})
                  .value_or(f.poisson);
}

/// Reads length and mass of a segment; `preset` as it was before readSection.
void readSegment(OptionSection& s, const UnitSystem& units, const Fibre& preset, Fibre& f) {
  const auto length = s.maybeReal("fibre_segment_length", "2 rf", units.length,
                                  "length T of a segment = rest length of a bond", positive);
  f.length = length ? *length : f.radius == preset.radius ? preset.length : f.diameter();
  const auto density = s.maybeReal("fibre_density", "of the preset", "kg/m^3",
                                   "mass over the cross-section's volume", positive);
  const auto mass = s.maybeReal("fibre_segment_mass", "from the density", units.massName,
                                "mass of a segment", positive);
  if (density && mass) throw InputError("-fibre_density, -fibre_segment_mass: give one of the two");
  f.mass = preset.mass / preset.length * f.length;
  if (density) f.mass = *density * units.kilogramPerCubicMetre * f.crossSection() * f.length;
  if (mass) f.mass = *mass * units.mass;
  if (density || mass || (f.radius == preset.radius && f.wall == preset.wall)) return;
  const double asPreset = preset.density();
  throw InputError(format(
      "%s %g changes the cross-section of the preset %s: give -fibre_density %.5g (kg/m^3, that of "
      "the preset) or -fibre_segment_mass %.6g (%s, by that density)",
      f.radius != preset.radius ? "-fibre_radius" : "-fibre_wall",
      f.radius != preset.radius ? f.radius : f.wall, f.preset.c_str(),
      asPreset / units.kilogramPerCubicMetre, asPreset * f.crossSection() * f.length / units.mass,
      units.massName));
}

void readRestShape(OptionSection& s, const UnitSystem& units, Fibre& f) {
  const std::string perLength = std::string("1/") + units.length;
  f.rest.x =
      s.real("fibre_rest_twist", 0.0, perLength.c_str(), "twist of the fibre at rest, per length");
  if (const auto k = s.reals("fibre_rest_curvature", 2, "0,0", perLength.c_str(),
                             "curvature of the fibre at rest about its second and third body axis"))
    f.rest.y = (*k)[0], f.rest.z = (*k)[1];
  if (const double turn = norm(f.restRotation()); turn > 0.5)
    throw InputError(format(
        "-fibre_rest_curvature, -fibre_rest_twist: neighbours would be turned by %.3g rad at "
        "rest; at most 0.5, by a shorter -fibre_segment_length",
        turn));
}

void readKink(Options& options, OptionSection& s, const UnitSystem& units, Fibre& f) {
  const std::string perLength = std::string("1/") + units.length;
  const auto curvature = s.maybeReal(
      "fibre_kink_curvature", "none", perLength.c_str(),
      "curvature at which the fibre kinks: beyond it the bending moment grows no more", positive);
  OptionSection kinks(options, "Fibre", curvature.has_value(), "-fibre_kink_curvature is not set");
  const double residual =
      kinks.real("fibre_kink_stiffness", 0.0, "",
                 "bending stiffness of a kink over that of the fibre", {0.0, 1.0});
  if (!curvature) return;
  const double angle = *curvature * f.length;
  if (angle > 3.0)
    throw InputError(
        format("-fibre_kink_curvature %g: a bond of %g %s would bend by %.3g rad before "
               "it kinks; at most 3",
               *curvature, f.length, units.length, angle));
  // |e1_i - e1_j| of two axes that are turned by it.
  f.kink.angle = 2.0 * std::sin(0.5 * angle);
  f.kink.taken = (1.0 - residual) * f.bendingOfBond();
}

/// What -fibre_retardation gives the bond's four stiffnesses. Bending has that of both ends turned
/// against each other.
void readViscosity(OptionSection& s, const UnitSystem& units, Fibre& f) {
  const auto all = s.maybeReal("fibre_retardation", "none", units.time,
                               "internal viscosity: each stiffness of a bond has a dashpot of this "
                               "retardation time beside it",
                               nonNegative);
  const auto each = s.reals("fibre_retardation_each", 4, "none", units.time,
                            "the same, a time for each of stretch, shear, bending, torsion");
  if (all && each)
    throw InputError("-fibre_retardation, -fibre_retardation_each: give one of the two");
  const double t = all.value_or(0.0);
  const std::vector<double> times = each.value_or(std::vector<double>{t, t, t, t});
  for (const double time : times)
    if (!(time >= 0))
      throw InputError(
          format("-fibre_retardation_each: a time is %g; it must not be negative", time));
  f.retardation = std::ranges::max(times);
  f.viscosity = {times[0] * f.bond.stretch, times[1] * f.bond.shear, times[2] * f.bendingOfBond(),
                 times[3] * f.bond.torsion};
}

void readYield(OptionSection& s, const UnitSystem& units, Fibre& f) {
  const std::string perLength = std::string("1/") + units.length;
  if (const auto strain =
          s.maybeReal("fibre_yield_strain", "none", "",
                      "elastic strain beyond which the fibre flows plastically", positive))
    f.yield.stretch = *strain * f.length;
  const auto curvature =
      s.maybeReal("fibre_yield_curvature", "none", perLength.c_str(),
                  "elastic curvature beyond which the fibre flows plastically", positive);
  if (curvature) f.yield.angle = *curvature * f.length;
  if (curvature && f.kinks() && *curvature * f.length <= 2.0 * std::asin(0.5 * f.kink.angle))
    throw InputError(
        format("-fibre_yield_curvature %g: the fibre flows before it would kink; it must be above "
               "-fibre_kink_curvature, or that be left out",
               *curvature));
}

}  // namespace

Fibre readFibre(Options& options, const UnitSystem& units) {
  OptionSection s(options, "Fibre");
  const std::string help = "material and cross-section to start from: " + presetNames();
  const Fibre preset = presetFibre(s.text("fibre_preset", "cnt_10_10", help.c_str()), units);
  Fibre f = preset;
  readSection(options, s, units, f);
  if (preset.middle > 0 && (f.radius != preset.radius || f.wall != preset.wall))
    throw InputError(
        format("%s: the radii of a tube with a thick wall are in its name, mwcnt_OUTER_INNER",
               f.radius != preset.radius ? "-fibre_radius" : "-fibre_wall"));
  readSegment(s, units, preset, f);
  f.derive();
  if (auto inertia = s.maybeReal(
          "fibre_segment_inertia",
          "m rf^2 (tube), m (rm^2 + h^2/4) (many shells, mean radius rm), m rf^2/2 (solid)",
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
          "is unstable at rest");
  }
  readRestShape(s, units, f);
  readKink(options, s, units, f);
  readViscosity(s, units, f);
  readYield(s, units, f);
  if (f.radius != preset.radius) f.sheet = 0;
  if (whatTheStepDependsOn(f) != whatTheStepDependsOn(preset) || f.viscosity) f.step = 0;
  return f;
}

}  // namespace nanoweft
