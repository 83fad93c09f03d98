#include "nanoweft/fibre/presets.hpp"

#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

using std::numbers::pi;

// Carbon tubes: lengths in A, masses in amu.

constexpr double bondLength = 1.421;     ///< of two atoms
constexpr double shellDistance = 3.35;   ///< of two shells; the wall of a single one
constexpr double closestShells = 3.0;    ///< less room than this between two is a slip
constexpr double widestTube = 1000.0;    ///< wider ones are
constexpr int widestChirality = 200;     ///< likewise
constexpr double paperDiameter = 13.56;  ///< of the (10,10) tube
constexpr double paperSheet = 17.1;      ///< thickness of a sheet of it

/// A tube whose shells of atoms lie between the radii `inner` and `outer`; one shell where these
/// are equal. The moduli are those of the paper's tube for any number of shells. The mass is that
/// of the atoms: each shell has 4/(3 sqrt(3) a^2) of them per area of its surface, and each
/// 3.35 A of the wall count as a shell. So the wall has one density, like its stiffness, and the
/// mass is the sum over the shells where these are 3.35 A apart.
Fibre carbonTube(const std::string& name, double outer, double inner, const UnitSystem& units) {
  constexpr double atomMass = 12.011;
  const double shellMass = atomMass * 4.0 / (3.0 * std::sqrt(3.0) * bondLength * bondLength);
  const double wall = outer - inner + shellDistance, middle = 0.5 * (outer + inner);
  const double length = 2.0 * outer;
  Fibre f;
  f.preset = name;
  f.radius = outer * units.angstrom;
  f.wall = wall * units.angstrom;
  if (inner < outer) f.middle = middle * units.angstrom;
  f.length = length * units.angstrom;
  f.young = 1029.0 * units.gigapascal;
  f.shear = 459.0 * units.gigapascal;
  f.mass = shellMass * (wall / shellDistance) * 2.0 * pi * middle * length * units.amu;
  f.law = "vdw";
  f.sheet = (length - paperDiameter + paperSheet) * units.angstrom;
  f.strength.length = f.length;
  f.derive();
  return f;
}

/// A and B of a name `prefix`A_B; empty where the name is not of this form.
template <class Number>
std::optional<std::pair<Number, Number>> numbersOf(std::string_view name, std::string_view prefix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  const char *first = name.data() + prefix.size(), *end = name.data() + name.size();
  std::pair<Number, Number> found{};
  const auto a = std::from_chars(first, end, found.first);
  if (a.ec != std::errc{} || a.ptr == end || *a.ptr != '_') return std::nullopt;
  const auto b = std::from_chars(a.ptr + 1, end, found.second);
  if (b.ec != std::errc{} || b.ptr != end) return std::nullopt;
  return found;
}

Fibre singleWalled(const std::string& name, int n, int m, const UnitSystem& units) {
  const double square = 1.0 * n * n + 1.0 * n * m + 1.0 * m * m;
  const double radius = bondLength * std::sqrt(3.0 * square) / (2.0 * pi);
  if (m < 0 || n < m || n > widestChirality || radius <= 0.5 * shellDistance)
    throw InputError(
        format("fibre preset %s: cnt_N_M needs a chirality %d >= N >= M >= 0 with a radius above "
               "%g A, half the wall (here %.3g A)",
               name.c_str(), widestChirality, 0.5 * shellDistance, radius));
  return carbonTube(name, radius, radius, units);
}

Fibre multiWalled(const std::string& name, double outer, double inner, const UnitSystem& units) {
  const bool ordered = inner == outer || outer - inner >= closestShells;
  if (!(ordered && inner > 0.5 * shellDistance && outer <= widestTube))
    throw InputError(format(
        "fibre preset %s: mwcnt_OUTER_INNER needs the radii of the outermost and the innermost "
        "shell in A, %g >= OUTER > INNER > %g, apart by %g A at least, or equal for one shell",
        name.c_str(), widestTube, 0.5 * shellDistance, closestShells));
  return carbonTube(name, outer, inner, units);
}

