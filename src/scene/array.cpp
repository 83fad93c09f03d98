/// Scene `array`: a forest of fibres along z in square or hexagonal order, straight or wavy.
#include <cmath>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/scene/crowd.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

constexpr double twoPi = 2.0 * std::numbers::pi;

/// Waves of the fibres, to a side and with a phase by lot.
struct Wave {
  double amplitude = 0, length = 1;
  std::uint64_t seed = 0;

  Curve curve(std::int64_t fibre, const Vec3d& foot) const {
    const auto [a, b] = uniformPair(seed, Purpose::sceneShape, fibre, 0);
    const Vec3d side{amplitude * std::cos(twoPi * a), amplitude * std::sin(twoPi * a), 0};
    return [=, *this](double u) {
      return foot + Vec3d{0, 0, u} + std::sin(twoPi * (u / length + b)) * side;
    };
  }
};

}  // namespace

std::unique_ptr<Scene> makeArrayScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: array", use != SceneUse::none, "-scene is not array");
  const char* unit = context.units.length;
  std::array<std::int64_t, 2> count{10, 10};
  if (auto v = s.reals("array_fibres", 2, "10,10", "", "numbers of fibres along x and along y"))
    for (std::size_t d = 0; d < 2; ++d) {
      if ((*v)[d] != std::floor((*v)[d]) || (*v)[d] < 1 || (*v)[d] > 1e6)
        throw InputError("-array_fibres: needs two whole numbers from 1 to 1000000");
      count[d] = static_cast<std::int64_t>((*v)[d]);
    }
  const auto segments = static_cast<int>(
      s.integer("array_segments", 60,
                "segments of each fibre of the first kind; others are as long", 2, 100000000));
  const bool hexagonal = s.choice("array_packing", "hexagonal", {"hexagonal", "square"},
                                  "order of the feet") == "hexagonal";
  auto mix = std::make_shared<KindMix>(s, "array", context);
  const auto wantedSpacing = s.maybeReal("array_spacing", "three gaps", unit,
                                         "distance between neighbouring feet", positive);
  Wave wave{0, 1, context.seed};
  if (auto v = s.reals("array_wave", 2, "straight", unit, "amplitude and length of the waves"))
    wave.amplitude = (*v)[0], wave.length = (*v)[1];
  const bool periodic = s.flag("array_periodic", false, "periodic in x and y");
  if (wave.amplitude < 0 || !(wave.length > 0))
    throw InputError("-array_wave: needs an amplitude, not below zero, and a length above zero");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  const std::int64_t fibres = count[0] * count[1];
  mix->draw(fibres);
  const double gap = mix->widest(), spacing = wantedSpacing.value_or(3.0 * gap);
  // Neighbours may swing towards each other.
  if (spacing < gap + 2.0 * wave.amplitude)
    throw InputError(
        format("-array_spacing %g: needs %.5g %s, the gap and twice the amplitude of "
               "the waves",
               spacing, gap + 2.0 * wave.amplitude, unit));
  if (periodic && hexagonal && count[1] % 2 != 0)
    throw InputError("-array_fibres: a periodic hexagonal array needs an even number along y");
  const double row = hexagonal ? std::sqrt(0.75) * spacing : spacing;
  const std::array<double, 2> edges{static_cast<double>(count[0]) * spacing,
                                    static_cast<double>(count[1]) * row};
  Laying laying{"array", mix, fibres};
  laying.segments = [=](std::int64_t f) { return mix->segments(f, segments); };
  const double height = mix->length(segments);
  laying.line = [=](std::int64_t f) {
    const std::int64_t i = f % count[0], j = f / count[0];
    const double shift = hexagonal && j % 2 ? 0.5 : 0.0;
    const Vec3d middle{(static_cast<double>(i) + 0.25 + shift) * spacing,
                       (static_cast<double>(j) + 0.5) * row, 0.5 * height};
    return Line{walk(wave.curve(f, middle), mix->fibre(f).length, mix->segments(f, segments))};
  };
  if (periodic) {
    const double margin = 4.0 * context.kinds.longest();
    Box box;
    box.periodic = {true, true, false};
    box.lower = {0, 0, -margin};
    box.upper = {edges[0], edges[1], height + margin};
    laying.box = box;
  }
  laying.space = edges[0] * edges[1] * height;
  laying.also = format("%g %s apart", spacing, unit);
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
