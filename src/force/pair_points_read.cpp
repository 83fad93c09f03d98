/// The options of quadrature points, and their defaults by the width of the laws.
#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/force/pair_reader.hpp"
#include "nanoweft/force/quadrature.hpp"
#include "nanoweft/force/vdw.hpp"

namespace nanoweft {

namespace {

/// In units of lambda: the gap at rest, and the begin and width of the far range. Written so that
/// the (10,10) tube gets exactly 17.343571 A (rest distance), 30 A and 2 A, without round-off.
constexpr double restGap = 17.343571 / 6.78 - 2.0, farPlace = 30.0 / 6.78, farWidth = 2.0 / 6.78;

/// Centre distance of two parallel segments at rest whose ends are as far apart along them as the
/// law is wide; all in units of lambda.
double endsApart(double rest, double diameter, double length) {
  return std::hypot(rest, length + std::sqrt(2.0 * rest * (rest - diameter)));
}

/// Where far points begin to take over: 30 A for the (10,10) tube, for others as `endsApart`.
double farFrom(const PairReader& read, const VdwParameters& p) {
  const double length = 0.5 * (read.a.length + read.b.length);
  const double own = endsApart(restOf(p), read.touch() / p.length, length / p.length),
               ofTube = endsApart(2.0 + restGap, 2.0, 2.0);
  return own / ofTube * (farPlace * p.length);
}

/// Points of near and far pairs on the segments of one of the kinds.
struct OwnPoints {
  int near, far;
};

/// What the number of points of a law follows from.
struct PointNeed {
  double rest;
  LawWidth width;
  bool mayHaveFar;  ///< the options of far points are meant for this law
  double farFrom;   ///< where those may take over; infinite when never
};

OwnPoints readOwnPoints(const PairReader& read, const Fibre& f, const PointNeed& need) {
  const OptionPrefix prefix(read.options, f.kind);
  OptionSection s(read.options, PairReader::topic, !read.is("none"), "-pair is none");
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
  if (!need.mayHaveFar) return points;
  const double from = need.farFrom;
  const int few = std::min(points.near, needed(from, {from - read.touch(), farSpacing}));
  points.far = static_cast<int>(
      read.of("vdw")
          .maybeInteger("pair_far_points",
                        "by the law's width, 1 for cnt_10_10; as -pair_points where that is given",
                        "points per segment of pairs far apart", 1, points.near)
          .value_or(given || std::isinf(from) ? points.near : few));
  return points;
}

}  // namespace

double restOf(const VdwParameters& p) {
  const VdwParameters paper;
  if (p.a != paper.a || p.b != paper.b || p.alpha != paper.alpha || p.beta != paper.beta)
    return Vdw(p).restDistance() / p.length;
  return 2.0 * p.radius / p.length + restGap;
}

PointChoice readPoints(const PairReader& read, double rest, const VdwParameters& vdw) {
  const double from = farFrom(read, vdw), infinity = std::numeric_limits<double>::infinity();
  const bool ranged = read.is("vdw");
  const PointNeed need{rest,
                       {lawWidth(rest, read.a, read.b), ranged ? nearSpacing : softSpacing},
                       true,
                       ranged && from < vdw.cutoff ? from : infinity};
  const OwnPoints ofA = readOwnPoints(read, read.a, need),
                  ofB = read.mixed() ? readOwnPoints(read, read.b, need) : ofA;
  PointChoice points;
  points.near = {ofA.near, ofB.near};
  points.far = {ofA.far, ofB.far};
  const bool fewer = points.far != points.near;
  OptionSection far(
      read.options, PairReader::topic, ranged && fewer,
      ranged ? "-pair_far_points is not below -pair_points" : "-pair is " + read.laws());
  const char* unit = read.units.length;
  points.blend.from =
      far.maybeReal("pair_far_from",
                    "where ends of segments that touch are apart; 30 A for cnt_10_10", unit,
                    "centre distance from which -pair_far_points begin to take over", positive)
          .value_or(from);
  points.blend.to =
      points.blend.from + far.maybeReal("pair_far_width", "0.295 lambda; 2 A for cnt_10_10", unit,
                                        "width of the range in which they take over", positive)
                              .value_or(farWidth * vdw.length);
  if (!fewer) points.blend.from = points.blend.to = infinity;
  return points;
}

PointChoice nearPoints(const PairReader& read, double rest, const LawWidth& width) {
  const double infinity = std::numeric_limits<double>::infinity();
  const PointNeed need{rest, width, false, infinity};
  const int ofA = readOwnPoints(read, read.a, need).near,
            ofB = read.mixed() ? readOwnPoints(read, read.b, need).near : ofA;
  return {{ofA, ofB}, {ofA, ofB}, {infinity, infinity}};
}

}  // namespace nanoweft