/// A solid round fibre of one material, in SI units but for GPa.
struct Solid {
  const char* name;
  double radius;               ///< m
  double young, shear;         ///< along the axis, GPa
  double density;              ///< kg/m^3
  double transverse, poisson;  ///< across the axis, GPa
  Strength strength;           ///< lengths in m
};

/// For fibres of which a mean critical strain is known: the scatter of a tenth of it is a choice.
/// Weibull's law of shape 12 scatters likewise.
constexpr Strength aboutStrain(double strain, double radius) {
  return {false, strain, 0.1 * strain, 12, strain, 2.0 * radius};
}

constexpr Solid solids[] = {
    // A PAN-based carbon fibre such as T300: 7 um thick, 230 GPa, 1760 kg/m^3, breaks at 1.5 %
    // (the maker's data sheet, Toray CFA-001). Shear modulus along the axis 15 GPa, Young's
    // modulus across it 15 GPa, and Poisson's ratio there E/(2 G) - 1 with G = 7 GPa: Soden,
    // Hinton and Kaddour, Composites Science and Technology 58, 1011 (1998). Strength by
    // Weibull's law, as is usual for fibres of this kind. Its shape 5 is typical, and the gage of
    // 25 mm is a choice: the data sheet names none for its strain.
    {.name = "carbon_t300",
     .radius = 3.5e-6,
     .young = 230,
     .shear = 15,
     .density = 1760,
     .transverse = 15,
     .poisson = 15.0 / (2.0 * 7.0) - 1.0,
     .strength = {true, 0.015, 0.0025, 5, 0.015, 0.025}},

    // E-glass. Young's modulus 69 to 72 GPa, density 2550 to 2580 kg/m^3: the maker's sheet (OCV,
    // "Glass property summary"). Poisson's ratio 0.22: "Properties of selected fibres", Michigan
    // Technological University, course MY4150. Glass is isotropic, which gives G and the modulus
    // across the axis. Typical: 13 um thick, strength 2 GPa at a gage of 20 mm, shape 5. (Pristine
    // fibres reach 3.45 to 3.79 GPa, says the maker.)
    {.name = "glass_e",
     .radius = 6.5e-6,
     .young = 72,
     .shear = 72 / (2.0 * 1.22),
     .density = 2570,
     .transverse = 72,
     .poisson = 0.22,
     .strength = {true, 2.0 / 72, 0.4 / 72, 5, 2.0 / 72, 0.02}},

    // A fibril of insulin, 8 nm thick, 3.3 +- 0.4 GPa, strength 0.6 +- 0.4 GPa: Smith et al., PNAS
    // 103, 15806 (2006). Across the axis a twentieth of E, the ratio of the bonds' stiffnesses in
    // an amyloid seen by 4D electron microscopy (PMC4371943). Typical: density of a protein,
    // shear modulus, Poisson's ratio.
    {.name = "amyloid",
     .radius = 4e-9,
     .young = 3.3,
     .shear = 0.3,
     .density = 1350,
     .transverse = 3.3 / 20,
     .poisson = 0.3,
     .strength = aboutStrain(0.6 / 3.3, 4e-9)},

    // A wet fibril from the tendon of a mouse's tail, 410 nm thick, nearly linear up to its
    // strength of 100 +- 32 MPa at a strain of 0.34 +- 0.11, which gives E: "Tensile strength of
    // single collagen fibrils isolated from tendons", European Journal of Biophysics 5, 1 (2017).
    // Shear modulus 2.9 +- 0.3 MPa in buffered saline: Yang et al., Biophysical Journal 94, 2204
    // (2008). Density: protein of 1350 kg/m^3 with the water that makes a fibril 40 % thicker and
    // 5 % longer (Gouws, Kreplak and Rutenberg, arXiv:2312.08771). Typical: Poisson's ratio, and
    // the modulus across the axis, which is that of an isotropic body with this G.
    {.name = "collagen",
     .radius = 205e-9,
     .young = 0.29,
     .shear = 0.0029,
     .density = 1170,
     .transverse = 0.008,
     .poisson = 0.4,
     .strength = aboutStrain(0.1 / 0.29, 205e-9)},

    // A microfibril of tunicate cellulose, 8 nm x 20 nm, 145 +- 31 GPa: Iwamoto et al.,
    // Biomacromolecules 10, 2571 (2009); here round, of the same area. Strength 2 GPa, the least
    // of the 2 to 6 GPa that Uetani, Uto and Suzuki quote (Scientific Reports, 2021,
    // doi:10.1038/s41598-020-80890-1). Typical: density, shear modulus, Poisson's ratio, and a
    // modulus across the axis below the 19 GPa computed for the softest direction of a perfect
    // crystal (Dri et al., Cellulose 20, 2703, 2013).
    {.name = "cellulose_nf",
     .radius = 7.1e-9,
     .young = 145,
     .shear = 5,
     .density = 1600,
     .transverse = 10,
     .poisson = 0.3,
     .strength = aboutStrain(2.0 / 145, 7.1e-9)},

    // Nylon 6, electrospun to 600 nm. From about 500 nm on such fibres are as stiff as the bulk:
    // Pai, Boyce and Rutledge, Polymer 52, 2295 (2011), for an amorphous nylon. Bulk nylon 6: 2.6
    // to 3 GPa, 78 MPa, Poisson's ratio 0.39 (Matmatch, "Polyamide Nylon 6"). Typical: density,
    // and that it is isotropic. At 78 MPa it yields rather than breaks, which elastic bonds cannot
    // follow.
    {.name = "nylon_ef",
     .radius = 300e-9,
     .young = 2.8,
     .shear = 2.8 / (2.0 * 1.39),
     .density = 1140,
     .transverse = 2.8,
     .poisson = 0.39,
     .strength = aboutStrain(0.078 / 2.8, 300e-9)},
};

