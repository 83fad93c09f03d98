/// Stress of a tension test as its grips feel it.
#pragma once

#include <array>

#include "nanoweft/base/units.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/tension.hpp"

namespace nanoweft {

/// At the left and at the right grip, GPa, from the forces as they were last evaluated. The same
/// bits on any number of ranks. Collective.
std::array<double, 2> gripStress(const State& state, const ForceField& forces,
                                 const Tension& tension, const UnitSystem& units);

}  // namespace nanoweft
