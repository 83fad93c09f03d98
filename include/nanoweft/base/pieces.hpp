/// Distance of straight pieces, such as the axes of two segments.
#pragma once

#include "nanoweft/base/both.hpp"
#include "nanoweft/base/vec.hpp"

namespace nanoweft {

/// Distance of two straight pieces of the lengths 2 `half` along the unit vectors `a` and `b`, the
/// centre of the second lying at `d` from that of the first.
double distanceOfPieces(const Vec3d& d, const Vec3d& a, const Vec3d& b, Both<double> half);

}  // namespace nanoweft
