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
#include <map>
#include <numbers>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/crowd.hpp"
#include "nanoweft/scene/places.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

constexpr double twoPi = 2.0 * std::numbers::pi;

// Of all such shapes these leave strands the most room where they pass each other.
constexpr double bulge = 0.239, height = 0.464, course = 0.5545, deepest = 0.21;

/// Of a loop, at which its curve is looked at.
constexpr int parts = 400;

struct Knit {
  int loops = 6, courses = 6, filaments = 1;
  bool periodic = false, shaped = false;
  double width = 0, depth = 0;  ///< W and D
  double gap = 0, thick = 0;    ///< between fibres; of a strand
  std::vector<Place> places;    ///< of a strand's fibres

  double span() const { return loops * width; }
  double pile() const { return courses * course * width; }

  /// Of a strand; the parameter is length along x, from the loop `first` on.
  Curve axis(std::int64_t row, double first) const {
    return [row, first, w = width, d = depth](double u) {
      const double t = u / w + first, p = twoPi * t;
      return Vec3d{w * (t + bulge * std::sin(2.0 * p)),
                   w * (height * std::cos(p) + course * static_cast<double>(row)),
                   -d * std::cos(2.0 * p)};
    };
  }
  Curve fibre(std::int64_t f, double first) const {
    const Place place = places[static_cast<std::size_t>(f % filaments)];
    return beside(
        axis(f / filaments, first), {1, 0, 0},
        [place, gap = gap](double) {
          return Place{gap * place[0], gap * place[1]};
        },
        0.01 * gap);
  }

  /// From half a gap below the lowest axes to half of one above the highest.
  double thickness() const {
    std::vector<Curve> strand;
    for (int f = 0; f < filaments; ++f) strand.push_back(fibre(f, 0));
    return rangeOn(strand, width, parts, [](const Vec3d& x) { return x.z; }).width() + gap;
  }

  double loopLength() const {
    const Curve curve = axis(0, 0);
    double sum = 0;
    for (int k = 0; k < parts; ++k)
      sum += norm(curve(width * (k + 1) / parts) - curve(width * k / parts));
    return sum;
  }
};

/// Makes it as deep as strands need, and these as wide as their fibres do, looking at two loops of
/// three courses.
void deepen(Knit& knit, double chord, const char* unit) {
  const std::string option = format("-knit_width %g", knit.width);
  const int points = pointsToLookAt(2.0 * knit.loopLength(), chord, 3.0 * knit.filaments, option);
  auto lay = [&](std::int64_t fibres) {
    std::vector<Line> lines;
    for (std::int64_t f = 0; f < fibres; ++f)
      lines.push_back({walk(knit.fibre(f, 0.0), chord, points)});
    return lines;
  };
  auto three = [&](double scale) {
    knit.depth = 0.5 * scale * knit.thick;
    return lay(3 * knit.filaments);
  };
  auto tooNarrow = [&] {
    return InputError(
        format("%s: too narrow for strands of %.4g %s", option.c_str(), knit.thick, unit));
  };
  // Where a strand bends and rises at once its fibres wind around it, nearer to each other than
  // their places; the more so, the deeper it is.
  auto apart = [&] { return knit.filaments > 1 ? tightest(lay(knit.filaments), {knit.gap}) : 1.0; };
  knit.depth = 0.6 * knit.thick;  // about what most need
  do {
    const std::vector<Place> places = knit.places;
    double scale = 1;
    for (double found = apart(); found < 1.0; found = apart()) {
      scale *= std::max(1.002, 1.0 / found);
      if (scale > 1.5) throw tooNarrow();
      for (std::size_t k = 0; k < places.size(); ++k)
        knit.places[k] = {scale * places[k][0], scale * places[k][1]};
    }
    knit.thick = knit.gap * widthOf(knit.places);
    scaleToFit(three, {knit.gap, knit.filaments}, option);
    if (knit.depth > 1.2 * deepest * knit.width) throw tooNarrow();
  } while (apart() < 0.998);
}

Box periodicBox(const Knit& knit, double margin) {
  Box box;
  box.periodic = {true, true, false};
  const double outside = margin + 2.0 * knit.depth + knit.thick;
  box.lower = {0, 0, -outside};
  box.upper = {knit.span(), knit.pile(), outside};
  return box;
}

}  // namespace

std::unique_ptr<Scene> makeKnitScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: knit", use != SceneUse::none, "-scene is not knit");
  const char* unit = context.units.length;
  Knit knit;
  knit.loops =
      static_cast<int>(s.integer("knit_loops", 6, "loops of a course, along x", 1, 1000000));
  knit.courses = static_cast<int>(s.integer("knit_courses", 6, "courses, along y", 1, 1000000));
  knit.filaments = static_cast<int>(s.integer("knit_filaments", 1, "fibres of a strand", 1, 1000));
  const auto wanted = s.maybeReal("knit_width", "12 segments, or 5 strands' thicknesses", unit,
                                  "width of a loop", positive);
  knit.periodic = s.flag("knit_periodic", false, "periodic in x and y, courses closed");
  auto mix = std::make_shared<KindMix>(s, "knit", context);
  knit.shaped = readShaped(s, "knit");
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  Laying laying{"knit", mix, static_cast<std::int64_t>(knit.courses) * knit.filaments};
  mix->draw(laying.fibres);
  knit.gap = mix->widest();
  knit.places = roundPlaces(knit.filaments);
  knit.thick = knit.gap * widthOf(knit.places);
  knit.width = wanted.value_or(std::max(12.0 * context.kinds.longest(), 5.0 * knit.thick));
  deepen(knit, context.kinds.shortest(), unit);
  const double length = knit.loopLength() * knit.loops;
  auto countOf = [&](std::int64_t f) {
    const double T = mix->fibre(f).length;
    int count = std::max(3, static_cast<int>(std::lround(length / T)));
    if (!knit.periodic) return count;
    // Chords are shorter than arcs, so fewer of them go around.
    for (int trial = 0; trial < 3; ++trial) {
      double chord = T;
      walkAround(knit.fibre(f, 0.0), knit.span(), count, chord);
      count = std::max(3, static_cast<int>(std::lround(count * chord / T)));
    }
    return count;
  };
  // Fibres of a strand are not equally long.
  auto alike = [=](std::int64_t f) { return std::pair(f % knit.filaments, mix->fibre(f).length); };
  std::map<std::pair<std::int64_t, double>, int> counts;
  for (std::int64_t f = 0; f < laying.fibres; ++f)
    if (!counts.contains(alike(f))) counts[alike(f)] = countOf(f);
  laying.segments = [=](std::int64_t f) { return counts.at(alike(f)); };
  laying.line = [=, segments = laying.segments](std::int64_t f) {
    double T = mix->fibre(f).length;
    if (!knit.periodic) return Line{walk(knit.fibre(f, 0.5 * knit.loops), T, segments(f))};
    const double span = knit.span();
    return Line{walkAround(knit.fibre(f, 0.0), span, segments(f), T), true, {span, 0, 0}};
  };
  if (knit.periodic) laying.box = periodicBox(knit, 4.0 * context.kinds.longest());
  const double thickness = knit.thickness();
  laying.space = knit.span() * knit.pile() * thickness;
  laying.also = format("loops %.5g %s wide, thickness %.4g %s", knit.width, unit, thickness, unit);
  laying.shaped = knit.shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
