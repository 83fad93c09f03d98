/// Finds the deepest overlap of two fibres: the pair of listed segments whose axes are closest.
#pragma once

#include "nanoweft/force/force_field.hpp"

namespace nanoweft {

/// The two segments whose axes, each taken between its outermost quadrature points, are closest.
struct Overlap {
  double distance;  ///< of the axes; infinite when no pair is as close as asked for
  std::int64_t row[2], fibre[2];
  std::int32_t index[2];
};

/// The closest of the listed pairs, if closer than `below`. Collective.
Overlap deepestOverlap(const State& state, const ForceField& forces, double below);

/// Distance of two straight pieces of the length 2 `half` along the unit vectors `a` and `b`, the
/// centre of the second lying at `d` from that of the first.
double distanceOfPieces(const Vec3d& d, const Vec3d& a, const Vec3d& b, double half);

}  // namespace nanoweft
