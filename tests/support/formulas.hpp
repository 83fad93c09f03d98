/// The model's energies for the (10,10) tube, written down once more straight from their
/// definitions: nothing of the program's own evaluation is used, so that it can be tested with
/// them.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "nanoweft/base/vec.hpp"

namespace nanoweft::test::tube {

// E = 1029 GPa, G = 459 GPa, radius 6.78 A, wall 3.35 A, segments of 2649 amu.
inline constexpr double pi = std::numbers::pi, gigapascal = 1 / 160.2176634,
                        amu = 1.66053906660e-27 / 1.602176634e-29;
inline constexpr double rf = 6.78, wall = 3.35, length = 13.56;
inline constexpr double mass = 2649 * amu, inertia = mass * rf * rf;
inline constexpr double young = 1029 * gigapascal, shear = 459 * gigapascal;
inline constexpr double area = 2 * pi * wall * rf,
                        moment = pi * wall * rf * (rf * rf + wall * wall / 4);
inline constexpr double ES = young * area, EJ = young * moment, GJp = shear * 2 * moment;
inline constexpr double B1 = ES / length, B2 = 12 * EJ / length,
                        B3 = -2 * EJ / length - GJp / (2 * length), B4 = GJp / length;

struct Frame {
  Vec3d e1, e2, e3;
  explicit Frame(const Quatd& q)
      : e1(turn(q, {1, 0, 0})), e2(turn(q, {0, 1, 0})), e3(turn(q, {0, 0, 1})) {}

  /// The vector part of q v q*.
  static Vec3d turn(const Quatd& q, const Vec3d& v) {
    const Quatd r = q * Quatd{0, v.x, v.y, v.z} * Quatd{q.w, -q.x, -q.y, -q.z};
    return {r.x, r.y, r.z};
  }
};

/// A bond's energy: stretch, shear, bending, torsion; and what it does to its two ends.
struct Bond {
  double stretch, shear, bending, torsion, sum;
  Vec3d forceI, torqueI, torqueJ;
};

inline Bond bond(const Vec3d& xi, const Quatd& qi, const Vec3d& xj, const Quatd& qj) {
  const Frame i(qi), j(qj);
  const double r = norm(xj - xi);
  const Vec3d d = (1 / r) * (xj - xi);
  const Vec3d ni = i.e1, nj = -j.e1, w = nj - ni;
  const double nn = dot(ni, nj), n2 = dot(i.e2, j.e2), n3 = dot(i.e3, j.e3);
  Bond b;
  b.stretch = 0.5 * B1 * (r - length) * (r - length);
  b.shear = B2 * (0.5 * dot(w, d) - 0.25 * nn + 0.75);
  b.bending = (B2 / 4 + B3 + B4 / 2) * (1 + nn);
  b.torsion = -0.5 * B4 * (nn + n2 + n3 - 1);
  b.sum = 0.5 * B1 * (r - length) * (r - length) + 0.5 * B2 * dot(w, d) + B3 * nn -
          0.5 * B4 * (n2 + n3) + B2 + B3 + B4;
  b.forceI = B1 * (r - length) * d + (B2 / (2 * r)) * (w - dot(w, d) * d);
  const Vec3d couple = -B3 * cross(ni, nj) + (0.5 * B4) * (cross(i.e2, j.e2) + cross(i.e3, j.e3));
  b.torqueI = (0.5 * B2) * cross(ni, d) + couple;
  b.torqueJ = -(0.5 * B2) * cross(nj, d) - couple;
  return b;
}

/// Van der Waals energy of two points with its slope: the 9.5-4 law, the linear repulsion from
/// where the curvature is 2k = 400 eV/A^2, the switch from 3T to 4T.
inline std::array<double, 2> pointPair(double r) {
  constexpr double eps = 0.07124, a = 0.0223, b = 1.31, alpha = 9.5, beta = 4, k = 200;
  constexpr double splice = 16.313684942742598, from = 3 * length, to = 4 * length;
  auto v = [](double s) {
    const double D = s / rf - 2;
    return 4 * eps * (a * std::pow(D, -alpha) - b * std::pow(D, -beta));
  };
  auto slope = [](double s) {
    const double D = s / rf - 2;
    return 4 * eps / rf *
           (-alpha * a * std::pow(D, -alpha - 1) + beta * b * std::pow(D, -beta - 1));
  };
  if (r >= to) return {0, 0};
  if (r <= splice) {
    const double s = r - splice;
    return {v(splice) + slope(splice) * s + k * s * s, slope(splice) + 2 * k * s};
  }
  if (r <= from) return {v(r), slope(r)};
  const double x = (r - from) / (to - from);
  const double S = 1 - x * x * x * (10 - 15 * x + 6 * x * x),
               dS = -30 * x * x * (1 - x) * (1 - x) / (to - from);
  return {v(r) * S, slope(r) * S + v(r) * dS};
}

/// Energy of two segments, with force on j and the torques, by the double sum over 3 x 3 points.
struct Pair {
  double energy = 0;
  Vec3d forceJ, torqueI, torqueJ;
};

inline Pair pair(const Vec3d& xi, const Quatd& qi, const Vec3d& xj, const Quatd& qj) {
  const Vec3d ei = Frame(qi).e1, ej = Frame(qj).e1;
  Pair sum;
  for (int a = -1; a <= 1; ++a)
    for (int b = -1; b <= 1; ++b) {
      const Vec3d armI = (a * length / 3) * ei, armJ = (b * length / 3) * ej;
      const Vec3d d = (xj + armJ) - (xi + armI);
      const double r = norm(d);
      const auto [u, slope] = pointPair(r);
      sum.energy += u / 9;
      if (r == 0) continue;  // no direction, so no force
      const Vec3d f = (-slope / (9 * r)) * d;
      sum.forceJ += f;
      sum.torqueI += cross(armI, -f);
      sum.torqueJ += cross(armJ, f);
    }
  return sum;
}

}  // namespace nanoweft::test::tube
