/// Centre lines of fibres: places a bond length apart on a curve, and the frames of segments there.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "nanoweft/base/vec.hpp"
#include "nanoweft/scene/scene.hpp"

namespace nanoweft {

/// The centres of one fibre's segments.
struct Line {
  std::vector<Vec3d> points = {};
  bool closed = false;   ///< the last segment is bonded to the first
  Vec3d round{0, 0, 0};  ///< displacement after one round of a line that closes through the box
  std::vector<Vec3d> axes = {};  ///< of its segments; empty: they follow from the points
};

/// A place for each value of a parameter, along which the place moves about as fast.
using Curve = std::function<Vec3d(double)>;

inline Vec3d unitVector(const Vec3d& v) {
  return (1.0 / norm(v)) * v;
}

/// From the least to the largest of some numbers.
struct Range {
  double least = std::numeric_limits<double>::infinity(), most = -least;

  double width() const { return most - least; }
  double middle() const { return 0.5 * (least + most); }
  void add(double x) { least = std::min(least, x), most = std::max(most, x); }
};

/// Of a measure of the places on curves, at so many parameters from 0 to `end`.
Range rangeOn(const std::vector<Curve>& curves, double end, int parts,
              const std::function<double(const Vec3d&)>& measure);

/// `count` places, each a chord of that length from the one before it; the middle one at the
/// parameter 0, or the middle two as far before it as behind it.
std::vector<Vec3d> walk(const Curve& curve, double chord, int count);

/// `count` places from the parameter 0 on, in equal chords that end at the parameter `end`.
/// `chord`: about how long, and how long they are.
std::vector<Vec3d> walkAround(const Curve& curve, double end, int count, double& chord);

/// A unit vector across a unit vector.
Vec3d acrossOf(const Vec3d& axis);

/// Directions of the segments: each halves the angle between its two chords.
std::vector<Vec3d> directionsOf(const Line& line);

/// Poses along a line. Frames turn from one segment to the next as the axis does, without twist; a
/// closed fibre has the twist that its shape asks for, the same on each bond. `shaped`: bonds are
/// at rest as they lie, for which directions are a little different (model.md 10).
FibreGeometry geometryOf(Line line, bool shaped);

/// The curve that runs beside `axis` at the places `offset(u)` across it, in the frame into which
/// the least rotation takes that of `along`, a unit vector. `step`: small against all bends.
Curve beside(Curve axis, const Vec3d& along, std::function<std::array<double, 2>(double)> offset,
             double step);

}  // namespace nanoweft
