#include "nanoweft/force/pair_force.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_kernel.hpp"
#include "nanoweft/force/single_table.hpp"
#include "nanoweft/force/vdw.hpp"

namespace nanoweft {

namespace {

constexpr int mostPoints = 9;

/// What every law needs besides its own options.
struct Context {
  const UnitSystem& units;
  const Fibre& fibre;
  PointChoice points;
  int exclude;
  double switchFrom, cutoff;
  bool single;
};

/// What a law says of itself.
struct Traits {
  double cutoff, closestSensible, contactStiffness, largestForce;
};
template <class Law>
Traits traitsOf(const Law& law) {
  return {law.cutoff(), law.closestSensible(), law.contactStiffness(), law.largestForce()};
}

/// Laws without a table have none in single precision.
struct NoSingle {
  template <class Law>
  explicit NoSingle(const Law&) {}
};

// Without the lookups in registers of AVX-512 it would be slower than in doubles.
using VdwSingle = std::conditional_t<singlePays, SingleTable, NoSingle>;

/// A law as the kernel evaluates it: itself, or its table, which may have one in single precision.
template <class Law, class Single = NoSingle>
class PairForceOf final : public PairForce {
 public:
  PairForceOf(std::string name, Law law, const Traits& traits, const Context& context)
      : law_(std::move(law)) {
    if (context.single) single_.emplace(law_);
    name_ = std::move(name);
    points_ = context.points;
    exclude_ = context.exclude;
    length_ = context.fibre.length;
    cutoff_ = traits.cutoff;
    auto reachOf = [&](int n) { return cutoff_ + length_ * (n - 1) / n; };
    reach_ = std::min(reachOf(points_.near), std::max(points_.blend.to, reachOf(points_.far)));
    closestSensible_ = traits.closestSensible;
    contactStiffness_ = traits.contactStiffness;
    // A sum of eight full overlaps still fits into 63 bits.
    forceUnit_ = std::ldexp(1.0, std::ilogb(traits.largestForce) + 4 - 63);
    torqueUnit_ = std::ldexp(forceUnit_, std::ilogb(length_));
  }

  void add(const PairJob& job, bool energies, PairTally& tally) const override {
    const KernelUnits units{length_, cutoff_, forceUnit_, torqueUnit_};
    auto resolve = [&](int points, bool withEnergies, Weight::Kind kind, const LaneView& pairs) {
      const auto which = static_cast<std::size_t>(points - 1);
      const Weight weight{kind, points_.blend};
      if (single_)
        singleKernels[which][withEnergies](*single_, units, weight, pairs, job, tally);
      else
        kernels[which][withEnergies](law_, units, weight, pairs, job, tally);
      tally.pointPairs += static_cast<std::int64_t>(points) * points * pairs.pairs();
    };
    auto unsifted = [&](int points, const LaneView& pairs) {
      resolve(points, energies, Weight::whole, pairs);
      tally.resolved += pairs.pairs();
    };
    PairSift sift(job.pose, *job.nearest, points_.blend, reach_);
    auto sifted = [&](std::span<const ListPair> pairs, bool last) {
      sift.goOn(pairs);
      PairSift::Class which;
      while (PairBlock* block = sift.next(which, last)) {
        const LaneView view = block->close();
        if (which != PairSift::blended) {
          unsifted(which == PairSift::near ? points_.near : points_.far, view);
          continue;
        }
        tally.resolved += view.pairs();
        // The force needs the energies too.
        resolve(points_.near, true, Weight::fading, view);
        resolve(points_.far, true, Weight::rising, view);
      }
    };
    const DrawnPairs& drawn = *job.drawn;
    const std::span<const ListPair> rim = drawn.rim;
    DrawnPairs::Ends begin{};
    for (const auto& end : drawn.ends) {
      unsifted(points_.near, drawn.near.between(begin.near, end.near));
      unsifted(points_.far, drawn.far.between(begin.far, end.far));
      sifted(rim.subspan(begin.rim, end.rim - begin.rim), &end == &drawn.ends.back());
      begin = end;
    }
  }

