/// Scene `rope`: fibres twisted into strands, strands into plies, and so on, along x. A ply of each
/// level runs on a helix about the axis of the one it belongs to, against the twist within it.
///
/// How far plies lie from their axis follows from the lay: fibres on helices come nearer to each
/// other than straight ones in the same places, so each level is widened until none overlap.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/crowd.hpp"
#include "nanoweft/scene/places.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

constexpr double twoPi = 2.0 * std::numbers::pi;

/// The strands of one level of a rope.
struct Level {
  int count;
  double lay;      ///< length of a turn, below zero for a left-handed one
  double spacing;  ///< between neighbouring strands
  std::vector<Place> places;
};

class Rope {
 public:
  /// From the outermost level to that of the fibres.
  std::vector<Level> levels;
  double step = 1;  ///< small against all bends

  int fibres() const {
    int count = 1;
    for (const Level& level : levels) count *= level.count;
    return count;
  }

  Curve curve(std::int64_t fibre) const {
    Curve curve = [](double u) { return Vec3d{u, 0, 0}; };
    std::int64_t rest = fibres();
    for (const Level& level : levels) {
      rest /= level.count;
      const Place place = level.places[static_cast<std::size_t>(fibre / rest)];
      fibre %= rest;
      auto offset = [place, lay = level.lay, spacing = level.spacing](double u) {
        const double c = spacing * std::cos(twoPi * u / lay),
                     s = spacing * std::sin(twoPi * u / lay);
        return Place{c * place[0] - s * place[1], s * place[0] + c * place[1]};
      };
      curve = beside(curve, {1, 0, 0}, offset, step);
    }
    return curve;
  }

  double longestLay() const {
    double longest = 0;
    for (const Level& level : levels) longest = std::max(longest, std::abs(level.lay));
    return longest;
  }

  /// How far along the axis a piece of fibre reaches, of its length, in the mean of all fibres over
  /// a turn of the longest lay.
  double advance(double chord) const {
    const int chords = static_cast<int>(std::ceil(longestLay() / chord));
    double sum = 0;
    for (std::int64_t f = 0; f < fibres(); ++f) {
      const std::vector<Vec3d> points = walk(curve(f), chord, chords + 1);
      sum += (points.back().x - points.front().x) / (chords * chord);
    }
    return sum / fibres();
  }

  /// Across, to the outsides of fibres a gap thick.
  double diameter(std::size_t from, double gap) const {
    double diameter = gap;
    for (std::size_t l = from; l < levels.size(); ++l)
      diameter += levels[l].spacing * (widthOf(levels[l].places) - 1.0);
    return diameter;
  }
};

std::vector<int> readPlies(OptionSection& s) {
  std::vector<int> plies;
  double fibres = 1;
  for (const double n :
       s.reals("rope_plies", 0, "3,7", "",
               "strands of a rope, strands of such a strand, and so on down to fibres")
           .value_or(std::vector<double>{3, 7})) {
    if (n != std::floor(n) || n < 1 || (fibres *= n) > 1e6)
      throw InputError(
          "-rope_plies: needs whole numbers, of not more than 1000000 fibres together");
    plies.push_back(static_cast<int>(n));
  }
  if (plies.size() > 3) throw InputError("-rope_plies: at most three levels");
  return plies;
}

/// Lays each level at the lay asked for, or of ten diameters, the levels in turn against each
/// other, and widens it until no fibres overlap, from the innermost level outwards.
Rope layOut(const std::vector<int>& plies, const std::vector<double>& lays, const KindMix& mix) {
  const double gap = mix.widest(), chord = mix.all().shortest();
  // Before the inner levels take their time.
  double fibres = 1;
  for (const int n : plies) fibres *= n;
  for (const double lay : lays)
    pointsToLookAt(1.2 * std::abs(lay), chord, fibres, format("-rope_lay %g", lay));
  Rope rope;
  rope.step = 0.01 * gap;
  for (std::size_t l = plies.size(); l-- > 0;) {
    Level level{plies[l], 0, rope.diameter(0, gap), roundPlaces(plies[l])};
    rope.levels.insert(rope.levels.begin(), level);
    Level& outer = rope.levels.front();
    const double diameter = rope.diameter(0, gap);
    outer.lay = lays.empty() ? (l % 2 ? -10.0 : 10.0) * diameter : lays[l];
    if (std::abs(outer.lay) < 2.0 * diameter)
      throw InputError(format("-rope_lay %g: shorter than two diameters of what it twists, %.4g",
                              outer.lay, 2.0 * diameter));
    if (outer.count == 1) continue;
    const double longest = rope.longestLay();
    const int points = pointsToLookAt(1.2 * longest, chord, static_cast<double>(rope.fibres()),
                                      format("-rope_lay %g", longest));
    const double spacing = outer.spacing;
    auto make = [&](double scale) {
      rope.levels.front().spacing = scale * spacing;
      std::vector<Line> lines;
      for (std::int64_t f = 0; f < rope.fibres(); ++f)
        lines.push_back({walk(rope.curve(f), chord, points)});
      return lines;
    };
    scaleToFit(make, {gap, rope.fibres() / outer.count}, "-rope_lay");
  }
  return rope;
}

}  // namespace

std::unique_ptr<Scene> makeRopeScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: rope", use != SceneUse::none, "-scene is not rope");
  const char* unit = context.units.length;
  const std::vector<int> plies = readPlies(s);
  const auto segments = static_cast<int>(
      s.integer("rope_segments", 120,
                "segments of each fibre of the first kind; others are as long", 2, 100000000));
  const auto lays = s.reals("rope_lay", 0, "ten diameters, levels against each other", unit,
                            "length of a turn of each level; below zero: left-handed");
  auto mix = std::make_shared<KindMix>(s, "rope", context);
  const bool shaped = readShaped(s, "rope");
  if (lays && (lays->size() != plies.size() || std::ranges::count(*lays, 0.0)))
    throw InputError("-rope_lay: needs a length, not zero, for each of -rope_plies");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  auto rope = std::make_shared<Rope>(layOut(plies, lays.value_or(std::vector<double>()), *mix));
  mix->draw(rope->fibres());
  Laying laying{"rope", mix, rope->fibres()};
  laying.segments = [=](std::int64_t f) { return mix->segments(f, segments); };
  laying.line = [=](std::int64_t f) {
    return Line{walk(rope->curve(f), mix->fibre(f).length, mix->segments(f, segments))};
  };
  const double diameter = rope->diameter(0, mix->widest());
  std::string text;
  for (const Level& level : rope->levels)
    text += format("%s%.5g", text.empty() ? "" : ", ", level.lay);
  const double height = mix->length(segments) * rope->advance(mix->all().shortest());
  laying.space = 0.25 * std::numbers::pi * diameter * diameter * height;
  laying.also = format("diameter %.5g %s, lay %s %s", diameter, unit, text.c_str(), unit);
  laying.shaped = shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
