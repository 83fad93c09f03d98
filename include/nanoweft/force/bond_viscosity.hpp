/// The internal viscosity of bonds, added to State::viscous.
#pragma once

#include "nanoweft/force/bond_list.hpp"

namespace nanoweft {

/// Adds what the viscosity of a thread's bonds does to the segments of its share, from the present
/// poses and velocities. State::viscous must be zero there: a segment has two bonds at most, so
/// their order does not matter.
void addBondViscosity(State& state, const Kinds& kinds, const MinimumImage& nearest,
                      const BondList& bonds, int thread, Share share);

}  // namespace nanoweft
