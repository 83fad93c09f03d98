/// The pair force of a contact law (contact.hpp).
#pragma once

#include <memory>

#include "nanoweft/force/contact.hpp"
#include "nanoweft/force/pair_force.hpp"

namespace nanoweft {

std::unique_ptr<PairForce> makeContactForce(const ContactLaw& law, const PairTraits& traits,
                                            const PairChoice& choice);

}  // namespace nanoweft
