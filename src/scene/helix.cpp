/// Scene `helix`: a helical spring along x of one fibre, or of several that are wound together.
#include <cmath>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/crowd.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

std::unique_ptr<Scene> makeHelixScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: helix", use != SceneUse::none, "-scene is not helix");
  const char* unit = context.units.length;
  const auto fibres =
      static_cast<int>(s.integer("helix_fibres", 1, "fibres that are wound together", 1, 10000));
  const auto segments = static_cast<int>(
      s.integer("helix_segments", 240,
                "segments of each fibre of the first kind; others are as long", 2, 100000000));
  auto mix = std::make_shared<KindMix>(s, "helix", context);
  const double radius =
      s.maybeReal("helix_radius", "7.5 segments", unit, "radius of the axes' helix", positive)
          .value_or(7.5 * context.kinds[0].length);
  const double pitch =
      s.maybeReal("helix_pitch", "3 segments a fibre", unit, "rise of a turn", positive)
          .value_or(3.0 * fibres * context.kinds[0].length);
  const bool shaped = readShaped(s, "helix");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  mix->draw(fibres);
  Laying laying{"helix", mix, fibres};
  laying.segments = [=](std::int64_t f) { return mix->segments(f, segments); };
  const double turn = std::hypot(2.0 * std::numbers::pi * radius, pitch);  // length of wire
  laying.line = [=](std::int64_t f) {
    const double start = 2.0 * std::numbers::pi * static_cast<double>(f) / fibres;
    const Curve curve = [=](double u) {
      const double angle = start + 2.0 * std::numbers::pi * u / turn;
      return Vec3d{pitch * u / turn, radius * std::cos(angle), radius * std::sin(angle)};
    };
    return Line{walk(curve, mix->fibre(f).length, mix->segments(f, segments))};
  };
  // Two turns show how near the wires come.
  std::vector<Line> lines;
  for (int f = 0; f < fibres; ++f) {
    lines.push_back(laying.line(f));
    const auto enough = static_cast<std::size_t>(2.0 * turn / mix->fibre(f).length) + 3;
    if (lines.back().points.size() > enough) lines.back().points.resize(enough);
  }
  if (const double found = tightest(lines, {mix->widest()}); found < 1.0 - 1e-9)
    throw InputError(
        format("-helix_radius %g, -helix_pitch %g: the wires come as near as %.2f of "
               "the gap of %g %s",
               radius, pitch, found, mix->widest(), unit));
  const double height = mix->length(segments) / turn * pitch, thick = mix->widest();
  laying.space = tubeSection(radius, thick) * height;
  laying.also = format(
      "counted in the tube that the wires lie in, %d segments each, %.4g turns, height %.5g %s",
      segments, mix->length(segments) / turn, height, unit);
  laying.shaped = shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
