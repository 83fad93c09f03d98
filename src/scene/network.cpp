/// Scene `network`: straight or worm-like fibres with places and directions by lot in a periodic
/// box, laid one after another where they overlap none before them.
///
/// Where a fibre fits depends on those before it, so every rank lays all of them: 24 bytes and a
/// piece of the crowd a segment.
#include <cmath>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/scenes.hpp"
#include "nanoweft/scene/worm.hpp"

namespace nanoweft {

std::unique_ptr<Scene> makeNetworkScene(Options& options, const SceneContext& context,
                                        SceneUse use) {
  OptionSection s(options, "Scene: network", use != SceneUse::none, "-scene is not network");
  const char* unit = context.units.length;
  const auto edges =
      s.reals("network_size", 3, "75 segments each way", unit, "edges of the periodic box");
  const auto count =
      s.maybeInteger("network_fibres", "by the fraction", "number of fibres", 1, 100000000);
  const double fraction =
      s.real("network_fraction", 0.01, "", "volume fraction of the fibres", {0.0, 1.0, true});
  const auto segments = static_cast<int>(
      s.integer("network_segments", 50,
                "segments of each fibre of the first kind; others are as long", 2, 1000000));
  const double persistence = readPersistence(s, "network", context);
  auto mix = std::make_shared<KindMix>(s, "network", context);
  if (count && s.given("network_fraction"))
    throw InputError("-network_fibres and -network_fraction: give one of them");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  Box box;
  for (std::size_t d = 0; d < 3; ++d) {
    box.periodic[d] = true;
    box.upper[d] = edges ? (*edges)[d] : 75.0 * context.kinds[0].length;
    if (!(box.upper[d] > 0)) throw InputError("-network_size: needs three lengths above zero");
  }
  const double space = box.upper[0] * box.upper[1] * box.upper[2];
  const std::int64_t fibres =
      count ? *count : std::lround(fraction * space / mix->volume(segments));
  if (fibres < 1)
    throw InputError(
        format("-network_fraction %g: is not one fibre of %d segments in a box of %.5g x %.5g x "
               "%.5g %s",
               fraction, segments, box.upper[0], box.upper[1], box.upper[2], unit));
  requireMemory(context.comm, fibres * segments, sizeof(Vec3d) + sizeof(LaidPiece));
  mix->draw(fibres);
  Crowd crowd(box, mix->widest() + context.kinds.longest());
  auto lines = std::make_shared<std::vector<Line>>();
  double laid = 0;
  for (std::int64_t f = 0; f < fibres; ++f) {
    const Fibre& fibre = mix->fibre(f);
    const Worm worm{f,  mix->of(f),  mix->segments(f, segments), fibre.length, persistence,
                    {}, context.seed};
    auto line = growWorm(crowd, box, worm,
                         [&](const LaidPiece& piece) { return crowded(crowd, piece, *mix); });
    if (!line)
      throw InputError(format(
          "-scene network: no place for fibre %lld of %lld in %d trials; the %lld before it fill a "
          "fraction of %.4g (at %.4g %s between axes)",
          static_cast<long long>(f + 1), static_cast<long long>(fibres), wormTrials,
          static_cast<long long>(f), laid / space, mix->widest(), unit));
    laid += std::numbers::pi * fibre.radius * fibre.radius * fibre.length * worm.segments;
    lines->push_back(std::move(*line));
  }
  Laying laying{"network", mix, fibres};
  laying.segments = [=](std::int64_t f) { return mix->segments(f, segments); };
  laying.line = [=](std::int64_t f) { return (*lines)[static_cast<std::size_t>(f)]; };
  laying.box = box;
  laying.space = space;
  laying.warning = persistenceWarning("network", *lines, *mix, persistence, unit);
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
