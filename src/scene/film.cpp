/// Scene `film`: fibres with places and directions by lot in the plane, either in flat layers, in
/// each of which none overlap, or deposited one after another on a flat ground. Each of these comes
/// to lie as low as those below it let it: on top of what it crosses, and between crossings down
/// again, as steeply as it may. A straight fibre for which lots find no place in its layer lies
/// beside one of those before it, so that dense layers are of bundles.
///
/// Where a fibre comes to lie depends on those before it, so every rank lays all of them: 24 bytes
/// and a piece of the crowd a segment.
#include <algorithm>
#include <cmath>
#include <map>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/pieces.hpp"
#include "nanoweft/scene/scenes.hpp"
#include "nanoweft/scene/worm.hpp"

namespace nanoweft {

namespace {

/// Segments to either side over which a fibre rounds off where it comes down.
constexpr int rounding = 1;

/// Places beside others that are tried for a straight fibre.
constexpr std::uint32_t besideTrials = 20000;

/// The highest (or, for `mean`, the mean) of so many neighbours to either side.
template <class Choose>
std::vector<double> overNeighbours(const std::vector<double>& z, int reach, const Choose& choose) {
  std::vector<double> result;
  const auto n = static_cast<int>(z.size());
  for (int k = 0; k < n; ++k)
    result.push_back(
        choose(z.begin() + std::max(0, k - reach), z.begin() + std::min(n, k + reach + 1)));
  return result;
}

/// The lowest heights, at places a step apart, that are nowhere below `need` and nowhere steeper.
std::vector<double> drape(std::vector<double> need, double rise) {
  const std::size_t n = need.size();
  for (std::size_t k = 1; k < n; ++k) need[k] = std::max(need[k], need[k - 1] - rise);
  for (std::size_t k = n - 1; k-- > 0;) need[k] = std::max(need[k], need[k + 1] - rise);
  // Means of the highest of all that they contain stay above each of those.
  auto highest = [](auto from, auto to) { return *std::max_element(from, to); };
  auto mean = [](auto from, auto to) {
    double sum = 0;
    for (auto z = from; z != to; ++z) sum += *z;
    return sum / static_cast<double>(to - from);
  };
  std::vector<double> z = overNeighbours(need, 2 * rounding, highest);
  for (int k = 0; k < 2; ++k) z = overNeighbours(z, rounding, mean);
  return z;
}

/// A line through the points, straight between them, with its middle at 0.
Curve through(const std::vector<Vec3d>& points, double step) {
  return [points, step](double u) {
    const auto last = static_cast<double>(points.size() - 2);
    const double s = u / step + 0.5 * static_cast<double>(points.size() - 1);
    const double piece = std::clamp(std::floor(s), 0.0, last);
    const auto k = static_cast<std::size_t>(piece);
    return points[k] + (s - piece) * (points[k + 1] - points[k]);
  };
}

/// Directions of segments laid along a line: those in which its places were grown, tilted as the
/// laid segments rise. Down slopes these are nearer to each other in the plane than its places, so
/// each has the direction of the place nearest to it; one between those of two would bend less.
std::vector<Vec3d> tilted(const std::vector<Vec3d>& laid, const Line& grown) {
  std::vector<Vec3d> axes = directionsOf({laid});
  const auto n = static_cast<int>(laid.size());
  for (const int way : {1, -1}) {
    // The middle ones lie where they were grown.
    int place = n / 2;
    for (int k = place; k >= 0 && k < n; k += way) {
      const auto at = static_cast<std::size_t>(k);
      auto from = [&](int p) { return norm(grown.points[static_cast<std::size_t>(p)] - laid[at]); };
      if (const int next = place + way; next >= 0 && next < n && from(next) < from(place))
        place = next;
      const double rise = axes[at].z;
      axes[at] = std::sqrt(1.0 - rise * rise) * grown.axes[static_cast<std::size_t>(place)] +
                 Vec3d{0, 0, rise};
    }
  }
  return axes;
}

struct FilmOptions {
  std::array<double, 2> size{};
  std::optional<long> fibres;
  double coverage = 1, slope = 0, persistence = 0;
  std::optional<double> fraction;
  int segments = 50, layers = 0, bundle = 1;
  bool periodic = true;
};

class Film {
 public:
  Film(const Box& box, const FilmOptions& options, const KindMix& mix, const SceneContext& context)
      : box_(box),
        slope_(options.slope),
        layers_(options.layers),
        bundle_(options.bundle),
        // Round-off must not bring layers nearer than the gap.
        pile_(mix.widest() * (1.0 + 1e-9)),
        mix_(mix),
        seed_(context.seed),
        crowd_(box, mix.widest() + context.kinds.longest()) {}

