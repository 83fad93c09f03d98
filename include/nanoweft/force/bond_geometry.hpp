/// The geometry of bonds, read from the state: of one bond, or of a bond in each SIMD lane.
#pragma once

#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/force/gather.hpp"
#include "nanoweft/state/rest.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// Geometry of the bond between the segments with local indices i and j, with frames that are equal
/// at rest; j follows i.
inline BondGeometry<double> bondGeometry(const State& s, const Kinds& kinds,
                                         const MinimumImage& nearest, int i, int j) {
  BondGeometry<double> bond{nearest(s.position(j) - s.position(i)), s.orientation(i),
                            s.orientation(j)};
  if (s.restHalf || kinds.curved()) turnToRest(restHalfOf(s, kinds, i), bond);
  return bond;
}
/// Geometry of `laneCount` bonds, one a lane, with the segments' own frames.
NW_INLINE BondGeometry<Lanes> bondGeometry(const State& s, const MinimumImage& nearest,
                                           const std::int32_t* i, const std::int32_t* j) {
  return {nearest(gatherPositions(s.pose, j) - gatherPositions(s.pose, i)),
          gatherOrientations(s.pose, i), gatherOrientations(s.pose, j)};
}

}  // namespace nanoweft
