/// Scene `weave`: two families of fibres, along x and along y, that pass over and under each other.
/// Other patterns than the plain one of single fibres in one layer are in fabric.cpp. The plain one
/// (model.md 8):
///
/// Each fibre follows z = +-A cos(pi (s/p - 1/2)) with the pitch p between crossings, so that at a
/// crossing the two are 2A apart: -weave_gap, by default the distance where two fibres rest.
/// Segments are set along the curve one bond length (chord) after another, so bonds start
/// unstretched and fibres cover less ground than their length.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/fabric.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

using std::numbers::pi;

/// How steeply fibres may pass from one side to the other.
constexpr double steepest = 0.8;

/// One fibre's centre line in its own plane: s along the family's direction, z up.
class Wave {
 public:
  Wave(double amplitude, double pitch) : amplitude_(amplitude), pitch_(pitch) {}

  double height(double s) const { return amplitude_ * std::cos(pi * (s / pitch_ - 0.5)); }

  /// From one crossing to the next.
  double length() const {
    constexpr int parts = 100;
    double sum = 0;
    for (int k = 0; k < parts; ++k)
      sum +=
          std::hypot(pitch_ / parts, height(pitch_ * (k + 1) / parts) - height(pitch_ * k / parts));
    return sum;
  }

  /// The place one chord further along.
  double next(double s, double chord) const {
    double low = s, high = s + chord;
    // The distance grows from 0 to at least a chord in between.
    for (int k = 0; k < 60 && high - low > 1e-15 * pitch_; ++k) {
      const double middle = 0.5 * (low + high);
      (std::hypot(middle - s, height(middle) - height(s)) < chord ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  std::vector<double> walk(double from, double chord, int points) const {
    std::vector<double> s{from};
    while (static_cast<int>(s.size()) < points) s.push_back(next(s.back(), chord));
    return s;
  }

 private:
  double amplitude_, pitch_;
};

/// Root of an increasing function between two places.
template <class F>
double bisect(double low, double high, const F& f) {
  for (int k = 0; k < 100 && high - low > 1e-15 * std::abs(high); ++k) {
    const double middle = 0.5 * (low + high);
    (f(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The places of the segments of one family's fibres, measured from the first crossing less half a
/// pitch.
struct Family {
  double pitch = 0;  ///< between the crossings along these fibres
  int crossings = 0;
  std::vector<double> places;
};

struct WeaveParameters {
  int alongX = 20, alongY = 20, segments = 100;
  double pitch = 0;  ///< 0: as the segments allow
  double gap = 0;
  bool periodic = false;
  int kindX = 0, kindY = 0;
  bool shaped = false;  ///< the woven shape is that of rest
};

class WeaveScene final : public Scene {
 public:
  WeaveScene(const WeaveParameters& p, const SceneContext& context)
      : p_(p),
        amplitude_(0.5 * p.gap),
        longest_(std::max(context.kinds[p.kindX].length, context.kinds[p.kindY].length)),
        unit_(context.units.length) {
    auto volume = [&](int kind, int fibres) {
      const Fibre& f = context.kinds[kind];
      return pi * f.radius * f.radius * f.length * p.segments * fibres;
    };
    volume_ = volume(p.kindX, p.alongX) + volume(p.kindY, p.alongY);
    x_ = family(p.alongY, context.kinds[p.kindX].length, "x");
    y_ = family(p.alongX, context.kinds[p.kindY].length, "y");
  }

  Box box() const override {
    Box box;
    const double margin = 4.0 * longest_;
    const Family* families[2] = {&x_, &y_};
    for (std::size_t d = 0; d < 2; ++d) {
      const Family& f = *families[d];
      const double span = f.crossings * f.pitch;
      box.periodic[d] = p_.periodic;
      box.lower[d] = p_.periodic ? 0.0 : std::min(0.0, f.places.front()) - margin;
      box.upper[d] = p_.periodic ? span : std::max(span, f.places.back()) + margin;
    }
    box.lower[2] = -amplitude_ - margin;
    box.upper[2] = amplitude_ + margin;
    return box;
  }

  StartRequest asked() const override {
    // Fibres of few segments between crossings are bent at them.
    return {0, pi, 0};
  }
  bool shapesRest() const override { return p_.shaped; }
  std::string packing(const Box& own) const override {
    // As of the other patterns: the area that the crossings take, times the thickness.
    const double thickness = 4.0 * amplitude_, space = x_.crossings * x_.pitch * y_.crossings *
                                                       y_.pitch * thickness * spread(box(), own);
    return format(
        "scene weave: %d fibres, volume fraction %.4g, %.4g fibres a %s^3, pitch "
        "%.5g,%.5g %s, thickness %.5g %s",
        p_.alongX + p_.alongY, volume_ / space, (p_.alongX + p_.alongY) / space, unit_, x_.pitch,
        y_.pitch, unit_, thickness, unit_);
  }
  void fill(State& state) const override {
    fillFibres(state, p_.alongX + p_.alongY, p_.segments, [&](std::int64_t f) {
      const bool alongX = f < p_.alongX;
      const auto number = static_cast<int>(alongX ? f : f - p_.alongX);
      return make(alongX, number);
    });
  }

 private:
  /// `length`: of a segment.
  Family family(int crossings, double length, const char* direction) const {
    Family f;
    f.crossings = crossings;
    const double shortest = 0.2 * length * p_.segments / crossings,
                 longest = length * p_.segments / crossings;
    auto covers = [&](double pitch) {
      const Wave wave(amplitude_, pitch);
      return crossings * pitch - wave.walk(0.0, length, p_.segments + 1).back();
    };
    const double natural = bisect(shortest, longest, covers);
    f.pitch = p_.pitch > 0 ? p_.pitch : natural;
    if (const double least = pi * amplitude_ / steepest; f.pitch < least) {
      // Along a wave of that pitch.
      const double way = Wave(amplitude_, least).length();
      throw InputError(format(
          "-weave_%s: crossings %.4g %s apart are too steep for fibres that pass each other at "
          "%.4g; %.4g at least, which takes %.0f segments",
          p_.pitch > 0 ? "pitch" : "segments", f.pitch, unit_, p_.gap, least,
          std::ceil(crossings * way / length)));
    }
    const double span = crossings * f.pitch;
    const Wave wave(amplitude_, f.pitch);
    if (p_.periodic) {
      double chord = length;
      if (p_.pitch > 0) {
        chord = bisect(0.5 * length, 2.0 * length,
                       [&](double c) { return wave.walk(0.0, c, p_.segments + 1).back() - span; });
        if (const double strain = chord / length - 1.0; std::abs(strain) > 0.01)
          throw InputError(
              format("-weave_pitch %g: in a periodic weave this strains the bonds along %s by %.1f "
                     "%%; %g %s "
                     "leaves them unstretched",
                     p_.pitch, direction, 100 * strain, natural, unit_));
      }
      f.places = wave.walk(0.0, chord, p_.segments);
      return f;
    }
    // Centre the fibre on the piece.
    const double guess = 0.5 * (span - natural * crossings);
    const double first = bisect(guess - f.pitch, guess + f.pitch, [&](double from) {
      const auto s = wave.walk(from, length, p_.segments);
      return s.front() + s.back() - span;
    });
    f.places = wave.walk(first, length, p_.segments);
    if (f.places.back() - f.places.front() < (crossings - 1) * f.pitch)
      throw InputError(format(
          "-weave_segments %d: fibres do not reach across %d crossings %g %s apart%s", p_.segments,
          crossings, f.pitch, unit_,
          p_.pitch > 0 ? format("; they could with -weave_pitch %.6g", natural).c_str() : ""));
    return f;
  }

  FibreGeometry make(bool alongX, int number) const {
    const Family& f = alongX ? x_ : y_;
    const Family& other = alongX ? y_ : x_;
    const double side = (number + 0.5) * other.pitch;
    // Over where the other family is under: the sign alternates from fibre to fibre.
    const double sign = (number % 2 == 0 ? 1.0 : -1.0) * (alongX ? 1.0 : -1.0);
    const Wave wave(sign * amplitude_, f.pitch);
    const int n = p_.segments;
    auto point = [&](int k) {
      if (p_.periodic && (k < 0 || k >= n)) {
        const double s = f.places[static_cast<std::size_t>((k + n) % n)] +
                         (k < 0 ? -1 : 1) * f.crossings * f.pitch;
        return Vec3d{s, 0.0, wave.height(s)};
      }
      const double s = f.places[static_cast<std::size_t>(k)];
      return Vec3d{s, 0.0, wave.height(s)};
    };
    FibreGeometry g;
    g.closed = p_.periodic;
    g.kind = alongX ? p_.kindX : p_.kindY;
    std::vector<Vec3d> tangent(static_cast<std::size_t>(n));
    auto unit = [](const Vec3d& v) { return (1.0 / norm(v)) * v; };
    const int firstInner = p_.periodic ? 0 : 1, lastInner = p_.periodic ? n - 1 : n - 2;
    for (int k = firstInner; k <= lastInner; ++k)
      tangent[static_cast<std::size_t>(k)] = unit(point(k + 1) - point(k - 1));
    if (!p_.periodic) {
      // End segments lean against their chord as their neighbours do: bending without shear.
      auto mirrored = [&](const Vec3d& e, const Vec3d& chord) {
        return unit(2.0 * dot(e, chord) * chord - e);
      };
      const auto last = static_cast<std::size_t>(n - 1);
      tangent[0] = mirrored(tangent[1], unit(point(1) - point(0)));
      tangent[last] = mirrored(tangent[last - 1], unit(point(n - 1) - point(n - 2)));
    }
    for (int k = 0; k < n; ++k) {
      const Vec3d x = point(k), t = tangent[static_cast<std::size_t>(k)];
      if (alongX) {
        const Vec3d e2{0, 1, 0};
        g.position.push_back({x.x, side, x.z});
        g.orientation.push_back(quaternionFromAxes(t, e2, cross(t, e2)));
      } else {
        const Vec3d e1{0, t.x, t.z}, e2{-1, 0, 0};
        g.position.push_back({side, x.x, x.z});
        g.orientation.push_back(quaternionFromAxes(e1, e2, cross(e1, e2)));
      }
    }
    if (p_.shaped) g.rest = restOf(g);
    return g;
  }

  /// The rotations from each segment to the next as they are.
  static std::vector<Vec3d> restOf(const FibreGeometry& g) {
    std::vector<Vec3d> rest(g.orientation.size(), Vec3d{0, 0, 0});
    const std::size_t bonds = g.closed ? rest.size() : rest.size() - 1;
    for (std::size_t k = 0; k < bonds; ++k) {
      const Quatd &q = g.orientation[k], &next = g.orientation[(k + 1) % rest.size()];
      rest[k] = rotationVector(Quatd{q.w, -q.x, -q.y, -q.z} * next);
    }
    return rest;
  }

  WeaveParameters p_;
  double amplitude_, longest_, volume_;
  const char* unit_;
  Family x_, y_;
};

}  // namespace

std::unique_ptr<Scene> makeWeaveScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: weave", use != SceneUse::none, "-scene is not weave");
  WeaveParameters p;
  if (auto v = s.reals("weave_fibres", 2, "20,20", "", "numbers of fibres along x and along y")) {
    for (double n : *v)
      if (n != std::floor(n) || n < 1 || n > 1e6)
        throw InputError("-weave_fibres: needs two whole numbers from 1 to 1000000");
    p.alongX = static_cast<int>((*v)[0]);
    p.alongY = static_cast<int>((*v)[1]);
  }
  p.segments =
      static_cast<int>(s.integer("weave_segments", 100, "segments of each fibre", 3, 100000000));
  const auto kinds = readSceneKinds(s, "weave_kinds", context.kinds, 2);
  p.kindX = kinds[0];
  p.kindY = kinds[1];
  p.pitch = s.maybeReal("weave_pitch", "so that the fibres just cover the piece",
                        context.units.length, "distance between neighbouring fibres", positive)
                .value_or(0.0);
  const auto gap = s.maybeReal("weave_gap", "rest distance of the pair law", context.units.length,
                               "distance between the two fibres at a crossing", positive);
  p.periodic = s.flag("weave_periodic", false, "periodic in x and y, every fibre closed on itself");
  p.shaped =
      s.choice("weave_rest", "straight", {"straight", "shaped"},
               "shape of the fibres at rest: that of their kind, or the woven one") == "shaped";
  FabricParameters fabric = readFabric(s);
  if (use != SceneUse::start) return nullptr;
  p.gap = gap.value_or(context.restDistance(p.kindX, p.kindY));
  if (fabric.asked()) {
    // Tows have fibres of their own kind beside them, too.
    if (!gap)
      for (const int k : {p.kindX, p.kindY}) p.gap = std::max(p.gap, context.restDistance(k, k));
    fabric.count = {p.alongX, p.alongY};
    fabric.segments = p.segments, fabric.kinds = {p.kindX, p.kindY};
    fabric.pitch = p.pitch, fabric.gap = p.gap;
    fabric.periodic = p.periodic, fabric.shaped = p.shaped;
    return makeFabric(fabric, context);
  }
  if (p.periodic && (p.alongX % 2 || p.alongY % 2))
    throw InputError("-weave_fibres: a periodic plain weave needs even numbers");
  const double total = static_cast<double>(p.alongX + p.alongY) * p.segments;
  if (total > 2147483647.0)
    throw InputError("-weave_fibres, -weave_segments: more than 2^31 - 1 segments");
  return std::make_unique<WeaveScene>(p, context);
}

}  // namespace nanoweft
