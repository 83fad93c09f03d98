#include "nanoweft/scene/fabric.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/crowd.hpp"
#include "nanoweft/scene/places.hpp"

namespace nanoweft {

namespace {

/// How steeply tows may pass from one side to the other.
constexpr double steepest = 0.7;

class Fabric {
 public:
  Fabric(const FabricParameters& p, const SceneContext& context)
      : p_(p),
        places_(rowPlaces(p.filaments[0], p.filaments[1])),
        wide_((p.filaments[0] - (p.filaments[1] > 1 ? 0.5 : 1.0)) * p.gap),
        thick_((1.0 + std::sqrt(0.75) * (p.filaments[1] - 1)) * p.gap),
        swing_(0.5 * thick_) {
    for (std::size_t d = 0; d < 2; ++d)
      pitch_[d] = pitchFor(d, context.kinds[p.kinds[d]].length, context.units.length);
  }

  void setSwing(double scale) { swing_ = 0.5 * scale * thick_; }
  double thickness() const { return 2.0 * swing_ + thick_; }
  /// Between the tows across direction d, that is along x of those along y.
  double pitch(std::size_t d) const { return pitch_[d]; }
  double span(std::size_t d) const { return p_.count[1 - d] * pitch_[d]; }

  /// A filament of tow `number` along direction d, in the lowest layer; u from the first edge.
  Curve curve(std::size_t d, int number, int filament, double middle) const {
    const double side = (number + 0.5) * pitch_[1 - d];
    const Curve axis = [=, this](double u) {
      const double s = u + middle, z = height(d, number, s);
      return d == 0 ? Vec3d{s, side, z} : Vec3d{side, s, z};
    };
    const auto [a, b] = places_[static_cast<std::size_t>(filament)];
    const Place offset{p_.gap * b, p_.gap * a};
    return beside(
        axis, d == 0 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, [=](double) { return offset; },
        0.01 * p_.gap);
  }

 private:
  /// +1 where the tow passes above the one across it.
  double sign(std::size_t d, int number, int across) const {
    const bool over = d == 0 ? p_.over(number, across) : !p_.over(across, number);
    return over ? 1.0 : -1.0;
  }

  double height(std::size_t d, int number, double s) const {
    // Level over the width of the tow at a crossing, half a cosine in between.
    const double place = s / pitch_[d] - 0.5, level = 0.5 * wide_ / pitch_[d];
    const int across = static_cast<int>(std::floor(place));
    const double way = std::clamp((place - across - level) / (1.0 - 2.0 * level), 0.0, 1.0);
    const double from = sign(d, number, across), to = sign(d, number, across + 1);
    return swing_ * (0.5 * (from + to) + 0.5 * (from - to) * std::cos(std::numbers::pi * way));
  }

  /// Length of a tow's axis over all crossings.
  double length(std::size_t d, double pitch) {
    pitch_[d] = pitch;
    constexpr int parts = 40;
    double sum = 0;
    for (int k = 0; k < parts * p_.count[1 - d]; ++k)
      sum += std::hypot(pitch / parts,
                        height(d, 0, pitch * (k + 1) / parts) - height(d, 0, pitch * k / parts));
    return sum;
  }

