/// What the listed pairs of a state are like: how close they come, and how strongly they push.
#pragma once

#include <functional>

#include "nanoweft/force/force_field.hpp"

namespace nanoweft {

/// Of all listed pairs, that whose points come closest, measured by the least distance which their
/// kinds may have.
struct ClosestPair {
  double distance;  ///< of two points
  double least;     ///< that they may have
  double sensible;  ///< below which the fibres have passed through each other
  std::int64_t fibre[2];
  std::int32_t index[2];
};
/// `least(pair force)`: the least distance that points may have. Collective.
ClosestPair findClosestPair(const State& state, const ForceField& forces,
                            const std::function<double(const PairForce&)>& least);

/// The segment on which the forces of pairs that overlap have the largest sum.
struct StrongestSum {
  double share;  ///< of the force that the integer sums of ForceField hold
  std::int64_t fibre;
  std::int32_t index;
};
/// Sums in doubles, a pair at a time: slow, but without the limits of ForceField's. Collective.
StrongestSum findStrongestSum(const State& state, const ForceField& forces);

}  // namespace nanoweft
