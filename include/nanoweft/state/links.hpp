/// Links tie any two segments, of one fibre or of two, besides the bonds along fibres (model.md
/// 11).
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "nanoweft/base/vec.hpp"

namespace nanoweft {

struct Link {
  std::int64_t id = 0;                  ///< its place in the order of the state file
  std::array<std::int64_t, 2> row{};    ///< of the segments at its ends
  std::array<std::int64_t, 2> fibre{};  ///< of these
  std::array<std::int32_t, 2> index{};
  std::int32_t kind = 0, broken = 0;
  double length = 0;  ///< at rest
  /// For each end, the rotation from the segment's frame to the link's own; at rest both ends see
  /// the same frame, whose first axis points from the first end to the second.
  std::array<Quatd, 2> frame{};
};

/// The links of which a rank owns one end at least, ordered by id. Both owners of a link's ends
/// hold a copy and change it alike.
using Links = std::vector<Link>;

/// A frame whose first axis points along the unit vector t.
inline Quatd frameAlong(const Vec3d& t) {
  const Vec3d hint = std::abs(t.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  const Vec3d across = hint - dot(hint, t) * t;
  const Vec3d e3 = (1.0 / norm(across)) * across;
  return quaternionFromAxes(t, cross(e3, t), e3);
}

inline Quatd conjugate(const Quatd& q) {
  return {q.w, -q.x, -q.y, -q.z};
}

}  // namespace nanoweft
