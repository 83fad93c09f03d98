/// Positions and orientations of `laneCount` segments from their pose records, a segment a lane.
#pragma once

#include <cstdint>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/base/vec.hpp"

namespace nanoweft {

/// Component `c` of the pose records.
NW_INLINE Lanes gatherPose(const double* pose, const std::int32_t* index, std::size_t c) {
  return Lanes([&](auto k) { return pose[8 * static_cast<std::size_t>(index[k]) + c]; });
}

NW_INLINE Vec3<Lanes> gatherPositions(const double* pose, const std::int32_t* index) {
  return {gatherPose(pose, index, 0), gatherPose(pose, index, 1), gatherPose(pose, index, 2)};
}

NW_INLINE Quat<Lanes> gatherOrientations(const double* pose, const std::int32_t* index) {
  return {gatherPose(pose, index, 4), gatherPose(pose, index, 5), gatherPose(pose, index, 6),
          gatherPose(pose, index, 7)};
}

}  // namespace nanoweft
