/// Scene `bundle`: straight fibres along x in hexagonal packing, filled from the middle outwards.
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/random.hpp"
#include "nanoweft/scene/laid.hpp"
#include "nanoweft/scene/places.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

std::unique_ptr<Scene> makeBundleScene(Options& options, const SceneContext& context,
                                       SceneUse use) {
  OptionSection s(options, "Scene: bundle", use != SceneUse::none, "-scene is not bundle");
  const long strands = s.integer("bundle_fibres", 7, "number of fibres side by side", 1, 100000000);
  const auto inLine =
      static_cast<int>(s.integer("bundle_in_line", 1, "number of fibres end to end", 1, 1000000));
  const auto segments = static_cast<int>(
      s.integer("bundle_segments", 100,
                "segments of each fibre of the first kind; others are as long", 2, 100000000));
  const double stagger =
      s.real("bundle_stagger", 0.0, context.units.length,
             "fibres are shifted along by up to half of it either way, by lot", nonNegative);
  auto mix = std::make_shared<KindMix>(s, "bundle", context);
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  const std::int64_t fibres = strands * static_cast<std::int64_t>(inLine);
  mix->draw(fibres);
  const double gap = mix->widest(), length = mix->length(segments), pitch = length + gap;
  const auto places =
      std::make_shared<const std::vector<Place>>(hexagonalPlaces(static_cast<int>(strands)));
  Laying laying{"bundle", mix, fibres};
  laying.segments = [=](std::int64_t f) { return mix->segments(f, segments); };
  laying.line = [=, seed = context.seed](std::int64_t f) {
    const std::int64_t strand = f / inLine;
    const auto& [y, z] = (*places)[static_cast<std::size_t>(strand)];
    const double lot = uniformPair(seed, Purpose::scenePlace, strand, 0)[0] - 0.5;
    const int n = mix->segments(f, segments);
    const double T = mix->fibre(f).length,
                 middle = pitch * static_cast<double>(f % inLine) + stagger * lot;
    Line line;
    for (int k = 0; k < n; ++k)
      line.points.push_back({middle + (k - 0.5 * (n - 1)) * T, gap * y, gap * z});
    return line;
  };
  // Gaps lie between fibres, and none behind the last one.
  laying.space =
      std::sqrt(0.75) * gap * gap * static_cast<double>(strands) * (pitch * inLine - gap);
  laying.also = format("%g %s apart", gap, context.units.length);
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
