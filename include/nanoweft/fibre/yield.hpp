/// Plastic flow of a bond (model.md 14): what it is at rest follows its strain, so that neither
/// its elastic stretch nor its elastic bending exceeds what its kind bears.
#pragma once

#include <cmath>
#include <limits>

#include "nanoweft/fibre/bond.hpp"

namespace nanoweft {

/// What a kind's bonds bear elastically. Infinite: they do not flow.
struct Yield {
  double stretch = std::numeric_limits<double>::infinity();  ///< change of length
  double angle = std::numeric_limits<double>::infinity();    ///< between the segments' first axes

  explicit operator bool() const { return std::isfinite(stretch) || std::isfinite(angle); }
  /// By how much the rest length changes when it is `longer` than at rest.
  double flowOfLength(double longer) const {
    const double beyond = std::abs(longer) - stretch;
    return beyond > 0 ? std::copysign(beyond, longer) : 0.0;
  }
  /// The rotation by which the rest shape turns, in the frame of the first segment; for frames that
  /// are equal at rest.
  Vec3d flowOfShape(const BondGeometry<double>& bond) const {
    const Vec3d ei = axis1(bond.qi), ej = axis1(bond.qj), normal = cross(ei, ej);
    const double size = norm(normal), beyond = std::atan2(size, dot(ei, ej)) - angle;
    if (!(beyond > 0 && size > 0)) return {0, 0, 0};
    const Vec3d turn = (beyond / size) * normal;
    return {dot(turn, ei), dot(turn, axis2(bond.qi)), dot(turn, axis3(bond.qi))};
  }
};

}  // namespace nanoweft