  /// False: no trial found a place.
  bool lay(std::int64_t f, int segments, double persistence) {
    const int kind = mix_.of(f);
    const double T = mix_.all()[kind].length;
    const double height = layers_ > 0 ? pile_ * static_cast<double>(f % layers_) : 0.0;
    // What is deposited must only keep away from itself.
    auto taken = [&](const LaidPiece& piece) {
      return layers_ > 0 ? crowded(crowd_, piece, mix_) : meetsItself(piece);
    };
    const bool beside = layers_ > 0 && persistence == 0;
    std::optional<Line> line;
    if (beside) line = layBeside(f, kind, segments, f / layers_ % bundle_);
    if (!line)
      line = growWorm(crowd_, box_, {f, kind, segments, T, persistence, height, seed_}, taken);
    if (!line && beside) line = layBeside(f, kind, segments, f / layers_);
    if (!line) return false;
    if (layers_ == 0) deposit(*line, f, kind);
    for (const Vec3d& x : line->points) heights_[kind].add(x.z);
    lines_.push_back(std::move(*line));
    return true;
  }

  /// The fibre with its bonds as long as they are at rest, its heights stretched by `factor`.
  Line laid(std::int64_t f, double factor) const {
    Line line = lines_[static_cast<std::size_t>(f)];
    for (Vec3d& x : line.points) x.z *= factor;
    if (layers_ > 0) return line;
    const double T = mix_.fibre(f).length;
    auto points = walk(through(line.points, T), T, static_cast<int>(line.points.size()));
    std::vector<Vec3d> axes = tilted(points, line);
    return {std::move(points), false, {}, std::move(axes)};
  }

  /// As they were grown.
  const std::vector<Line>& lines() const { return lines_; }

  /// Of the highest axis.
  double top() const {
    double top = 0;
    for (const auto& [kind, heights] : heights_) top = std::max(top, heights.most);
    return top;
  }

  /// Between the outermost surfaces, heights stretched by `factor`.
  double thickness(double factor) const {
    Range surfaces;
    for (const auto& [kind, heights] : heights_) {
      const double radius = mix_.all()[kind].radius;
      surfaces.add(factor * heights.least - radius);
      surfaces.add(factor * heights.most + radius);
    }
    return surfaces.width();
  }

 private:
  bool meetsItself(const LaidPiece& piece) const {
    const double gap = mix_.gap(piece.kind, piece.kind);
    const int few = neighboursApart(gap, 2.0 * piece.half);
    return crowd_.near(piece.centre, [&](const LaidPiece& other, const Vec3d& d) {
      return other.fibre == piece.fibre && std::abs(piece.index - other.index) > few &&
             distanceOfPieces(d, piece.axis, other.axis, {piece.half, other.half}) < gap;
    });
  }

  /// The image of a place that lies in the film, if there is one.
  std::optional<Vec3d> intoFilm(const Vec3d& place) const {
    double x[3] = {place.x, place.y, place.z};
    std::int32_t images[3] = {};
    box_.wrap(x, images);
    for (int d = 0; d < 2; ++d)
      if (x[d] < box_.lower[d] || x[d] > box_.upper[d]) return std::nullopt;
    return Vec3d{x[0], x[1], x[2]};
  }

