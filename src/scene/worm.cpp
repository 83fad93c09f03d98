#include "nanoweft/scene/worm.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// Bonds are not bent further at the start, in radians.
constexpr double mostBend = 0.6;
/// Over a segment: the least that bends up to mostBend can give is 11.1 in space, 8.3 in the plane.
constexpr double leastPersistence = 12;

/// Trials in which a worm-like fibre that meets another is begun anew: to bend it around the other
/// makes it more flexible.
constexpr int firmTrials = 100;

/// After these, times that a bond is turned anew before the fibre loses segments, and that it loses
/// some before it is begun anew.
constexpr int turnTrials = 12, lossTrials = 40;

/// The random numbers of one trial, one after another.
class Lots {
 public:
  Lots(const Worm& worm, int trial)
      : seed_(worm.seed + static_cast<std::uint64_t>(trial) * 0x9E3779B97F4A7C15u),
        fibre_(worm.fibre) {}

  std::array<double, 2> uniform() {
    return uniformPair(seed_, Purpose::scenePlace, fibre_, drawn_++);
  }
  double normal() { return normalDraw(seed_, Purpose::sceneShape, fibre_, drawn_++); }

 private:
  std::uint64_t seed_;
  std::int64_t fibre_;
  std::uint32_t drawn_ = 0;
};

