/// Scene `ring`: one fibre wound into a ring. Its windings lie side by side on a thin torus, around
/// which they turn once, so that a closed fibre meets its own beginning.
#include <cmath>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/crowd.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

constexpr double twoPi = 2.0 * std::numbers::pi;

struct Ring {
  int segments, windings;
  bool closed;
  double length;  ///< of a segment

  /// The torus has the radii `large` and `small`; the parameter is length along the large circle.
  Curve curve(double large, double small) const {
    return [=, n = windings](double u) {
      const double angle = u / large, around = angle / n;
      const double r = large + small * std::cos(around);
      return Vec3d{r * std::cos(angle), r * std::sin(angle), small * std::sin(around)};
    };
  }

  Line line(double small) const {
    Line line;
    line.closed = closed;
    double large = segments * length / (twoPi * windings);
    if (!closed) {
      line.points = walk(curve(large, small), length, segments);
      return line;
    }
    // The radius follows from the chords that close the ring.
    for (int trial = 0; trial < 60; ++trial) {
      double chord = length;
      line.points = walkAround(curve(large, small), twoPi * windings * large, segments, chord);
      if (std::abs(chord / length - 1.0) < 1e-12) break;
      large *= length / chord;
    }
    return line;
  }
};

}  // namespace

std::unique_ptr<Scene> makeRingScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: ring", use != SceneUse::none, "-scene is not ring");
  Ring ring{};
  ring.segments =
      static_cast<int>(s.integer("ring_segments", 300, "segments of the fibre", 3, 100000000));
  ring.windings =
      static_cast<int>(s.integer("ring_windings", 3, "times that it goes around", 1, 10000));
  ring.closed = s.flag("ring_closed", true, "its last segment is bonded to the first");
  auto mix = std::make_shared<KindMix>(s, "ring", context, MixOptions{.shares = false});
  const bool shaped = readShaped(s, "ring");
  if (use != SceneUse::start) return nullptr;
  if (ring.windings == 1 && !ring.closed)
    throw InputError(
        "-ring_closed 0: with one winding both ends would be at one place; take -ring_windings 2, "
        "or -scene fibre for an arc");
  mix->prepare(context);
  ring.length = mix->fibre(0).length;
  const double gap = mix->widest(), radius = ring.segments * ring.length / (twoPi * ring.windings);
  double small = ring.windings > 1 ? 0.5 * gap / std::sin(std::numbers::pi / ring.windings) : 0.0;
  const std::string option = format("-ring_segments %d", ring.segments);
  if (radius < 3.0 * (small + gap))
    throw InputError(
        format("%s: a ring of %d windings would have a radius of %.4g %s, and needs "
               "%.4g; take %.0f segments at least",
               option.c_str(), ring.windings, radius, context.units.length, 3.0 * (small + gap),
               std::ceil(3.0 * (small + gap) * twoPi * ring.windings / ring.length)));
  if (ring.windings > 1)
    small *= scaleToFit([&](double scale) { return std::vector<Line>{ring.line(scale * small)}; },
                        {gap}, option);
  Laying laying{"ring", mix, 1};
  laying.segments = [=](std::int64_t) { return ring.segments; };
  laying.line = [=](std::int64_t) { return ring.line(small); };
  laying.space = std::numbers::pi * std::pow(small + 0.5 * gap, 2) * twoPi * radius;
  laying.also = format("%d windings, radius %.5g %s", ring.windings, radius, context.units.length);
  laying.shaped = shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
