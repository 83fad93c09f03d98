/// Finds the deepest overlap of two fibres: the pair of listed segments whose axes are closest.
#pragma once

#include "nanoweft/force/force_field.hpp"

namespace nanoweft {

/// The two segments whose surfaces overlap most; axes are taken between their outermost
/// quadrature points.
struct Overlap {
  double depth;  ///< overlap of the surfaces over the smaller radius; -infinity: none is as deep
  std::int64_t row[2], fibre[2];
  std::int32_t index[2];
};

/// The deepest of the listed pairs, if deeper than `beyond` of the smaller radius. Collective.
Overlap deepestOverlap(const State& state, const ForceField& forces, double beyond);

/// Distance of two straight pieces of the lengths 2 `half` along the unit vectors `a` and `b`, the
/// centre of the second lying at `d` from that of the first.
double distanceOfPieces(const Vec3d& d, const Vec3d& a, const Vec3d& b, Both<double> half);

}  // namespace nanoweft
