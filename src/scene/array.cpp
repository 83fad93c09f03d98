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
    const auto draws = uniformPair(seed, Purpose::sceneShape, fibre, 0);
    const double direction = twoPi * draws[0], phase = draws[1];
    const Vec3d side{amplitude * std::cos(direction), amplitude * std::sin(direction), 0};
    return [=, *this](double u) {
      return foot + Vec3d{0, 0, u} + std::sin(twoPi * (u / length + phase)) * side;
    };
  }
};

struct Forest {
  std::array<std::int64_t, 2> count{10, 10};
  int segments = 60;
  bool hexagonal = true, periodic = false;
  std::optional<double> wantedSpacing;
  double spacing = 0;
  Wave wave;

  double row() const { return hexagonal ? std::sqrt(0.75) * spacing : spacing; }
  std::array<double, 2> edges() const {
    return {static_cast<double>(count[0]) * spacing, static_cast<double>(count[1]) * row()};
  }
  Vec3d foot(std::int64_t f) const {
    const std::int64_t i = f % count[0], j = f / count[0];
    const double shift = hexagonal && j % 2 ? 0.75 : 0.25;
    return {(static_cast<double>(i) + shift) * spacing, (static_cast<double>(j) + 0.5) * row(), 0};
  }
};

Forest readForest(OptionSection& s, const char* unit) {
  Forest p;
  if (auto v = s.reals("array_fibres", 2, "10,10", "", "numbers of fibres along x and along y"))
    for (std::size_t d = 0; d < 2; ++d) {
      if ((*v)[d] != std::floor((*v)[d]) || (*v)[d] < 1 || (*v)[d] > 1e6)
        throw InputError("-array_fibres: needs two whole numbers from 1 to 1000000");
      p.count[d] = static_cast<std::int64_t>((*v)[d]);
    }
  p.segments = static_cast<int>(
      s.integer("array_segments", 60,
                "segments of each fibre of the first kind; others are as long", 2, 100000000));
  p.hexagonal = s.choice("array_packing", "hexagonal", {"hexagonal", "square"},
                         "order of the feet") == "hexagonal";
  p.wantedSpacing = s.maybeReal("array_spacing", "three gaps", unit,
                                "distance between neighbouring feet", positive);
  if (auto v = s.reals("array_wave", 2, "straight", unit, "amplitude and length of the waves"))
    p.wave.amplitude = (*v)[0], p.wave.length = (*v)[1];
  p.periodic = s.flag("array_periodic", false, "periodic in x and y");
  if (p.wave.amplitude < 0 || !(p.wave.length > 0))
    throw InputError("-array_wave: needs an amplitude, not below zero, and a length above zero");
  if (p.periodic && p.hexagonal && p.count[1] % 2 != 0)
    throw InputError("-array_fibres: a periodic hexagonal array needs an even number along y");
  return p;
}

}  // namespace

std::unique_ptr<Scene> makeArrayScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: array", use != SceneUse::none, "-scene is not array");
  const char* unit = context.units.length;
  Forest p = readForest(s, unit);
  auto mix = std::make_shared<KindMix>(s, "array", context);
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  Laying laying{"array", mix, p.count[0] * p.count[1]};
  mix->draw(laying.fibres);
  p.wave.seed = context.seed;
  p.spacing = p.wantedSpacing.value_or(3.0 * mix->widest());
  // Neighbours may swing towards each other.
  if (const double least = mix->widest() + 2.0 * p.wave.amplitude; p.spacing < least)
    throw InputError(
        format("-array_spacing %g: needs %.5g %s, the gap and twice the amplitude of "
               "the waves",
               p.spacing, least, unit));
  laying.segments = [=](std::int64_t f) { return mix->segments(f, p.segments); };
  const double height = mix->length(p.segments);
  laying.line = [=](std::int64_t f) {
    const Vec3d middle = p.foot(f) + Vec3d{0, 0, 0.5 * height};
    return Line{walk(p.wave.curve(f, middle), mix->fibre(f).length, mix->segments(f, p.segments))};
  };
  const auto [wide, deep] = p.edges();
  if (p.periodic) {
    const double margin = 4.0 * context.kinds.longest();
    laying.box = Box{{0, 0, -margin}, {wide, deep, height + margin}, {true, true, false}};
  }
  laying.space = wide * deep * height;
  laying.also = format("%g %s apart", p.spacing, unit);
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
