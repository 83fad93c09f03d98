/// The options of quadrature points, and their defaults by the width of the laws.
#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/pair_reader.hpp"
#include "nanoweft/force/quadrature.hpp"
#include "nanoweft/force/vdw.hpp"

namespace nanoweft {

namespace {

/// In units of lambda, the gap at rest. Written so that the (10,10) tube gets exactly 17.343571 A
/// (rest distance), without round-off.
constexpr double restGap = 17.343571 / 6.78 - 2.0;

/// Where the far part of a law may begin whose points are `spacing` apart on fibres that touch at
/// the distance `touch`: there a law is `sqrt(2 d g)` = spacing/farSpacing wide, d the distance and
/// g = d - touch.
double farFrom(double spacing, double touch) {
  const double width = spacing / farSpacing;
  return 0.5 * (touch + std::sqrt(touch * touch + 2.0 * width * width));
}

constexpr const char* byAccuracy = "-pair_accuracy chooses the points";

/// Points on the segments of one of the kinds.
struct OwnPoints {
  int near, far;
  bool asked = false;  ///< for the far ones
};

/// The options of far points; `fewer`: may there be fewer than near ones?
OptionSection farSection(const PairReader& read, const PointNeed& need, bool fewer) {
  return {read.options, PairReader::topic, need.switchFrom > 0 && fewer && !read.accuracy,
          read.accuracy         ? byAccuracy
          : need.switchFrom > 0 ? "-pair_far_points is not below -pair_points"
                                : "-pair is " + read.laws()};
}

/// `far`: are the options of far points meant for this law?
OwnPoints readOwnPoints(const PairReader& read, const Fibre& f, const PointNeed& need, bool far) {
  const OptionPrefix prefix(read.options, f.kind);
  OptionSection s(read.options, PairReader::topic, read.usesPoints() && !read.accuracy,
                  read.accuracy ? byAccuracy : "-pair is " + read.laws());
  auto needed = [&](double distance, const LawWidth& width) {
    const int points = pointsNeeded(f.length, distance, width.gap, width.spacing);
    // A few points too little are better than a kernel that takes any number of them.
    if (points > mostCompiledPoints && !read.mixed() &&
        pointsNeeded(f.length, distance, width.gap, softSpacing) <= mostCompiledPoints)
      return mostCompiledPoints;
    return std::min(mostPairPoints, points);
  };
  OwnPoints points;
  const auto given = s.maybeInteger("pair_points", "by the law's width; 5 for cnt_10_10",
                                    "points per segment", 1, mostPairPoints);
  points.near = given ? static_cast<int>(*given) : needed(need.rest, need.width);
  points.far = points.near;
  if (!far) return points;
  int few = 1;
  while (few < points.near && farFrom(f.length / few, read.touch()) >= need.switchFrom) ++few;
  const auto asked = farSection(read, need, true)
                         .maybeInteger("pair_far_points",
                                       "by the law's width, 1 for cnt_10_10; as -pair_points where "
                                       "that is given",
                                       "points per segment of the law's far part", 1, points.near);
  points.far = static_cast<int>(asked.value_or(given ? points.near : few));
  points.asked = asked.has_value();
  return points;
}

}  // namespace

double restOf(const VdwParameters& p) {
  const VdwParameters paper;
  if (p.a != paper.a || p.b != paper.b || p.alpha != paper.alpha || p.beta != paper.beta)
    return Vdw(p).restDistance() / p.length;
  return 2.0 * p.radius / p.length + restGap;
}

PointChoice readPoints(const PairReader& read, const PointNeed& need) {
  const OwnPoints ofA = readOwnPoints(read, read.a, need, true),
                  ofB = read.mixed() ? readOwnPoints(read, read.b, need, true) : ofA;
  PointChoice points;
  points.near = {ofA.near, ofB.near};
  points.far = {ofA.far, ofB.far};
  OptionSection far = farSection(read, need, points.split());
  const double spacing = std::max(read.a.length / ofA.far, read.b.length / ofB.far),
               usual = std::max(farFrom(spacing, read.touch()),
                                need.rest + 0.4 * (need.switchFrom - need.rest));
  const auto given = far.maybeReal(
      "pair_far_from", "by the points' spacing; 27.12 A for cnt_10_10", read.units.length,
      "distance of axes within which the law's far part is a mere spring and its near part makes "
      "up the rest",
      positive);
  if (!points.split()) return points;
  points.from = given.value_or(usual);
  if (points.from > need.rest && points.from < need.switchFrom) return points;
  if (given || ofA.asked || ofB.asked)
    throw InputError(format(
        "%s %g: must lie between the distance at rest, %g, and where the law's switch begins, %g "
        "%s",
        read.option("pair_far_from").c_str(), points.from, need.rest, need.switchFrom,
        read.units.length));
  return {points.near, points.near};
}

PointChoice nearPoints(const PairReader& read, const PointNeed& need) {
  const int ofA = readOwnPoints(read, read.a, need, false).near,
            ofB = read.mixed() ? readOwnPoints(read, read.b, need, false).near : ofA;
  return {{ofA, ofB}, {ofA, ofB}};
}

}  // namespace nanoweft
