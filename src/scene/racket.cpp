/// Scene `racket`: a fibre folded on itself. Its two arms lie side by side, the handle; between
/// them it turns through a loop of two equal arcs and one against them at either side of the neck.
#include <cmath>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/crowd.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

using std::numbers::pi;

/// The upper half by its length from the tip of the loop on; the lower half is its mirror image.
Curve racketCurve(double radius, double apart) {
  // Arcs of one radius: away from the handle by `turn`, then around to the tip.
  const double turn = std::acos((0.5 * apart + radius) / (2.0 * radius)), around = turn + 0.5 * pi,
               loop = radius * (around + turn);
  const double centre = 2.0 * radius * std::sin(turn);  // of the loop, from the neck
  return [=](double u) {
    const double s = std::abs(u), sign = u < 0 ? 1.0 : -1.0;
    if (s <= radius * around) {
      const double angle = s / radius;
      return Vec3d{centre + radius * std::cos(angle), sign * radius * std::sin(angle), 0};
    }
    if (s <= loop) {
      const double angle = (loop - s) / radius;
      return Vec3d{radius * std::sin(angle),
                   sign * (0.5 * apart + radius * (1.0 - std::cos(angle))), 0};
    }
    return Vec3d{loop - s, sign * 0.5 * apart, 0};
  };
}

double loopOf(double radius, double apart) {
  const double turn = std::acos((0.5 * apart + radius) / (2.0 * radius));
  return 2.0 * radius * (2.0 * turn + 0.5 * pi);
}

/// Of the plane strip as wide as the gap along the fibre and what it encloses.
double areaWithin(const Line& line, double gap, double length) {
  double twice = 0;
  Vec3d last = line.points.back();
  for (const Vec3d& x : line.points) {
    twice += cross(last, x).z;
    last = x;
  }
  return 0.5 * (std::abs(twice) + gap * length);
}

}  // namespace

std::unique_ptr<Scene> makeRacketScene(Options& options, const SceneContext& context,
                                       SceneUse use) {
  OptionSection s(options, "Scene: racket", use != SceneUse::none, "-scene is not racket");
  const auto segments =
      static_cast<int>(s.integer("racket_segments", 300, "segments of the fibre", 3, 100000000));
  const auto wanted = s.maybeReal("racket_loop", "a third of the fibre", context.units.length,
                                  "length of fibre in the loop", positive);
  auto mix = std::make_shared<KindMix>(s, "racket", context, MixOptions{.shares = false});
  const bool shaped = readShaped(s, "racket");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  const double gap = mix->widest(), length = mix->length(segments),
               loop = wanted.value_or(length / 3.0), least = loopOf(1.5 * gap, gap);
  if (loop < least || loop > length)
    throw InputError(
        format("-racket_loop %g: must be %.4g (three times the gap wide) to %.4g %s "
               "(the whole fibre)",
               loop, least, length, context.units.length));
  double low = 1.5 * gap, high = loop;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (loopOf(middle, gap) < loop ? low : high) = middle;
  }
  Laying laying{"racket", mix, 1};
  laying.segments = [=](std::int64_t) { return segments; };
  laying.line = [curve = racketCurve(low, gap), segments, T = mix->fibre(0).length](std::int64_t) {
    return Line{walk(curve, T, segments)};
  };
  laying.space = gap * areaWithin(laying.line(0), gap, length);
  laying.also = format(
      "counted in the plate within its outline, loop of %.5g %s, radius %.5g %s, handle of two "
      "arms "
      "of %.5g %s",
      loop, context.units.length, low, context.units.length, 0.5 * (length - loop),
      context.units.length);
  laying.shaped = shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
