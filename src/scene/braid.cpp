/// Scene `braid`: strands along x that pass over and under each other, flat (an odd number of them)
/// or around a hollow core (an even number, half of them each way around).
///
/// A flat braid is a figure of Lissajous: y = a sin p, z = b sin((n - 1) p), with the phases p of
/// the n strands 2 pi/n apart. Two strands cross where their phases add to pi; n - 1 is even, so
/// their heights are opposite there, and along a strand they alternate.
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
/// Steepest sideways and upwards at the default lay.
constexpr double mostAside = 0.6, mostUp = 0.3;

struct Braid {
  int strands;
  double wide = 0, high = 0;  ///< half the width of the strands' axes, and their swing across it
  double lay = 0;             ///< length in which a strand comes back to its place

  bool flat() const { return strands % 2 != 0; }
  int swings() const { return flat() ? strands - 1 : strands / 2; }

  /// For strands so thick.
  static Braid of(int strands, double thick) {
    Braid b{strands};
    if (b.flat()) {
      double least = 1;
      for (int m = 1; m < strands; ++m)
        least = std::min(
            least, std::abs(std::sin((strands - 1) * (0.25 * twoPi - 0.5 * twoPi * m / strands))));
      b.wide = 0.4 * strands * thick, b.high = 0.5 * thick / least;
    } else {
      b.wide = 1.3 * thick * strands / twoPi, b.high = 0.5 * thick;
    }
    b.lay = twoPi * std::max(b.wide / mostAside, b.high * b.swings() / mostUp);
    return b;
  }

  Curve axis(int strand, double scale) const {
    const int half = strands / 2;
    if (flat())
      return [=, *this](double u) {
        const double p = twoPi * (u / lay + static_cast<double>(strand) / strands);
        return Vec3d{u, scale * wide * std::sin(p), scale * high * std::sin(swings() * p)};
      };
    const double way = strand < half ? 1.0 : -1.0;
    return [=, *this](double u) {
      const double angle = way * twoPi * u / lay + twoPi * (strand % half) / half;
      const double r = scale * (wide + way * high * std::cos(swings() * twoPi * u / lay));
      return Vec3d{u, r * std::cos(angle), r * std::sin(angle)};
    };
  }
};

}  // namespace

std::unique_ptr<Scene> makeBraidScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: braid", use != SceneUse::none, "-scene is not braid");
  const char* unit = context.units.length;
  const auto strands = static_cast<int>(
      s.integer("braid_strands", 3, "odd: a flat braid; even: a hollow one", 3, 1000));
  const auto filaments =
      static_cast<int>(s.integer("braid_filaments", 1, "fibres of a strand", 1, 100000));
  const auto segments = static_cast<int>(
      s.integer("braid_segments", 120,
                "segments of each fibre of the first kind; others are as long", 2, 100000000));
  const auto lay = s.maybeReal("braid_lay", "as short as bends allow", unit,
                               "length in which a strand comes back to its place", positive);
  auto mix = std::make_shared<KindMix>(s, "braid", context);
  const bool shaped = readShaped(s, "braid");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  mix->draw(static_cast<std::int64_t>(strands) * filaments);
  const double gap = mix->widest(), chord = context.kinds.shortest();
  const auto places = std::make_shared<const std::vector<Place>>(roundPlaces(filaments));
  const double thick = gap * widthOf(*places);
  Braid braid = Braid::of(strands, thick);
  if (lay) braid.lay = *lay;
  auto fibre = [=](std::int64_t f, double scale) {
    const Place place = (*places)[static_cast<std::size_t>(f % filaments)];
    return beside(
        braid.axis(static_cast<int>(f / filaments), scale), {1, 0, 0},
        [=](double) {
          return Place{gap * place[0], gap * place[1]};
        },
        0.01 * gap);
  };
  const int points =
      pointsToLookAt(1.2 * braid.lay, chord, static_cast<double>(strands) * filaments,
                     format("-braid_lay %g", braid.lay));
  const double scale = scaleToFit(
      [&](double trial) {
        std::vector<Line> lines;
        for (std::int64_t f = 0; f < static_cast<std::int64_t>(strands) * filaments; ++f)
          lines.push_back({walk(fibre(f, trial), chord, points)});
        return lines;
      },
      {gap, filaments}, format("-braid_lay %g", braid.lay));
  Laying laying{"braid", mix, static_cast<std::int64_t>(strands) * filaments};
  laying.segments = [=](std::int64_t f) { return mix->segments(f, segments); };
  laying.line = [=](std::int64_t f) {
    return Line{walk(fibre(f, scale), mix->fibre(f).length, mix->segments(f, segments))};
  };
  const Line first = laying.line(0);
  std::vector<Curve> curves;
  for (std::int64_t f = 0; f < laying.fibres; ++f) curves.push_back(fibre(f, scale));
  auto range = [&](const std::function<double(const Vec3d&)>& measure) {
    constexpr int ofSwing = 40;  // the ends of each swing are among them
    return rangeOn(curves, braid.lay, ofSwing * braid.swings(), measure);
  };
  double wide, section;
  if (braid.flat()) {
    wide = range([](const Vec3d& x) { return x.y; }).width() + gap;
    section = wide * (range([](const Vec3d& x) { return x.z; }).width() + gap);
  } else {
    const Range radius = range([](const Vec3d& x) { return std::hypot(x.y, x.z); });
    wide = 2.0 * radius.most + gap;
    section = tubeSection(radius.middle(), radius.width() + gap);
  }
  laying.space = section * (first.points.back().x - first.points.front().x + mix->fibre(0).length);
  laying.also = format("counted in the %s, %d strands of %d, lay %.5g %s, %.4g %s wide",
                       braid.flat() ? "flat bar around it" : "tube that it lies in", strands,
                       filaments, braid.lay, unit, wide, unit);
  laying.shaped = shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
