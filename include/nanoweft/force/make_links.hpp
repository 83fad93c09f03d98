/// Makes links between fibres that are close (-links_density).
#pragma once

#include "nanoweft/force/force_field.hpp"

namespace nanoweft {

/// Adds links to the state, unstressed as it is, drawn at random among the listed pairs of segments
/// whose axes come closer than LinkLaw::distance, each at most once for each kind of link: as many
/// in the mean as the kind's density asks for. The draw depends on the seed, the number of the kind
/// and the segments alone. Lists must be up to date; they must be made anew afterwards. Throws
/// InputError for a density that there are too few places for. Collective.
void makeLinks(State& state, const ForceField& forces, const UnitSystem& units, std::uint64_t seed);

}  // namespace nanoweft
