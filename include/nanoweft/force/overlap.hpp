/// Finds the deepest overlap of two fibres: the pair of listed segments whose axes are closest.
#pragma once

#include "nanoweft/base/pieces.hpp"
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

}  // namespace nanoweft
