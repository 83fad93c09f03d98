#include "nanoweft/force/quadrature.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/test_bundle.hpp"

namespace nanoweft {

namespace {

constexpr std::uint32_t samples = 30;
/// Most point pairs of a segment with one neighbouring fibre for which the error is estimated.
constexpr double mostPointPairs = 2e4;

/// Force on one segment, as the run sums it and with many points.
struct Forces {
  Vec3d asRun, exact;
};

struct Placed {
  Vec3d x;
  Quatd q;
};

/// The pair force with the numbers of points that are compared, and the disorder of a relaxed
/// fabric: places vary by 0.003 rf (0.02 A for the (10,10) tube), or of 2.2 of the gaps that fibres
/// keep where that is less, since forces change over gaps; ends about the places by two thirds of
/// it (0.002 rad where T = 2 rf).
class Comparison {
 public:
  Comparison(const PairForce& pair, const Fibre& fibre)
      : pair_(pair), fibre_(fibre), rest_(pair.restDistance()) {
    const int needed = pointsNeeded(fibre.length, rest_, pair_.width().gap, nearSpacing);
    many_ = std::max({7, static_cast<int>(std::ceil(2.6 * needed)), 2 * pair.points().near.i});
  }

  /// Does the law reach so far, or is it so narrow, that sums would take minutes?
  bool tooLarge() const {
    return !((pair_.cutoff() / length() + 2) * many_ * many_ <= mostPointPairs);
  }
  double length() const { return fibre_.length; }
  double cutoff() const { return pair_.cutoff(); }
  /// Segments on either side of a place that its force reaches.
  int half() const { return static_cast<int>(pair_.cutoff() / length()) + 2; }

  void add(const Placed& i, const Placed& j, Forces& sum) const {
    const Vec3d separation = j.x - i.x;
    if (norm(separation) > pair_.cutoff() + length()) return;
    sum.asRun += pair_.resolve(separation, i.q, j.q).force;
    sum.exact += pair_.average(many_, separation, axis1(i.q), axis1(j.q)).force;
  }

  Placed placed(const Vec3d& x, const Quatd& q, std::int64_t id, std::uint32_t sample) const {
    auto normal = [&](std::uint64_t what) {
      return normalDraw(what, Purpose::errorEstimate, id, sample);
    };
    const double gap = rest_ - fibre_.diameter();
    const double disorder = 0.003 * (gap > 0 ? std::min(fibre_.radius, 2.2 * gap) : fibre_.radius),
                 turn = 2.0 / 3.0 * disorder / (0.5 * length());
    return {x + disorder * Vec3d{normal(1), normal(2), normal(3)},
            q * rotation({0.0, turn * normal(4), turn * normal(5)})};
  }

  /// Distance with the least energy, or with the overlap of a soft repulsion, of two endless
  /// straight fibres, one along x; `along`: direction of the other, `across`: of the distance.
  double restSpacing(const Vec3d& along, const Vec3d& across) const {
    if (rest_ <= fibre_.diameter()) return fibre_.diameter() - hertzOverlap * fibre_.radius;
    auto energy = [&](double distance) {
      double sum = 0;
      const bool crossed = along.y != 0;
      for (int k = -half(); k <= half(); ++k)
        for (int l = crossed ? -half() : 0; l <= (crossed ? half() : 0); ++l)
          sum +=
              pair_
                  .average(many_,
                           distance * across + (k * length()) * along - Vec3d{l * length(), 0, 0},
                           {1, 0, 0}, along)
                  .energy;
      return sum;
    };
    double low = 0.5 * (rest_ + fibre_.diameter()), high = rest_;
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

 private:
  const PairForce& pair_;
  const Fibre& fibre_;
  double rest_;
  int many_;
};

/// Sums squares of errors and of forces.
class Rms {
 public:
  void add(const Forces& f) {
    error_ += dot(f.asRun - f.exact, f.asRun - f.exact);
    size_ += dot(f.exact, f.exact);
  }
  double value() const { return size_ > 0 ? std::sqrt(error_ / size_) : 0.0; }

