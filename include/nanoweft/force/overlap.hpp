/// How deep fibres run into each other.
#pragma once

#include "nanoweft/force/force_field.hpp"

namespace nanoweft {

/// The two segments whose axes come closest, between their outermost points.
struct Overlap {
  double distance;  ///< infinite when no two are as close as was asked
  std::int64_t row[2], fibre[2];
  std::int32_t index[2];
};

/// The closest of the listed pairs, if closer than `below`. Collective.
Overlap deepestOverlap(const State& state, const ForceField& forces, double below);

/// Distance of two straight pieces of the length 2 `half` along the unit vectors `a` and `b`, the
/// centre of the second lying at `d` from that of the first.
double distanceOfPieces(const Vec3d& d, const Vec3d& a, const Vec3d& b, double half);

}  // namespace nanoweft
