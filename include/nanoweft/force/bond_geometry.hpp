/// The geometry of bonds, read from the state: of one bond, or of a bond in each SIMD lane.
#pragma once

#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/force/gather.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// Geometry of the bond between the segments with local indices i and j; j follows i.
inline BondGeometry<double> bondGeometry(const State& s, const MinimumImage& nearest, int i,
                                         int j) {
  return {nearest(s.position(j) - s.position(i)), s.orientation(i), s.orientation(j)};
}
/// Geometry of `laneCount` bonds, one a lane.
NW_INLINE BondGeometry<Lanes> bondGeometry(const State& s, const MinimumImage& nearest,
                                           const std::int32_t* i, const std::int32_t* j) {
  return {nearest(gatherPositions(s.pose, j) - gatherPositions(s.pose, i)),
          gatherOrientations(s.pose, i), gatherOrientations(s.pose, j)};
}

}  // namespace nanoweft
