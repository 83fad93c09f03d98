/// Links go where their segments go.
#pragma once

#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// To be called before owned segments migrate to `destination`: gives each link to the ranks that
/// will own its ends. Collective.
void moveLinks(State& state, const std::vector<int>& destination);

}  // namespace nanoweft
