/// Fibres by name: the presets that -fibre_preset starts from. The manual's page on fibres
/// (src/manual/fibres.md) has their numbers and where these come from.
#pragma once

#include <string>

#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"

namespace nanoweft {

/// The (10,10) carbon nanotube of the paper's Table 1 (rf 6.78 A, wall 3.35 A, T 13.56 A,
/// 1029 GPa, 459 GPa, 2649 amu a segment) in the given units.
Fibre cnt1010(const UnitSystem& units);

/// The fibre of this name in the given units. Throws InputError, which lists the names there are,
/// for an unknown one, and for a tube that cannot be (a chirality with M > N, radii in the wrong
/// order or too small for a wall).
Fibre presetFibre(const std::string& name, const UnitSystem& units);

/// The names there are, separated by commas.
std::string presetNames();

}  // namespace nanoweft