  double pitchFor(std::size_t d, double T, const char* unit) {
    const double least = wide_ + std::numbers::pi * swing_ / steepest, wanted = T * p_.segments;
    const int across = p_.count[1 - d];
    const double needed = length(d, least);
    if (p_.pitch > 0 ? p_.pitch < least : wanted < needed)
      throw InputError(
          format("-weave_%s: tows of %d x %d fibres must be %.5g %s apart at least, "
                 "which takes %.0f segments",
                 p_.pitch > 0 ? "pitch" : "segments", p_.filaments[0], p_.filaments[1], least, unit,
                 std::ceil(needed / T)));
    // The outermost crossing may lie half a pitch beyond the ends.
    if (p_.pitch > 0 && !p_.periodic && wanted < length(d, p_.pitch) - p_.pitch)
      throw InputError(
          format("-weave_pitch %g: fibres do not reach across: %d segments take %.5g %s, "
                 "the crossings %.5g",
                 p_.pitch, p_.segments, wanted, unit, length(d, p_.pitch)));
    if (p_.pitch > 0) return p_.pitch;
    double low = least, high = wanted / across;
    for (int k = 0; k < 100; ++k) {
      const double middle = 0.5 * (low + high);
      (length(d, middle) < wanted ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  FabricParameters p_;
  std::vector<Place> places_;
  double wide_, thick_;  ///< between the outer axes of a tow; from its lowest to its highest side
  double swing_;
  std::array<double, 2> pitch_{};
};

/// Opens the sheet until no tows overlap, looking at one repeat of the pattern.
void fit(Fabric& fabric, const FabricParameters& p, double chord) {
  const int filaments = p.filaments[0] * p.filaments[1], tows = p.repeat() + 1;
  for (std::size_t d = 0; d < 2; ++d)
    pointsToLookAt(tows * fabric.pitch(d), chord, 2.0 * tows * filaments, "-scene weave");
  auto make = [&](double scale) {
    fabric.setSwing(scale);
    std::vector<Line> lines;
    for (std::size_t d = 0; d < 2; ++d) {
      const double length = tows * fabric.pitch(d);
      for (int f = 0; f < tows * filaments; ++f)
        lines.push_back({walk(fabric.curve(d, f / filaments, f % filaments, 0.5 * length), chord,
                              static_cast<int>(length / chord) + 3)});
    }
    return lines;
  };
  scaleToFit(make, {p.gap, filaments}, "-scene weave");
}

}  // namespace

bool FabricParameters::over(int i, int j) const {
  const int n = repeat();
  auto modulo = [n](int k) { return (k % n + n) % n; };
  switch (pattern) {
    case twill:
      return modulo(i + j) < floats[0];
    case satin:
      return modulo(j - i * floats[1]) != 0;
    case basket:
      return (modulo(i) / floats[0] + modulo(j) / floats[0]) % 2 == 0;
    default:
      return modulo(i + j) == 0;
  }
}

int FabricParameters::repeat() const {
  if (pattern == twill) return floats[0] + floats[1];
  if (pattern == satin) return floats[0];
  return pattern == basket ? 2 * floats[0] : 2;
}

FabricParameters readFabric(OptionSection& s) {
  FabricParameters p;
  static const std::vector<std::string> names{"plain", "twill", "satin", "basket"};
  const std::string name =
      s.choice("weave_pattern", "plain", names, "which fibres pass over which");
  p.pattern =
      static_cast<FabricParameters::Pattern>(std::ranges::find(names, name) - names.begin());
  auto pair = [&](const char* option, std::array<int, 2> usual, const char* shown,
                  const char* help) {
    if (auto v = s.reals(option, 2, shown, "", help))
      for (std::size_t k = 0; k < 2; ++k) {
        if ((*v)[k] != std::floor((*v)[k]) || (*v)[k] < 1 || (*v)[k] > 1000)
          throw InputError(format("-%s: needs two whole numbers from 1 to 1000", option));
        usual[k] = static_cast<int>((*v)[k]);
      }
    return usual;
  };
  p.floats = pair("weave_float",
                  p.pattern == FabricParameters::satin   ? std::array{5, 2}
                  : p.pattern == FabricParameters::twill ? std::array{2, 2}
                                                         : std::array{2, 1},
                  "twill 2,2; satin 5,2; basket 2,1",
                  "twill: over, under; satin: repeat, step; basket: side by side, 1");
  if (s.given("weave_float") && p.pattern == FabricParameters::plain)
    throw InputError("-weave_float: -weave_pattern plain has none");
  if (p.pattern == FabricParameters::basket && p.floats[1] != 1)
    throw InputError(
        "-weave_float: a basket weave needs how many go side by side and a 1, as in 2,1");
  if (p.pattern == FabricParameters::satin &&
      (p.floats[0] < 3 || p.floats[1] >= p.floats[0] || std::gcd(p.floats[0], p.floats[1]) != 1))
    throw InputError(
        "-weave_float: a satin needs a repeat above two and a step below it that has no divisor in "
        "common with it, as in 5,2 or 8,3");
  p.filaments =
      pair("weave_filaments", {1, 1}, "1,1", "fibres of a tow, side by side and above each other");
  p.layers = static_cast<int>(s.integer("weave_layers", 1, "layers on top of each other", 1, 1000));
  return p;
}

/// A pitch that is given may leave the fibres of a periodic piece too long or too short.
void refuseStrain(const Fabric& fabric, const FabricParameters& p, const std::array<double, 2>& T) {
  for (std::size_t d = 0; d < 2; ++d) {
    double chord = T[d];
    walkAround(fabric.curve(d, 0, 0, 0.0), fabric.span(d), p.segments, chord);
    if (const double strain = chord / T[d] - 1.0; std::abs(strain) > 0.01)
      throw InputError(
          format("-weave_pitch %g: in a periodic weave this strains the bonds along %c by %.1f %%; "
                 "without it the pitch leaves them unstretched",
                 p.pitch, "xy"[d], 100 * strain));
  }
}

std::unique_ptr<Scene> makeFabric(const FabricParameters& p, const SceneContext& context) {
  if (p.periodic && (p.count[0] % p.repeat() || p.count[1] % p.repeat()))
    throw InputError(format("-weave_fibres: a periodic weave of this pattern needs multiples of %d",
                            p.repeat()));
  auto fabric = std::make_shared<Fabric>(p, context);
  const std::array<double, 2> T{context.kinds[p.kinds[0]].length, context.kinds[p.kinds[1]].length};
  fit(*fabric, p, std::min(T[0], T[1]));
  if (p.periodic && p.pitch > 0) refuseStrain(*fabric, p, T);
  const int filaments = p.filaments[0] * p.filaments[1];
  const std::int64_t inLayer = static_cast<std::int64_t>(p.count[0] + p.count[1]) * filaments;
  Laying laying{"weave", nullptr, inLayer * p.layers};
  auto family = [=](std::int64_t f) -> std::size_t {
    return f % inLayer < static_cast<std::int64_t>(p.count[0]) * filaments ? 0 : 1;
  };
  laying.mix =
      KindMix::given(context, laying.fibres, [&](std::int64_t f) { return p.kinds[family(f)]; });
  laying.segments = [n = p.segments](std::int64_t) { return n; };
  laying.line = [=](std::int64_t f) {
    const std::size_t d = family(f);
    const auto within = static_cast<int>(f % inLayer - (d == 1 ? p.count[0] * filaments : 0));
    const double span = fabric->span(d);
    double chord = T[d];
    const Curve curve =
        fabric->curve(d, within / filaments, within % filaments, p.periodic ? 0.0 : 0.5 * span);
    Line line;
    if (p.periodic) {
      line = {walkAround(curve, span, p.segments, chord), true};
      line.round = d == 0 ? Vec3d{span, 0, 0} : Vec3d{0, span, 0};
    } else {
      line.points = walk(curve, chord, p.segments);
    }
    const double layer = fabric->thickness() * static_cast<double>(f / inLayer);
    for (Vec3d& x : line.points) x.z += layer;
    return line;
  };
  const double thickness = p.layers * fabric->thickness();
  if (p.periodic) {
    const double margin = 4.0 * context.kinds.longest();
    Box box;
    box.periodic = {true, true, false};
    box.lower = {0, 0, -0.5 * fabric->thickness() - margin};
    box.upper = {fabric->span(0), fabric->span(1), thickness - 0.5 * fabric->thickness() + margin};
    laying.box = box;
  }
  laying.space = fabric->span(0) * fabric->span(1) * thickness;
  laying.also = format("pitch %.5g,%.5g %s, thickness %.5g %s", fabric->pitch(0), fabric->pitch(1),
                       context.units.length, thickness, context.units.length);
  laying.shaped = p.shaped;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