  /// A straight fibre parallel to one of so many that lie before it in its layer, a gap beside it.
  /// Empty: nowhere.
  std::optional<Line> layBeside(std::int64_t f, int kind, int segments, std::int64_t before) {
    const double T = mix_.all()[kind].length;
    for (std::uint32_t trial = 0; before > 0 && trial < besideTrials; ++trial) {
      const auto [which, side] = uniformPair(seed_, Purpose::sceneShape, f, 2 * trial);
      const auto [along, way] = uniformPair(seed_, Purpose::sceneShape, f, 2 * trial + 1);
      const std::int64_t g =
          f - layers_ * (1 + static_cast<std::int64_t>(which * static_cast<double>(before)));
      const std::vector<Vec3d>& other = lines_[static_cast<std::size_t>(g)].points;
      const Vec3d e = unitVector(other.back() - other.front());
      const double gap = mix_.gap(kind, mix_.of(g)) * (1.0 + 1e-9), length = (segments - 1) * T;
      // Beside each other along half of their length at least, or where that fails along less.
      const double reach = trial < besideTrials / 2 ? length : 2.0 * length,
                   shift =
                       0.5 * (norm(other.back() - other.front()) - length) + (along - 0.5) * reach;
      const auto x =
          intoFilm(other.front() + shift * e + (side < 0.5 ? gap : -gap) * Vec3d{-e.y, e.x, 0});
      if (!x) continue;
      Line line;
      for (int k = 0; k < segments; ++k)
        line.points.push_back(*x + ((way < 0.5 ? k : segments - 1 - k) * T) * e);
      if (layFree(line, f, kind)) return line;
    }
    return std::nullopt;
  }

  /// Takes the line into the crowd unless it meets anything there.
  bool layFree(const Line& line, std::int64_t f, int kind) {
    const std::size_t before = crowd_.size();
    for (const LaidPiece& piece : piecesOf(line, f, kind)) {
      if (crowded(crowd_, piece, mix_)) {
        crowd_.shrink(before);
        return false;
      }
      crowd_.add(piece);
    }
    return true;
  }

  void deposit(Line& line, std::int64_t f, int kind) const {
    std::vector<double> need;
    for (const LaidPiece& piece : piecesOf(line, f, kind)) need.push_back(restingOn(piece));
    const std::vector<double> z = drape(std::move(need), slope_ * mix_.all()[kind].length);
    for (std::size_t k = 0; k < z.size(); ++k) line.points[k].z = z[k];
  }

  /// The height at which the piece overlaps none of those below it.
  double restingOn(const LaidPiece& piece) const {
    double height = 0;
    // Fibres that come down at a slope are nearer to each other than they are above each other.
    const double leaning = std::hypot(1.0, slope_);
    crowd_.near(piece.centre, [&](const LaidPiece& other, const Vec3d& d) {
      if (other.fibre == piece.fibre) return false;
      const double gap = mix_.gap(piece.kind, other.kind);
      const double beside = distanceOfPieces(d, piece.axis, other.axis, {piece.half, other.half});
      if (beside >= gap) return false;
      const auto& under = lines_[static_cast<std::size_t>(other.fibre)].points;
      const double z = under[static_cast<std::size_t>(other.index)].z + slope_ * other.half;
      height = std::max(height, z + leaning * std::sqrt(gap * gap - beside * beside));
      return false;
    });
    return height;
  }

