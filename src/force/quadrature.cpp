#include "nanoweft/force/quadrature.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/hertz.hpp"

namespace nanoweft {

namespace {

/// Rings of fibres around the one in the middle: 61 fibres.
constexpr int rings = 4;
constexpr std::uint32_t samples = 30;
/// Most point pairs of a segment with one neighbouring fibre for which the error is estimated.
constexpr double mostPointPairs = 2e4;

/// Endless straight fibres along x on a hexagonal grid, as relaxed fabrics have them: places vary
/// by 0.003 rf (0.02 A for the (10,10) tube), axes by 0.002 rad.
class Bundle {
 public:
  Bundle(const PairForce& pair, const Fibre& fibre)
      : pair_(pair), length_(fibre.length), rest_(pair.restDistance()), radius_(fibre.radius) {
    const int needed = pointsNeeded(length_, rest_, pair_.width().gap, nearSpacing);
    many_ = std::max(7, static_cast<int>(std::ceil(2.6 * needed)));
    const double row = (pair_.cutoff() / length_ + 2) * many_ * many_;
    if (!(row <= mostPointPairs)) return;
    const double spacing = restSpacing(fibre);
    for (int a = -rings; a <= rings; ++a)
      for (int b = -rings; b <= rings; ++b)
        if (std::abs(a + b) <= rings)
          places_.push_back({0, spacing * (a + 0.5 * b), spacing * std::sqrt(0.75) * b});
  }

  /// Does the law reach so far, or is it so narrow, that sums over the bundle would take minutes?
  bool tooLarge() const { return places_.empty(); }

  /// Force on one segment, as the run sums it and with many points.
  struct Forces {
    Vec3d asRun, exact;
  };
  Forces forces(std::uint32_t sample) const {
    Forces sum;
    // Each sample on another fibre, in the middle or at the edge.
    const std::size_t own = 7 * sample % places_.size();
    const Placed i = placed(places_[own], -1, sample);
    const double reach = pair_.cutoff() + length_;
    const int half = static_cast<int>(reach / length_) + 1;
    for (std::size_t fibre = 0; fibre < places_.size(); ++fibre) {
      const Vec3d across = places_[fibre] - places_[own];
      if (fibre == own || norm(across) > pair_.cutoff()) continue;
      const auto id = static_cast<std::int64_t>(1000 * fibre);
      const double shift = length_ * uniformPair(0, Purpose::errorEstimate, id, sample)[0];
      for (int k = -half; k <= half; ++k) {
        const Vec3d along{k * length_ + shift, 0, 0};
        const Placed j = placed(places_[fibre] + along, id + half + k, sample);
        const Vec3d separation = j.x - i.x;
        if (norm(separation) > reach) continue;
        sum.asRun += pair_.resolve(separation, i.q, j.q).force;
        sum.exact += pair_.average(many_, separation, axis1(i.q), axis1(j.q)).force;
      }
    }
    return sum;
  }

 private:
  struct Placed {
    Vec3d x;
    Quatd q;
  };

  Placed placed(const Vec3d& x, std::int64_t id, std::uint32_t sample) const {
    auto normal = [&](std::uint64_t what) {
      return normalDraw(what, Purpose::errorEstimate, id, sample);
    };
    return {x + (0.003 * radius_) * Vec3d{normal(1), normal(2), normal(3)},
            rotation({0.0, 0.002 * normal(4), 0.002 * normal(5)})};
  }

  /// Distance of neighbours with the least energy, or with the overlap of a soft repulsion.
  double restSpacing(const Fibre& fibre) const {
    if (rest_ <= fibre.diameter()) return fibre.diameter() - hertzOverlap * fibre.radius;
    auto energy = [&](double distance) {
      double sum = 0;
      const int half = static_cast<int>(pair_.cutoff() / length_) + 2;
      for (int k = -half; k <= half; ++k)
        sum += pair_.average(many_, {k * length_, distance, 0}, {1, 0, 0}, {1, 0, 0}).energy;
      return sum;
    };
    double low = 0.5 * (rest_ + fibre.diameter()), high = rest_;
    const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
    for (int k = 0; k < 25; ++k) {
      const double a = high - golden * (high - low), b = low + golden * (high - low);
      if (energy(a) < energy(b))
        high = b;
      else
        low = a;
    }
    return 0.5 * (low + high);
  }

  const PairForce& pair_;
  double length_, rest_, radius_;
  int many_;
  std::vector<Vec3d> places_;
};

}  // namespace

int pointsNeeded(double length, double distance, double gap, double spacing) {
  const double widest = spacing * std::sqrt(2.0 * distance * gap);
  return std::max(1, static_cast<int>(std::ceil(std::min(length / widest, 1e6) - 1e-9)));
}

double lawWidth(double restDistance, const Fibre& a, const Fibre& b) {
  const double gap = restDistance - (a.radius + b.radius);
  return gap > 0 ? gap : hertzOverlap * std::min(a.radius, b.radius);
}

std::optional<double> expectedForceError(const PairForce& pair, const Fibre& fibre) {
  if (!pair.keepsApart()) return std::nullopt;
  const Bundle bundle(pair, fibre);
  if (bundle.tooLarge()) return std::nullopt;
  double error = 0, size = 0;
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    const auto [asRun, exact] = bundle.forces(sample);
    error += dot(asRun - exact, asRun - exact);
    size += dot(exact, exact);
  }
  return size > 0 ? std::sqrt(error / size) : 0.0;
}

namespace {

/// Warnings about the points on segments of `own`.
void addPointWarnings(const Fibre& own, int points, const PairForce& pair, const UnitSystem& units,
                      std::vector<std::string>& warnings) {
  const double rest = pair.restDistance(), width = pair.width().gap;
  const int wanted = pointsNeeded(own.length, rest, width, pair.width().spacing),
            least = pointsNeeded(own.length, rest, width, coarsestSpacing);
  if (points < least)
    warnings.push_back(
        format("-pair_points %d: %.4g %s apart, too coarse for this law, whose forces are %.3g %s "
               "wide; take %d at least, or shorter segments",
               points, own.length / points, units.length, std::sqrt(2.0 * rest * width),
               units.length, least));
  else if (points == mostPairPoints && wanted > mostPairPoints)
    warnings.push_back(format(
        "this law would need %d points on a segment of %g %s, and %d are the most there "
        "are; -fibre_segment_length %.3g needs no more",
        wanted, own.length, units.length, mostPairPoints, own.length * mostPairPoints / wanted));
}

}  // namespace

std::vector<std::string> pointWarnings(const PairForce& pair, const Fibre& a, const Fibre& b,
                                       const UnitSystem& units) {
  std::vector<std::string> warnings;
  addPointWarnings(a, pair.points().near.i, pair, units, warnings);
  if (&a != &b) addPointWarnings(b, pair.points().near.j, pair, units, warnings);
  return warnings;
}

}  // namespace nanoweft
