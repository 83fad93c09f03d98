#include "nanoweft/scene/line.hpp"

#include <algorithm>
#include <cmath>

namespace nanoweft {

namespace {

/// The step of a parameter after which two places are a chord away from each other. `guess`: about
/// how long it is.
double stepFor(double chord, double guess, const std::function<double(double)>& distanceAfter) {
  double step = guess;
  for (int k = 0; k < 100; ++k) {
    const double distance = distanceAfter(step);
    if (std::abs(distance / chord - 1.0) < 1e-13) return step;
    step *= std::clamp(chord / distance, 0.5, 2.0);
  }
  // Where the curve turns back the distance falls again; the first step that is long enough counts.
  const double part = std::copysign(0.01 * chord, guess);
  int parts = 1;
  while (parts < 10000 && distanceAfter(parts * part) < chord) ++parts;
  double low = (parts - 1) * part, high = parts * part;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (distanceAfter(middle) < chord ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// How far the parameter goes from `from` until the place is a chord away.
double stepAlong(const Curve& curve, double from, double chord, double guess) {
  const Vec3d start = curve(from);
  return stepFor(chord, guess, [&](double step) { return norm(curve(from + step) - start); });
}

/// How far the parameter goes on both sides of 0 until the places are a chord away from each other.
double stepAround(const Curve& curve, double chord) {
  return 0.5 * stepFor(chord, chord,
                       [&](double step) { return norm(curve(0.5 * step) - curve(-0.5 * step)); });
}

/// The turn that takes one unit vector to another, without twist.
Quatd leastTurn(const Vec3d& from, const Vec3d& to) {
  const Vec3d axis = cross(from, to);
  const double sine = norm(axis), angle = std::atan2(sine, dot(from, to));
  return rotation((sine > 1e-300 ? angle / sine : 1.0) * axis);
}

/// A direction as far on the other side of a chord.
Vec3d mirrored(const Vec3d& direction, const Vec3d& chord) {
  return 2.0 * dot(direction, chord) * chord - direction;
}

/// Directions of the bonds.
std::vector<Vec3d> chordsOf(const Line& line) {
  const auto& p = line.points;
  std::vector<Vec3d> chords;
  for (std::size_t k = 0; k + 1 < p.size(); ++k) chords.push_back(unitVector(p[k + 1] - p[k]));
  if (line.closed) chords.push_back(unitVector(p.front() - p.back() + line.round));
  return chords;
}

/// Directions near the given ones between each two of which their chord lies midway, as in bonds
/// that are at rest once each end has turned by half of the rest rotation. The first direction
/// determines all by reflections; that one is taken which leads nearest to the given ones. In a
/// closed line the last may lead past the first; that is shared by all bonds.
std::vector<Vec3d> midwayDirections(const Line& line, const std::vector<Vec3d>& given) {
  const std::vector<Vec3d> chords = chordsOf(line);
  const std::size_t n = given.size();
  Vec3d first = given.back();
  for (std::size_t k = n - 1; k-- > 0;) first = given[k] + mirrored(first, chords[k]);
  first = unitVector(first);
  Vec3d around = first;
  if (line.closed) {
    for (const Vec3d& chord : chords) around = mirrored(around, chord);
    around = first = unitVector(first + around);
    for (std::size_t k = n; k-- > 0;) around = mirrored(around, chords[k]);
  }
  std::vector<Vec3d> directions;
  for (std::size_t k = 0; k < n; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(n);
    directions.push_back(unitVector(first + share * (around - first)));
    if (k == chords.size()) break;
    first = mirrored(first, chords[k]);
    around = mirrored(around, chords[k]);
  }
  return directions;
}

/// By how much midway directions may stray (model.md 10).
constexpr double farthestStray = 0.3;

/// Directions of fibres that are at rest as they lie: midway ones, unless they stray far from the
/// segments', or by more than these turn from one to the next, as they do on lines with kinks.
std::vector<Vec3d> restDirections(const Line& line) {
  const std::vector<Vec3d> given = directionsOf(line), midway = midwayDirections(line, given);
  double strays = 0, turns = 0;
  for (std::size_t k = 0; k < given.size(); ++k) {
    strays = std::max(strays, norm(midway[k] - given[k]));
    if (k > 0) turns = std::max(turns, norm(given[k] - given[k - 1]));
  }
  return strays > std::min(turns, farthestStray) ? given : midway;
}

/// The rotations from each segment to the next as they are.
std::vector<Vec3d> restOf(const FibreGeometry& g) {
  std::vector<Vec3d> rest(g.orientation.size(), Vec3d{0, 0, 0});
  const std::size_t bonds = g.closed ? rest.size() : rest.size() - 1;
  for (std::size_t k = 0; k < bonds; ++k) {
    const Quatd &q = g.orientation[k], &next = g.orientation[(k + 1) % rest.size()];
    rest[k] = rotationVector(Quatd{q.w, -q.x, -q.y, -q.z} * next);
  }
  return rest;
}

}  // namespace

Range rangeOn(const std::vector<Curve>& curves, double end, int parts,
              const std::function<double(const Vec3d&)>& measure) {
  Range range;
  for (const Curve& curve : curves)
    for (int k = 0; k < parts; ++k) range.add(measure(curve(end * k / parts)));
  return range;
}

std::vector<Vec3d> walk(const Curve& curve, double chord, int count) {
  std::vector<Vec3d> points(static_cast<std::size_t>(count));
  const bool even = count % 2 == 0;
  const double half = even ? stepAround(curve, chord) : 0.0;
  for (const int way : {1, -1}) {
    const int middle = even && way < 0 ? count / 2 - 1 : count / 2;
    double u = way * half, step = way * chord;
    points[static_cast<std::size_t>(middle)] = curve(u);
    for (int k = middle + way; k >= 0 && k < count; k += way) {
      u += step = stepAlong(curve, u, chord, step);
      points[static_cast<std::size_t>(k)] = curve(u);
    }
  }
  return points;
}

std::vector<Vec3d> walkAround(const Curve& curve, double end, int count, double& chord) {
  std::vector<Vec3d> points(static_cast<std::size_t>(count));
  for (int trial = 0; trial < 60; ++trial) {
    double u = 0, step = chord;
    for (Vec3d& point : points) {
      point = curve(u);
      u += step = stepAlong(curve, u, chord, step);
    }
    if (std::abs(u / end - 1.0) < 1e-12) break;
    chord *= end / u;
  }
  return points;
}

Vec3d acrossOf(const Vec3d& axis) {
  const Vec3d hint = std::abs(axis.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  return unitVector(hint - dot(hint, axis) * axis);
}

std::vector<Vec3d> directionsOf(const Line& line) {
  if (!line.axes.empty()) return line.axes;
  const auto& p = line.points;
  const std::size_t n = p.size();
  std::vector<Vec3d> t(n);
  for (std::size_t k = 1; k + 1 < n; ++k) t[k] = unitVector(p[k + 1] - p[k - 1]);
  if (line.closed) {
    t[0] = unitVector(p[1] - p[n - 1] + line.round);
    t[n - 1] = unitVector(p[0] - p[n - 2] + line.round);
    return t;
  }
  if (n < 3) {
    std::ranges::fill(t, unitVector(p[1] - p[0]));
    return t;
  }
  // End segments lean against their chord as their neighbours do: bending without shear.
  t[0] = unitVector(mirrored(t[1], unitVector(p[1] - p[0])));
  t[n - 1] = unitVector(mirrored(t[n - 2], unitVector(p[n - 1] - p[n - 2])));
  return t;
}

FibreGeometry geometryOf(Line line, bool shaped) {
  const std::vector<Vec3d> t = shaped ? restDirections(line) : directionsOf(line);
  FibreGeometry g;
  g.closed = line.closed;
  g.position = std::move(line.points);
  Vec3d across = acrossOf(t[0]);
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (k > 0) across = axis2(leastTurn(t[k - 1], t[k]) * g.orientation.back());
    across = unitVector(across - dot(across, t[k]) * t[k]);
    g.orientation.push_back(quaternionFromAxes(t[k], across, cross(t[k], across)));
  }
  if (g.closed) {
    // After one round the frame is turned about the axis by an angle, which all bonds share.
    const Vec3d back = axis2(leastTurn(t.back(), t[0]) * g.orientation.back());
    const Quatd& first = g.orientation[0];
    const double angle = std::atan2(dot(back, axis3(first)), dot(back, axis2(first)));
    for (std::size_t k = 0; k < t.size(); ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(t.size());
      g.orientation[k] = g.orientation[k] * rotation({-angle * share, 0, 0});
    }
  }
  if (shaped) g.rest = restOf(g);
  return g;
}

Curve beside(Curve axis, const Vec3d& along, std::function<std::array<double, 2>(double)> offset,
             double step) {
  const Vec3d side = acrossOf(along), up = cross(along, side);
  return [=](double u) {
    const auto [a, b] = offset(u);
    if (a == 0 && b == 0) return axis(u);
    const Quatd q = leastTurn(along, unitVector(axis(u + step) - axis(u - step)));
    // The rotation takes the space axes to those of the frame.
    const Vec3d v = a * side + b * up;
    return axis(u) + v.x * axis1(q) + v.y * axis2(q) + v.z * axis3(q);
  };
}

}  // namespace nanoweft