  Box box_;
  double slope_;
  int layers_, bundle_;
  double pile_;  ///< height of a layer
  const KindMix& mix_;
  std::uint64_t seed_;
  Crowd crowd_;                   ///< in layers, or where all is seen from above
  std::vector<Line> lines_;       ///< a segment length apart in the plane
  std::map<int, Range> heights_;  ///< of the axes of each kind
};

FilmOptions readFilm(OptionSection& s, const SceneContext& context) {
  FilmOptions p;
  const double usual = 75.0 * context.kinds[0].length;
  p.size = {usual, usual};
  if (auto v = s.reals("film_size", 2, "75 segments each way", context.units.length,
                       "edges of the film"))
    p.size = {(*v)[0], (*v)[1]};
  if (!(p.size[0] > 0) || !(p.size[1] > 0))
    throw InputError("-film_size: needs two lengths above zero");
  p.fibres = s.maybeInteger("film_fibres", "by the coverage", "number of fibres", 1, 100000000);
  p.coverage =
      s.real("film_coverage", 1.0, "",
             "area of all fibres, seen from above one by one, over that of the film", positive);
  if (p.fibres && s.given("film_coverage"))
    throw InputError("-film_fibres and -film_coverage: give one of them");
  p.fraction = s.maybeReal("film_fraction", "as laid", "",
                           "volume fraction, between the outermost surfaces", {0.0, 1.0, true});
  p.segments = static_cast<int>(
      s.integer("film_segments", 50, "segments of each fibre of the first kind; others are as long",
                3, 1000000));
  p.persistence = readPersistence(s, "film", context);
  p.layers =
      static_cast<int>(s.maybeInteger("film_layers", "deposited one on another",
                                      "fibres are laid in so many flat layers instead", 1, 1000000)
                           .value_or(0));
  p.bundle = static_cast<int>(
      s.integer("film_bundle", 1,
                "straight fibres of a flat layer that lie side by side, as far as there is room", 1,
                1000000));
  if (p.bundle > 1 && (p.layers == 0 || p.persistence > 0))
    throw InputError(
        format("-film_bundle %d: straight fibres in -film_layers lie side by side, and "
               "none that are worm-like or deposited",
               p.bundle));
  p.slope = s.real("film_slope", 0.2, "", "steepness at which a fibre comes down behind a crossing",
                   {0.0, 0.5});
  if (p.layers > 0 && s.given("film_slope"))
    throw InputError("-film_slope: not used by this run, whose fibres lie flat (-film_layers)");
  p.periodic = s.flag("film_periodic", true, "periodic in x and y; else fibres jut out");
  return p;
}

/// By how much heights are stretched so that `volume` fills the wanted fraction.
double stretchFor(const FilmOptions& p, double volume, const Film& film) {
  if (!p.fraction) return 1.0;
  const double area = p.size[0] * p.size[1], wanted = volume / (area * *p.fraction);
  if (film.top() == 0 || film.thickness(1.0) > wanted)
    throw InputError(
        format("-film_fraction %g: as laid the film fills a fraction of %.4g; flat layers "
               "(-film_layers), fewer of them, -film_bundle or a steeper -film_slope make it "
               "denser",
               *p.fraction, volume / (area * film.thickness(1.0))));
  // The fibres that lie outermost may be others once they are stretched.
  double low = 1, high = 1;
  while (film.thickness(high) < wanted) high *= 2;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (film.thickness(middle) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::unique_ptr<Scene> makeFilmScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: film", use != SceneUse::none, "-scene is not film");
  const FilmOptions p = readFilm(s, context);
  auto mix = std::make_shared<KindMix>(s, "film", context);
  if (use != SceneUse::start) return nullptr;
  mix->prepare(context);
  const double area = p.size[0] * p.size[1];
  const double wanted = p.coverage * area / mix->shadow(p.segments);
  if (!p.fibres && !(wanted > 0.5 && wanted < 1e8))
    throw InputError(
        format("-film_coverage %g: would take %.3g fibres; from 1 to 1e8", p.coverage, wanted));
  const std::int64_t fibres = p.fibres ? *p.fibres : std::lround(wanted);
  requireMemory(context.comm, fibres * p.segments, sizeof(Vec3d) + sizeof(LaidPiece));
  mix->draw(fibres);
  Box box;
  box.upper = {p.size[0], p.size[1], 1.0};
  box.periodic = {p.periodic, p.periodic, false};
  auto film = std::make_shared<Film>(box, p, *mix, context);
  for (std::int64_t f = 0; f < fibres; ++f)
    if (!film->lay(f, mix->segments(f, p.segments), p.persistence))
      throw InputError(format(
          "-scene film: no place for fibre %lld of %lld in %d trials; %s",
          static_cast<long long>(f + 1), static_cast<long long>(fibres), wormTrials,
          p.layers > 0
              ? "more -film_layers, shorter fibres or straight ones in a -film_bundle make room"
              : "it met itself, for which the film is too small"));
  Laying laying{"film", mix, fibres};
  laying.segments = [=](std::int64_t f) { return mix->segments(f, p.segments); };
  const double factor = stretchFor(p, volumeOf(laying), *film), thickness = film->thickness(factor),
               margin = 4.0 * context.kinds.longest();
  laying.line = [=](std::int64_t f) { return film->laid(f, factor); };
  if (p.periodic) {
    box.lower[2] = -margin, box.upper[2] = factor * film->top() + margin;
    laying.box = box;
  }
  laying.space = area * thickness;
  laying.also = format("coverage %.4g, thickness %.5g %s", shadowOf(laying) / area, thickness,
                       context.units.length);
  laying.warning =
      persistenceWarning("film", film->lines(), *mix, p.persistence, context.units.length);
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
