/// Small vectors and rotations, generic in the number type: `double`, or a SIMD vector of doubles.
///
/// Every function is written so that exchanging the roles of two segments negates differences
/// exactly; see src/README.md, "The same bits".
#pragma once

#include <cmath>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

template <class V>
struct Vec3 {
  V x{}, y{}, z{};

  Vec3& operator+=(const Vec3& b) {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
  Vec3& operator-=(const Vec3& b) {
    x -= b.x, y -= b.y, z -= b.z;
    return *this;
  }
  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend Vec3 operator*(const V& s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
};

using Vec3d = Vec3<double>;

/// The i-th of consecutive triples.
inline Vec3d triple(const double* of, int i) {
  return {of[3 * i], of[3 * i + 1], of[3 * i + 2]};
}

template <class V>
NW_INLINE V dot(const Vec3<V>& a, const Vec3<V>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class V>
NW_INLINE Vec3<V> cross(const Vec3<V>& a, const Vec3<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The same with fused operations where the target has them, for the pair kernel. (Exchanging a and
/// b does not negate the cross product exactly.)
template <class V>
NW_INLINE V fusedDot(const Vec3<V>& a, const Vec3<V>& b) {
  return multiplyAdd(a.z, b.z, multiplyAdd(a.y, b.y, V(a.x * b.x)));
}
template <class V>
NW_INLINE Vec3<V> fusedCross(const Vec3<V>& a, const Vec3<V>& b) {
  return {multiplyAdd(a.y, b.z, V(-(a.z * b.y))), multiplyAdd(a.z, b.x, V(-(a.x * b.z))),
          multiplyAdd(a.x, b.y, V(-(a.y * b.x)))};
}
/// s a + b.
template <class V>
NW_INLINE Vec3<V> multiplyAdd(const V& s, const Vec3<V>& a, const Vec3<V>& b) {
  return {multiplyAdd(s, a.x, b.x), multiplyAdd(s, a.y, b.y), multiplyAdd(s, a.z, b.z)};
}

template <class V>
NW_INLINE V norm(const Vec3<V>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}

/// Unit quaternion (w, x, y, z), taking body axes to space axes.
template <class V>
struct Quat {
  V w{1.0}, x{}, y{}, z{};
};

using Quatd = Quat<double>;

template <class V>
Quat<V> operator*(const Quat<V>& a, const Quat<V>& b) {
  return {
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/// Fibre axis e1: the body x axis in space.
template <class V>
NW_INLINE Vec3<V> axis1(const Quat<V>& q) {
  return {1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.w * q.z),
          2.0 * (q.x * q.z - q.w * q.y)};
}

/// e2: the body y axis in space.
template <class V>
NW_INLINE Vec3<V> axis2(const Quat<V>& q) {
  return {2.0 * (q.x * q.y - q.w * q.z), 1.0 - 2.0 * (q.x * q.x + q.z * q.z),
          2.0 * (q.y * q.z + q.w * q.x)};
}

/// e3: the body z axis in space.
template <class V>
NW_INLINE Vec3<V> axis3(const Quat<V>& q) {
  return {2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.y * q.z - q.w * q.x),
          1.0 - 2.0 * (q.x * q.x + q.y * q.y)};
}

/// Up to this square of the half angle (a rotation by 0.2 rad) a Taylor series serves for the sine.
/// A time step turns a segment by far less.
inline constexpr double smallHalfAngle2 = 0.01;

/// Rotation by a small vector (axis times angle in radians); the Taylor remainders are below 1e-17.
template <class V>
NW_INLINE Quat<V> smallRotation(const Vec3<V>& a) {
  const V s = 0.25 * dot(a, a);
  auto series = [&s](double a, double b, double c, double d, double e) {
    // 1 - s/a (1 - s/b (1 - ...
    V sum = 1.0 - (1.0 / e) * s;
    for (double k : {d, c, b, a}) sum = 1.0 - (1.0 / k) * s * sum;
    return sum;
  };
  const V cosine = series(2, 12, 30, 56, 90), sinc = series(6, 20, 42, 72, 110);
  const V f = 0.5 * sinc;
  return {cosine, f * a.x, f * a.y, f * a.z};
}

/// Rotation by the vector `a` (axis times angle in radians).
inline Quatd rotation(const Vec3d& a) {
  const double s = 0.25 * dot(a, a);  // square of the half angle
  if (s < smallHalfAngle2) return smallRotation(a);
  const double h = std::sqrt(s), f = 0.5 * std::sin(h) / h;
  return {std::cos(h), f * a.x, f * a.y, f * a.z};
}

/// The rotation vector of a unit quaternion, of at most pi; `rotation` undoes it.
inline Vec3d rotationVector(const Quatd& q) {
  const double sign = q.w < 0 ? -1.0 : 1.0;
  const Vec3d v{sign * q.x, sign * q.y, sign * q.z};
  const double sine = norm(v);
  return (sine > 1e-9 ? 2.0 * std::atan2(sine, sign * q.w) / sine : 2.0) * v;
}

/// One Newton step towards unit length: enough when |q| is within 1e-8 of one.
template <class V>
NW_INLINE Quat<V> renormalised(const Quat<V>& q) {
  const V f = 1.5 - 0.5 * (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {f * q.w, f * q.x, f * q.y, f * q.z};
}

/// Quaternion whose axes are the orthonormal right-handed columns e1, e2, e3.
inline Quatd quaternionFromAxes(const Vec3d& e1, const Vec3d& e2, const Vec3d& e3) {
  const double trace = e1.x + e2.y + e3.z;
  Quatd q;
  if (trace > 0) {
    const double s = 2.0 * std::sqrt(1.0 + trace);
    q = {0.25 * s, (e2.z - e3.y) / s, (e3.x - e1.z) / s, (e1.y - e2.x) / s};
  } else if (e1.x > e2.y && e1.x > e3.z) {
    const double s = 2.0 * std::sqrt(1.0 + e1.x - e2.y - e3.z);
    q = {(e2.z - e3.y) / s, 0.25 * s, (e2.x + e1.y) / s, (e3.x + e1.z) / s};
  } else if (e2.y > e3.z) {
    const double s = 2.0 * std::sqrt(1.0 + e2.y - e1.x - e3.z);
    q = {(e3.x - e1.z) / s, (e2.x + e1.y) / s, 0.25 * s, (e3.y + e2.z) / s};
  } else {
    const double s = 2.0 * std::sqrt(1.0 + e3.z - e1.x - e2.y);
    q = {(e1.y - e2.x) / s, (e3.x + e1.z) / s, (e3.y + e2.z) / s, 0.25 * s};
  }
  const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / n, q.x / n, q.y / n, q.z / n};
}

}  // namespace nanoweft
