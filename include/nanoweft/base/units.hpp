/// Unit systems. The kernels carry no unit of their own; options and files do.
#pragma once

#include <string>

namespace nanoweft {

/// CODATA 2018.
namespace codata {
inline constexpr double electronvolt = 1.602176634e-19;  // J, exact
inline constexpr double atomicMass = 1.66053906660e-27;  // kg
inline constexpr double boltzmann = 1.380649e-23;        // J/K, exact
}  // namespace codata

/// How a person's numbers become internal ones, and what the internal ones are called.
/// Internal units are consistent: energy = mass length^2 / time^2.
struct UnitSystem {
  std::string name;      ///< "nano" or "si"
  double mass;           ///< internal mass per user's mass (amu in nano, kg in si)
  double gigapascal;     ///< internal pressure of 1 GPa
  const char* massName;  ///< the user's mass unit
  const char* length;
  const char* time;
  const char* energy;
  const char* force;
  double secondsPerTime;  ///< seconds in one internal time unit
  // What defaults are written in:
  double angstrom;               ///< internal length of 1 A
  double electronvolt;           ///< internal energy of 1 eV
  double amu;                    ///< internal mass of 1 amu
  double kilogramPerCubicMetre;  ///< internal density of 1 kg/m^3
};

/// Angstrom, femtosecond, electronvolt; masses are typed in amu.
inline const UnitSystem& nanoUnits() {
  // Internal mass unit eV fs^2/A^2 in kg: eV * 1e-30 s^2 / 1e-20 m^2.
  constexpr double massUnit = codata::electronvolt * 1e-10;
  constexpr double amu = codata::atomicMass / massUnit;
  constexpr double gpa = 1e9 / (codata::electronvolt * 1e30);
  static_assert(amu > 103.642696 && amu < 103.642698);
  static_assert(gpa > 6.241508e-3 && gpa < 6.241510e-3);
  static const UnitSystem units{"nano",
                                amu,
                                gpa,
                                "amu",
                                "A",
                                "fs",
                                "eV",
                                "eV/A",
                                1e-15,
                                1.0,
                                1.0,
                                amu,
                                1e-30 / codata::atomicMass * amu};
  return units;
}

/// Metre, second, kilogram, joule.
inline const UnitSystem& siUnits() {
  static const UnitSystem units{"si",
                                1.0,
                                1e9,
                                "kg",
                                "m",
                                "s",
                                "J",
                                "N",
                                1.0,
                                1e-10,
                                codata::electronvolt,
                                codata::atomicMass,
                                1.0};
  return units;
}

}  // namespace nanoweft
