#include "nanoweft/base/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nanoweft {

double distanceOfPieces(const Vec3d& d, const Vec3d& a, const Vec3d& b, Both<double> half) {
  // s and t are places along the pieces. The least distance is where the two lines are closest, if
  // that is on both pieces, else at one of the four ends.
  const double ab = dot(a, b), da = dot(d, a), db = dot(d, b);
  auto held = [](double x, double most) { return std::clamp(x, -most, most); };
  auto squared = [&](double s, double t) {
    const Vec3d x = d + t * b - s * a;
    return dot(x, x);
  };
  double best = std::numeric_limits<double>::infinity();
  if (const double sine2 = 1.0 - ab * ab; sine2 > 1e-12) {
    const double s = (da - ab * db) / sine2, t = (ab * da - db) / sine2;
    if (std::abs(s) <= half.i && std::abs(t) <= half.j) best = squared(s, t);
  }
  for (const double sign : {-1.0, 1.0}) {
    const double endOfA = sign * half.i, endOfB = sign * half.j;
    best = std::min(best, squared(endOfA, held(ab * endOfA - db, half.j)));
    best = std::min(best, squared(held(ab * endOfB + da, half.i), endOfB));
  }
  return std::sqrt(best);
}

}  // namespace nanoweft
