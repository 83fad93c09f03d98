/// What follows a broken bond, for the pair forces (model.md 7).
///
/// Neighbours along a fibre, closer than -pair_exclude places, do not interact: their distance is
/// the bonds' business and lies deep inside the repulsion. When a bond between them breaks they
/// must become an ordinary pair, yet switching the pair force on at once would add its energy out
/// of nothing (two ends 1.3 T apart repel with hundreds of eV). So each such pair starts to
/// interact when it first has been out of the force's reach, where its energy is zero: no energy
/// jumps in.
///
/// Two bit masks a segment hold this (State::gap); both ends of a pair keep their own copy and come
/// to the same bits from the same positions.
#pragma once

#include <vector>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// Longest -pair_exclude with breakage: a mask has 64 bits.
inline constexpr int mostExcludeWithBreakage = 64;
/// Pairs are checked every so many steps: a number that no schedule of rebuilds changes.
inline constexpr int gapCheckInterval = 10;

/// Marks the neighbourhoods of bonds that broke; `rows`: the bonds' first segments, found by this
/// rank. Also sets previousBroken. Collective.
void spreadBreaks(State& state, int exclude, const std::vector<std::int64_t>& rows);

/// The same for the bonds that a state came with. Collective.
void spreadOldBreaks(State& state, int exclude);

/// Lets pairs interact that a break separates and that are out of reach now. True when some were
/// found: the list must be built before they come into reach again.
bool releasePairs(State& state, const ForceField& forces, const Domain& domain);

}  // namespace nanoweft