  PairAction resolve(const Vec3d& separation, const Quatd& qi, const Quatd& qj) const override {
    const Vec3d ei = axis1(qi), ej = axis1(qj);
    const double r = norm(separation);
    if (r <= points_.blend.from) return average(points_.near, separation, ei, ej);
    const PairAction few = average(points_.far, separation, ei, ej);
    if (r >= points_.blend.to) return few;
    const PairAction many = average(points_.near, separation, ei, ej);
    double s, ds;
    points_.blend.factor(r, s, ds);
    return {s * many.energy + (1.0 - s) * few.energy,
            s * many.force + (1.0 - s) * few.force +
                ((many.energy - few.energy) * ds / r) * separation};
  }

  double closest(const Vec3d& separation, const Quatd& qi, const Quatd& qj) const override {
    double smallest = std::numeric_limits<double>::infinity();
    forPoints(points_.near, separation, axis1(qi), axis1(qj),
              [&](const Vec3d& d) { smallest = std::min(smallest, norm(d)); });
    return smallest;
  }

 private:
  /// Calls visit(p_jb - p_ia) for all points of a pair.
  template <class Visit>
  void forPoints(int n, const Vec3d& separation, const Vec3d& ei, const Vec3d& ej,
                 const Visit& visit) const {
    const double half = 0.5 * (n - 1), spacing = length_ / n;
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        visit(separation + ((b - half) * spacing) * ej - ((a - half) * spacing) * ei);
  }

  PairAction average(int n, const Vec3d& separation, const Vec3d& ei, const Vec3d& ej) const {
    PairAction sum;
    forPoints(n, separation, ei, ej, [&](const Vec3d& d) {
      const double r2 = dot(d, d);
      if (r2 >= cutoff_ * cutoff_) return;
      const auto u = law_(r2);
      sum.energy += u.energy;
      sum.force += u.slope * d;
    });
    const double share = 1.0 / (n * n);
    return {share * sum.energy, share * sum.force};
  }

  template <class L>
  using Kernel = void (*)(const L&, const KernelUnits&, const Weight&, const LaneView&,
                          const PairJob&, PairTally&);
  template <class L>
  using Kernels = std::array<std::array<Kernel<L>, 2>, mostPoints>;

  /// By number of points less one, without and with energies.
  static constexpr auto kernels = []<std::size_t... N>(std::index_sequence<N...>) {
    return Kernels<Law>{{{addPairs<false, static_cast<int>(N) + 1, Law>,
                          addPairs<true, static_cast<int>(N) + 1, Law>}...}};
  }
  (std::make_index_sequence<mostPoints>{});
  static constexpr auto singleKernels = []<std::size_t... N>(std::index_sequence<N...>) {
    if constexpr (std::is_same_v<Single, NoSingle>)
      return Kernels<Single>{};
    else
      return Kernels<Single>{{{addPairsSingle<false, static_cast<int>(N) + 1, Single>,
                               addPairsSingle<true, static_cast<int>(N) + 1, Single>}...}};
  }
  (std::make_index_sequence<mostPoints>{});