 private:
  double error_ = 0, size_ = 0;
};

/// In endless straight fibres along x on a hexagonal grid, on segments in the middle or at the
/// edge.
double errorInBundle(const Comparison& c) {
  std::vector<Vec3d> places;
  const double spacing = c.restSpacing({1, 0, 0}, {0, 1, 0});
  for (const auto& [a, b] : bundlePlaces())
    places.push_back({0, spacing * (a + 0.5 * b), spacing * std::sqrt(0.75) * b});
  Rms rms;
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    const std::size_t own = 7 * sample % places.size();
    const Placed i = c.placed(places[own], Quatd{}, -1, sample);
    Forces sum;
    for (std::size_t fibre = 0; fibre < places.size(); ++fibre) {
      if (fibre == own || norm(places[fibre] - places[own]) > c.cutoff()) continue;
      const auto id = static_cast<std::int64_t>(1000 * fibre);
      const double shift = c.length() * uniformPair(0, Purpose::errorEstimate, id, sample)[0];
      for (int k = -c.half(); k <= c.half(); ++k)
        c.add(i,
              c.placed(places[fibre] + Vec3d{k * c.length() + shift, 0, 0}, Quatd{},
                       id + c.half() + k, sample),
              sum);
    }
    rms.add(sum);
  }
  return rms.value();
}

/// On the segments of a fibre along x where one along y at rest lies across it.
double errorAtCrossing(const Comparison& c) {
  const double distance = c.restSpacing({0, 1, 0}, {0, 0, 1});
  const Quatd across{std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  Rms rms;
  for (std::uint32_t sample = 0; sample < samples; ++sample) {
    const auto shift = uniformPair(1, Purpose::errorEstimate, 0, sample);
    for (int k = -2; k <= 2; ++k) {
      const Placed i =
          c.placed({(k + shift[0] - 0.5) * c.length(), 0, 0}, Quatd{}, 1000 + k, sample);
      Forces sum;
      for (int l = -c.half(); l <= c.half(); ++l)
        c.add(i,
              c.placed({0, (l + shift[1] - 0.5) * c.length(), distance}, across, 2000 + l, sample),
              sum);
      rms.add(sum);
    }
  }
  return rms.value();
}

}  // namespace

int pointsNeeded(double length, double distance, double gap, double spacing) {
  const double widest = spacing * std::sqrt(2.0 * distance * gap);
  return std::max(1, static_cast<int>(std::ceil(std::min(length / widest, 1e6) - 1e-9)));
}

double lawWidth(double restDistance, const Fibre& a, const Fibre& b) {
  const double gap = restDistance - (a.radius + b.radius);
  return gap > 0 ? gap : hertzOverlap * std::min(a.radius, b.radius);
}

std::optional<ForceErrors> expectedForceErrors(const PairForce& pair, const Fibre& fibre) {
  if (!pair.keepsApart()) return std::nullopt;
  const Comparison comparison(pair, fibre);
  if (comparison.tooLarge()) return std::nullopt;
  return ForceErrors{errorInBundle(comparison), errorAtCrossing(comparison)};
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
  const double apart = pair.exclude() * a.length - 2.0 * pair.pointSpan().i;
  if (&a == &b && pair.keepsApart() && apart < pair.restDistance())
    warnings.push_back(format(
        "-pair_exclude %d: within a straight fibre, too, segments so near repel each other, so it "
        "stretches; take %d at least",
        pair.exclude(),
        static_cast<int>(std::ceil((pair.restDistance() + 2.0 * pair.pointSpan().i) / a.length))));
  if (&a != &b) addPointWarnings(b, pair.points().near.j, pair, units, warnings);
  // Within one kind the error that the header expects tells. From where the far part begins, it is
  // as wide as a law with that gap.
  if (pair.points().split() && &a != &b) {
    const double from = pair.points().from, gap = from - (a.radius + b.radius);
    auto look = [&](const Fibre& own, int points) {
      const int least = pointsNeeded(own.length, from, gap, coarsestSpacing);
      if (points < least)
        warnings.push_back(
            format("-%s_pair_far_points %d: %.4g %s apart, too coarse from %.4g %s on, where the "
                   "law's far part begins; take %d at least, or a larger -%s_%s_pair_far_from",
                   own.kind.c_str(), points, own.length / points, units.length, from, units.length,
                   least, a.kind.c_str(), b.kind.c_str()));
    };
    look(a, pair.points().far.i);
    look(b, pair.points().far.j);
  }
  return warnings;
}

}  // namespace nanoweft