/// Standard deviation of normal draws such that a turn has this variance, although draws beyond
/// mostBend do not count: of a turn in the plane, or of each of two across.
double spreadOf(double variance, bool flat) {
  // Variance of what remains of draws with the standard deviation s.
  auto left = [&](double s) {
    const double a = mostBend / s, inside = 0.5 * a * a;
    if (!flat) return s * s * (1.0 - inside / std::expm1(inside));
    return s * s *
           (1.0 - std::sqrt(2.0 / std::numbers::pi) * a * std::exp(-inside) /
                      std::erf(a / std::numbers::sqrt2));
  };
  double low = std::sqrt(variance), high = 100.0 * mostBend;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (left(middle) < variance ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Vec3d firstDirection(Lots& lots, bool flat) {
  const auto [a, b] = lots.uniform();
  const double angle = 2.0 * std::numbers::pi * a, z = flat ? 0.0 : 2.0 * b - 1.0;
  const double across = std::sqrt(1.0 - z * z);
  return {across * std::cos(angle), across * std::sin(angle), z};
}

/// One fibre that grows.
class Growth {
 public:
  Growth(Crowd& crowd, const Worm& worm, Lots& lots,
         const std::function<bool(const LaidPiece&)>& taken, bool yields)
      : crowd_(crowd),
        worm_(worm),
        lots_(lots),
        taken_(taken),
        yields_(yields),
        before_(crowd.size()),
        spread_(worm.persistence > 0 ? spreadOf(worm.length / worm.persistence, flat()) : 0.0) {}

  /// False: it found no way.
  bool grow(const Vec3d& start, const Vec3d& direction) {
    if (!place(start, direction)) return false;
    for (int losses = 0; size() < worm_.segments;) {
      if (extend()) continue;
      if (!yields_ || ++losses > lossTrials) return false;
      lose(1 + losses % 10);
    }
    return true;
  }

  Line line() const { return {points_, false, {}, directions_}; }

 private:
  int size() const { return static_cast<int>(points_.size()); }

  bool place(const Vec3d& x, const Vec3d& direction) {
    const LaidPiece piece{x, direction, 0.5 * worm_.length, worm_.fibre, size(), worm_.kind};
    if (taken_(piece)) return false;
    crowd_.add(piece);
    points_.push_back(x);
    directions_.push_back(direction);
    return true;
  }

  bool extend() {
    const Vec3d e = directions_.back(), x = points_.back();
    if (worm_.persistence == 0) return place(x + worm_.length * e, e);
    for (int turn = 0; turn < (yields_ ? turnTrials : 1); ++turn) {
      const Vec3d next = turned(e);
      // The chord between two segments halves the angle between their axes.
      if (place(x + worm_.length * unitVector(e + next), next)) return true;
    }
    return false;
  }

  bool flat() const { return worm_.height.has_value(); }

  /// The next direction: two turns across the last one, or in the plane one, of variance T/P each.
  /// Draws beyond mostBend are drawn again.
  Vec3d turned(const Vec3d& e) {
    const Vec3d side = flat() ? Vec3d{-e.y, e.x, 0} : acrossOf(e);
    Vec3d bend;
    double angle;
    do {
      bend = spread_ * lots_.normal() * side;
      if (!flat()) bend += spread_ * lots_.normal() * cross(e, side);
      angle = norm(bend);
    } while (angle > mostBend);
    if (angle == 0) return e;
    return std::cos(angle) * e + std::sin(angle) / angle * bend;
  }

  void lose(int count) {
    const int left = std::max(1, size() - count);
    points_.resize(static_cast<std::size_t>(left));
    directions_.resize(static_cast<std::size_t>(left));
    crowd_.shrink(before_ + static_cast<std::size_t>(left));
  }

  Crowd& crowd_;
  const Worm& worm_;
  Lots& lots_;
  const std::function<bool(const LaidPiece&)>& taken_;
  bool yields_;         ///< to what it meets, by bends
  std::size_t before_;  ///< pieces of the crowd that are others'
  double spread_;       ///< of a turn
  std::vector<Vec3d> points_, directions_;
};

}  // namespace

std::optional<Line> growWorm(Crowd& crowd, const Box& box, const Worm& worm,
                             const std::function<bool(const LaidPiece&)>& taken) {
  const std::size_t before = crowd.size();
  for (int trial = 0; trial < wormTrials; ++trial) {
    Lots lots(worm, trial);
    const auto [a, b] = lots.uniform();
    const Vec3d x{box.lower[0] + a * box.length(0), box.lower[1] + b * box.length(1),
                  worm.height ? *worm.height : box.lower[2] + lots.uniform()[0] * box.length(2)};
    const Vec3d e = firstDirection(lots, worm.height.has_value());
    Growth growth(crowd, worm, lots, taken, worm.persistence > 0 && trial >= firmTrials);
    if (growth.grow(x, e)) return growth.line();
    crowd.shrink(before);
  }
  return std::nullopt;
}

double readPersistence(OptionSection& section, const std::string& scene,
                       const SceneContext& context) {
  const std::string option = scene + "_persistence";
  const double persistence =
      section
          .maybeReal(option, "straight", context.units.length,
                     "persistence length of worm-like fibres, of twelve segments at least",
                     positive)
          .value_or(0.0);
  if (persistence > 0 && persistence < leastPersistence * context.kinds.longest())
    throw InputError(
        format("-%s %g: shorter than twelve segments of %g %s, which would bend too "
               "sharply",
               option.c_str(), persistence, context.kinds.longest(), context.units.length));
  return persistence;
}

std::string persistenceWarning(const std::string& scene, const std::vector<Line>& lines,
                               const KindMix& mix, double persistence, const char* unit) {
  constexpr int fewStretches = 20;  // from which nothing can be told
  // Over half a persistence length, or as much of it as fibres have.
  struct Stretches {
    double length, sum = 0, squares = 0, count = 0;
  };
  std::map<int, Stretches> ofKind;
  bool flat = true;
  for (std::size_t f = 0; persistence > 0 && f < lines.size(); ++f) {
    const std::vector<Vec3d>& axes = lines[f].axes;
    const int kind = mix.of(static_cast<std::int64_t>(f));
    const double T = mix.all()[kind].length;
    const std::size_t apart = static_cast<std::size_t>(std::clamp<std::int64_t>(
        std::llround(0.5 * persistence / T), 1, static_cast<std::int64_t>(axes.size()) - 1));
    Stretches& own = ofKind.try_emplace(kind, static_cast<double>(apart) * T).first->second;
    for (std::size_t k = 0; k + apart < axes.size(); k += apart) {
      const double cosine = dot(axes[k], axes[k + apart]);
      own.sum += cosine, own.squares += cosine * cosine, own.count += 1;
      flat = flat && axes[k].z == 0;
    }
  }
  std::string warning;
  for (const auto& [kind, s] : ofKind) {
    const double decay = (flat ? 0.5 : 1.0) * s.length, asked = std::exp(-decay / persistence),
                 mean = s.sum / s.count, found = -decay / std::log(std::max(mean, 1e-3)),
                 doubt = std::sqrt(std::max(0.0, s.squares / s.count - mean * mean) / s.count);
    if (s.count < fewStretches || std::abs(found / persistence - 1.0) < 0.1 ||
        std::abs(mean - asked) < 3.0 * doubt)
      continue;
    warning += format("%s %.3g %s%s", warning.empty() ? "" : ",", found, unit,
                      mix.all().count() > 1 ? (" (" + mix.all()[kind].kind + ")").c_str() : "");
  }
  if (warning.empty()) return {};
  return format(
      "-%s_persistence %g: as laid it is%s, since fibres that meet others are bent around them, "
      "less so in a looser %s",
      scene.c_str(), persistence, warning.c_str(), scene.c_str());
}

}  // namespace nanoweft
