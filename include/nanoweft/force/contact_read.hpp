/// The options of contacts with friction (-contact_...).
#pragma once

#include <memory>

#include "nanoweft/force/friction.hpp"
#include "nanoweft/force/pair_reader.hpp"

namespace nanoweft {

/// Reads the options for two kinds; null when -pair does not name `contact`. Throws InputError when
/// neither the options nor the kinds' moduli across the axis say how stiff it is. `friction` has
/// the defaults, NaN for what must be given, and becomes what holds.
std::unique_ptr<PairForce> readContact(const PairReader& read, const PairChoice& choice,
                                       FrictionLaw& friction);

}  // namespace nanoweft