  Law law_;
  std::optional<Single> single_;
};

std::unique_ptr<PairForce> makeVdw(OptionSection& s, const Context& c, bool active) {
  VdwParameters p;
  const std::string& energy = c.units.energy;
  const std::string perArea = energy + "/" + c.units.length + "^2";
  p.smooth =
      s.choice("vdw_splice", "smooth", {"smooth", "kink"},
               "where the linear repulsion joins: equal stiffness, or the minimum") == "smooth";
  p.epsilon = s.real("vdw_epsilon", p.epsilon, c.units.energy, "depth parameter eps", positive);
  p.a = s.real("vdw_a", p.a, "", "factor A of the repulsive power", positive);
  p.b = s.real("vdw_b", p.b, "", "factor B of the attractive power", positive);
  p.alpha = s.real("vdw_alpha", p.alpha, "", "repulsive exponent", positive);
  p.beta = s.real("vdw_beta", p.beta, "", "attractive exponent, below alpha", positive);
  p.stiffness = s.real("vdw_stiffness", p.stiffness, perArea.c_str(),
                       "k of the repulsion: u = ... + k (r - rs)^2", positive);
  if (!active) return nullptr;
  if (p.beta >= p.alpha)
    throw InputError(format("-vdw_beta %g: must be below -vdw_alpha %g", p.beta, p.alpha));
  p.radius = c.fibre.radius;
  p.switchFrom = c.switchFrom;
  p.cutoff = c.cutoff;
  const Vdw law(p);
  if (law.spliceDistance() >= p.switchFrom || law.restDistance() >= p.switchFrom)
    throw InputError(format("-pair_switch %g: must lie beyond the resting distance %g %s",
                            p.switchFrom, law.restDistance(), c.units.length));
  return std::make_unique<PairForceOf<PairTable, VdwSingle>>("vdw", law.table(), traitsOf(law), c);
}

std::unique_ptr<PairForce> makeHertz(OptionSection& s, const Context& c, bool active) {
  const std::string unit = std::string(c.units.energy) + "/" + c.units.length + "^2.5";
  const double stiffness =
      s.real("hertz_stiffness", 200.0, unit.c_str(), "K of u = K (2 rf - r)^2.5", positive);
  if (!active) return nullptr;
  const Hertz law(stiffness, c.fibre.radius);
  return std::make_unique<PairForceOf<Hertz>>("hertz", law, traitsOf(law), c);
}

struct Entry {
  const char* name;
  std::unique_ptr<PairForce> (*make)(OptionSection&, const Context&, bool active);
};

// One line registers a law.
constexpr Entry laws[] = {
    {"vdw", makeVdw},
    {"hertz", makeHertz},
};

}  // namespace

std::unique_ptr<PairForce> readPairForce(Options& options, const UnitSystem& units,
                                         const Fibre& fibre) {
  std::vector<std::string> names;
  for (const Entry& e : laws) names.push_back(e.name);
  names.push_back("none");
  OptionSection pair(options, "Pair forces");
  const std::string chosen = pair.choice("pair", "vdw", names, "law of the forces between fibres");
  OptionSection s(options, "Pair forces", chosen != "none", "-pair is none");
  Context c{units, fibre, {}, 20, 0, 0, false};
  c.points.near =
      static_cast<int>(s.integer("pair_points", 3, "points per segment", 1, mostPoints));
  c.exclude = static_cast<int>(
      s.integer("pair_exclude", 20, "segments of one fibre interact from this many places apart", 2,
                1000000));
  OptionSection range(options, "Pair forces", chosen == "vdw", "-pair is " + chosen);
  c.single = range.choice("pair_precision", "double", {"double", "single"},
                          "of the law's values and of their sums over a pair's points") == "single";
  if (c.single && !singlePays)
    throw InputError(
        "-pair_precision single: needs a build for AVX-512 (-DNANOWEFT_ARCH=x86-64-v4 or native "
        "where the processor has it); in others it would be slower than double");
  c.switchFrom = range
                     .maybeReal("pair_switch", "3 T", units.length,
                                "distance where the switch-off begins", positive)
                     .value_or(3.0 * fibre.length);
  c.cutoff =
      range
          .maybeReal("pair_cutoff", "4 T", units.length, "distance where pair forces end", positive)
          .value_or(4.0 * fibre.length);
  if (c.cutoff <= c.switchFrom)
    throw InputError(
        format("-pair_cutoff %g: must lie beyond -pair_switch %g", c.cutoff, c.switchFrom));
  c.points.far =
      static_cast<int>(range
                           .maybeInteger("pair_far_points", "as -pair_points",
                                         "points per segment of pairs far apart", 1, c.points.near)
                           .value_or(c.points.near));
  const bool fewer = c.points.far < c.points.near;
  OptionSection far(options, "Pair forces", chosen == "vdw" && fewer,
                    "-pair_far_points is not below -pair_points");
  c.points.blend.from =
      far.maybeReal("pair_far_from", "2.5 T", units.length,
                    "centre distance from which -pair_far_points begin to take over", positive)
          .value_or(2.5 * fibre.length);
  c.points.blend.to =
      c.points.blend.from + far.maybeReal("pair_far_width", "T/2", units.length,
                                          "width of the range in which they take over", positive)
                                .value_or(0.5 * fibre.length);
  if (!fewer) c.points.blend.from = c.points.blend.to = std::numeric_limits<double>::infinity();
  std::unique_ptr<PairForce> result;
  for (const Entry& e : laws) {
    const bool active = chosen == e.name;
    OptionSection own(options, "Pair forces", active, "-pair is " + chosen);
    if (auto force = e.make(own, c, active)) result = std::move(force);
  }
  return result;
}

}  // namespace nanoweft
