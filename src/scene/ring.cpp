/// Scene `ring`: one fibre wound into a ring. Its windings lie side by side on a thin torus, around
/// which they turn once, so that a closed fibre meets its own beginning. An open one is a closed
/// one of which a few segments are left out, so that its ends do not touch.
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
  int leftOut;    ///< segments that would close it
  double length;  ///< of a segment

  int whole() const { return segments + leftOut; }
  double radius() const { return whole() * length / (twoPi * windings); }

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
    line.closed = leftOut == 0;
    double large = radius();
    // The radius follows from the chords that close the ring.
    for (int trial = 0; trial < 60; ++trial) {
      double chord = length;
      line.points = walkAround(curve(large, small), twoPi * windings * large, whole(), chord);
      if (std::abs(chord / length - 1.0) < 1e-12) break;
      large *= length / chord;
    }
    line.points.resize(static_cast<std::size_t>(segments));
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
  const bool closed = s.flag("ring_closed", true, "its last segment is bonded to the first");
  auto mix = std::make_shared<KindMix>(s, "ring", context, MixOptions{.shares = false});
  const bool shaped = readShaped(s, "ring");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  ring.length = mix->fibre(0).length;
  const double gap = mix->widest();
  double small = ring.windings > 1 ? 0.5 * gap / std::sin(std::numbers::pi / ring.windings) : 0.0;
  const std::string option = format("-ring_segments %d", ring.segments);
  if (ring.radius() < 3.0 * (small + gap))
    throw InputError(format(
        "%s: a ring of %d windings would have a radius of %.4g %s, and needs "
        "%.4g; take %.0f segments at least",
        option.c_str(), ring.windings, ring.radius(), context.units.length, 3.0 * (small + gap),
        std::ceil(3.0 * (small + gap) * twoPi * ring.windings / ring.length)));
  // More than a gap, since the ends are nearer than the arc between them is long.
  if (!closed) ring.leftOut = static_cast<int>(std::ceil(1.05 * gap / ring.length));
  if (ring.windings > 1)
    small *= scaleToFit([&](double scale) { return std::vector<Line>{ring.line(scale * small)}; },
                        {gap}, option);
  Laying laying{"ring", mix, 1};
  laying.segments = [=](std::int64_t) { return ring.segments; };
  laying.line = [=](std::int64_t) { return ring.line(small); };
  laying.space = std::numbers::pi * std::pow(small + 0.5 * gap, 2) * twoPi * ring.radius();
  laying.also =
      format("%d windings, radius %.5g %s", ring.windings, ring.radius(), context.units.length);
  laying.shaped = shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