Fibre solidFibre(const Solid& s, const UnitSystem& units) {
  const bool si = units.name == "si";
  const double metre = si ? 1.0 : 1e10;
  const double kilograms = s.density * pi * s.radius * s.radius * (2.0 * s.radius);
  Fibre f;
  f.preset = s.name;
  f.radius = s.radius * metre;
  f.length = 2.0 * f.radius;
  f.young = s.young * units.gigapascal;
  f.shear = s.shear * units.gigapascal;
  f.mass = si ? kilograms : kilograms / codata::atomicMass * units.mass;
  f.law = "hertz";
  f.transverse = s.transverse * units.gigapascal;
  f.poisson = s.poisson;
  f.strength = s.strength;
  f.strength.length *= metre;
  f.derive();
  return f;
}

}  // namespace

Fibre cnt1010(const UnitSystem& units) {
  const double radius = 0.5 * paperDiameter;
  Fibre f = carbonTube("cnt_10_10", radius, radius, units);
  f.mass = 2649.0 * units.amu;
  f.step = 20e-15 / units.secondsPerTime;
  f.derive();
  return f;
}

Fibre presetFibre(const std::string& name, const UnitSystem& units) {
  if (name == "cnt_10_10") return cnt1010(units);
  if (const auto chirality = numbersOf<int>(name, "cnt_"))
    return singleWalled(name, chirality->first, chirality->second, units);
  if (const auto radii = numbersOf<double>(name, "mwcnt_"))
    return multiWalled(name, radii->first, radii->second, units);
  for (const Solid& solid : solids)
    if (name == solid.name) return solidFibre(solid, units);
  throw InputError(
      format("fibre preset %s: unknown; there are %s", name.c_str(), presetNames().c_str()));
}

std::string presetNames() {
  std::string names = "cnt_N_M (chirality), mwcnt_OUTER_INNER (radii in A)";
  for (const Solid& solid : solids) names += std::string(", ") + solid.name;
  return names;
}

}  // namespace nanoweft
