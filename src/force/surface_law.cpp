#include "nanoweft/force/surface_law.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nanoweft {

namespace {

/// Distance over that of surfaces that touch, below which u' is linear: the axes of two fibres
/// have all but met.
constexpr double innermostShare = 0.25;

}  // namespace

const std::vector<SurfaceLawType>& surfaceLaws() {
  static const std::vector<SurfaceLawType> laws{
      hamakerLaw(),
      hydrogenLaw(),
      capillaryLaw(),
  };
  return laws;
}

SurfaceProfile profileOfEnergy(const SurfaceMinimum& minimum, const OfGap& beyond, double radius,
                               const Switch& range) {
  auto p = [=](double gap) {
    AtGap e;
    if (gap > minimum.gap) {
      e = beyond(gap);
      range.apply(gap, e.value, e.slope);
    } else {
      const double s = gap - minimum.gap;
      e = {minimum.energy + 0.5 * minimum.stiffness * s * s, minimum.stiffness * s};
    }
    return AtGap{radius * e.value, radius * e.slope};
  };
  // Where the parabola is zero, two crossed fibres rest.
  const double stiffest = std::max(minimum.stiffness, minimum.ownStiffness),
               width = std::sqrt(2.0 * std::abs(minimum.energy) / stiffest);
  return {p, minimum.gap, minimum.gap, width, true};
}

SurfaceLaw::SurfaceLaw(SurfaceProfile profile, const Switch& range, double touch, double lengths)
    : profile_(std::move(profile)),
      range_(range),
      touch_(touch),
      lengths_(lengths),
      innermost_(innermostShare * touch) {}

PairValue<double> SurfaceLaw::exact(double r) const {
  const AtGap p = profile_.p(r - touch_);
  return {lengths_ * p.value / r, lengths_ * (p.slope - p.value / r) / (r * r)};
}

PairValue<double> SurfaceLaw::operator()(double r2) const {
  if (r2 >= innermost_ * innermost_) return exact(std::sqrt(r2));
  PairValue<double> u = exact(innermost_);
  u.energy += 0.5 * u.slope * (r2 - innermost_ * innermost_);
  return u;
}

double SurfaceLaw::largestForce() const {
  // What attracts is strongest within the range, what repels at the innermost distance.
  double largest = 0;
  constexpr int parts = 1000;
  for (int k = 0; k <= parts; ++k) {
    const double r = innermost_ + (cutoff() - innermost_) * k / parts;
    largest = std::max(largest, std::abs(exact(r).slope * r));
  }
  return largest;
}

double SurfaceLaw::contactStiffness() const {
  double stiffest = 0;
  constexpr int parts = 1000;
  const double step = std::max(profile_.rest, profile_.width) / parts;
  auto force = [&](double r) { return exact(r).slope * r; };
  for (int k = 1; k < parts; ++k) {
    const double r = touch_ + k * step;
    stiffest = std::max(stiffest, (force(r + step) - force(r)) / step);
  }
  return stiffest;
}

PairTable SurfaceLaw::table() const {
  return PairTable({touch_ + profile_.join, touch_ + range_.from, cutoff(), profile_.miss},
                   [this](double r) { return (*this)(r * r).slope; });
}

}  // namespace nanoweft
