/// The pair force of a contact law (contact.hpp) with friction (friction.hpp).
#pragma once

#include <memory>

#include "nanoweft/force/friction.hpp"
#include "nanoweft/force/pair_force.hpp"

namespace nanoweft {

std::unique_ptr<PairForce> makeContactForce(const ContactLaw& law, const FrictionLaw& friction,
                                            const PairTraits& traits, const PairChoice& choice);

}  // namespace nanoweft
