/// Scene `knit`: plain (weft) knitting. Each course is a strand along x whose loops hang in those
/// of the course before it,
///
///     x = W (t + a sin 4 pi t),   y = b W cos 2 pi t,   z = -D cos 4 pi t,
///
/// t counting loops, W the width of a loop, courses c W apart. Heads and feet of loops lie behind
/// their legs, so that legs pass in front of the heads of the course before and feet behind its
/// legs. D is as deep as the strands need to pass each other.
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

// Of all such shapes these leave strands the most room where they pass each other.
constexpr double bulge = 0.239, height = 0.464, course = 0.5545, deepest = 0.21;

struct Knit {
  double width = 0, depth = 0;  ///< W and D
  int loops = 0;

  /// Of one course; the parameter is length along x.
  Curve axis(std::int64_t row, double middle) const {
    return [=, *this](double u) {
      const double t = u / width + middle, p = twoPi * t;
      return Vec3d{width * (t + bulge * std::sin(2.0 * p)),
                   width * (height * std::cos(p) + course * static_cast<double>(row)),
                   -depth * std::cos(2.0 * p)};
    };
  }

  double loopLength() const {
    constexpr int parts = 400;
    const Curve curve = axis(0, 0);
    double sum = 0;
    for (int k = 0; k < parts; ++k)
      sum += norm(curve(width * (k + 1) / parts) - curve(width * k / parts));
    return sum;
  }
};

}  // namespace

std::unique_ptr<Scene> makeKnitScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: knit", use != SceneUse::none, "-scene is not knit");
  const char* unit = context.units.length;
  const auto loops =
      static_cast<int>(s.integer("knit_loops", 6, "loops of a course, along x", 1, 1000000));
  const auto courses =
      static_cast<int>(s.integer("knit_courses", 6, "courses, along y", 1, 1000000));
  const auto filaments =
      static_cast<int>(s.integer("knit_filaments", 1, "fibres of a strand", 1, 1000));
  const auto wanted = s.maybeReal("knit_width", "12 segments, or 5 strands' thicknesses", unit,
                                  "width of a loop", positive);
  const bool periodic = s.flag("knit_periodic", false, "periodic in x and y, courses closed");
  auto mix = std::make_shared<KindMix>(s, "knit", context);
  const bool shaped = readShaped(s, "knit");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  const std::int64_t fibres = static_cast<std::int64_t>(courses) * filaments;
  mix->draw(fibres);
  const double gap = mix->widest();
  const auto places = std::make_shared<const std::vector<Place>>(roundPlaces(filaments));
  double thick = gap;
  for (const Place& p : *places)
    thick = std::max(thick, gap * (1.0 + 2.0 * std::hypot(p[0], p[1])));
  Knit knit{wanted.value_or(std::max(12.0 * context.kinds.longest(), 5.0 * thick)), 0.5 * thick,
            loops};
  auto curveOf = [=](const Knit& k, std::int64_t f, double middle) {
    const Place place = (*places)[static_cast<std::size_t>(f % filaments)];
    return beside(
        k.axis(f / filaments, middle), {1, 0, 0},
        [=](double) {
          return Place{gap * place[0], gap * place[1]};
        },
        0.01 * gap);
  };
  const std::string option = format("-knit_width %g", knit.width);
  const double chord = context.kinds.shortest();
  const int points = static_cast<int>(2.0 * knit.loopLength() / chord) + 3;
  const double depth = knit.depth;
  auto three = [&](double scale) {
    knit.depth = scale * depth;
    std::vector<Line> lines;
    for (std::int64_t f = 0; f < 3 * filaments; ++f)
      lines.push_back({walk(curveOf(knit, f, 0.0), chord, points)});
    return lines;
  };
  scaleToFit(three, {gap, filaments}, option);
  if (knit.depth > 1.2 * deepest * knit.width)
    throw InputError(format("%s: too narrow for strands of %.4g %s", option.c_str(), thick, unit));
  Laying laying{"knit", mix, fibres};
  const double length = knit.loopLength() * loops;
  laying.segments = [=](std::int64_t f) {
    return std::max(3, static_cast<int>(std::lround(length / mix->fibre(f).length)));
  };
  const double span = loops * knit.width;
  laying.line = [=, segments = laying.segments](std::int64_t f) {
    double T = mix->fibre(f).length;
    if (!periodic) return Line{walk(curveOf(knit, f, 0.5 * loops), T, segments(f))};
    return Line{walkAround(curveOf(knit, f, 0.0), span, segments(f), T), true, {span, 0, 0}};
  };
  const double pile = courses * course * knit.width;
  if (periodic) {
    const double margin = 4.0 * context.kinds.longest() + knit.depth + thick;
    Box box;
    box.periodic = {true, true, false};
    box.lower = {0, 0, -margin}, box.upper = {span, pile, margin};
    laying.box = box;
  }
  laying.space = span * pile * (2.0 * knit.depth + thick);
  laying.also = format("loops %.5g %s wide, thickness %.4g %s", knit.width, unit,
                       2.0 * knit.depth + thick, unit);
  laying.shaped = shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
