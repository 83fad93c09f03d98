#include "nanoweft/force/pair_force.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_kernel.hpp"
#include "nanoweft/force/single_table.hpp"

namespace nanoweft {

namespace {

/// Stands for the single-precision table of a law that has none.
struct NoSingle {
  template <class Law>
  explicit NoSingle(const Law&) {}
};

// Single precision is faster than double only where AVX-512 looks the table up in registers.
using VdwSingle = std::conditional_t<singlePays, SingleTable, NoSingle>;

/// The pair force of a law, which the kernel evaluates as it stands (Hertz) or as a table. `Single`
/// is the law's table in single precision.
template <class Law, class Single = NoSingle>
class PairForceOf final : public PairForce {
 public:
  PairForceOf(Law law, const PairTraits& traits, const PairChoice& choice) : law_(std::move(law)) {
    if (choice.single) single_.emplace(law_);
    traits_ = traits;
    points_ = choice.points;
    exclude_ = choice.exclude;
    length_ = choice.length;
    cutoff_ = traits.cutoff;
    auto reachOf = [&](Both<int> n) {
      return cutoff_ + 0.5 * (length_.i * (n.i - 1) / n.i + length_.j * (n.j - 1) / n.j);
    };
    reach_ = std::min(reachOf(points_.near), std::max(points_.blend.to, reachOf(points_.far)));
    setUnits(traits.largestForce, std::max(length_.i, length_.j));
  }

  void add(const PairJob& job, bool energies, PairTally& tally) const override {
    auto resolve = [&](Both<int> points, bool withEnergies, Weight::Kind kind,
                       const LaneView& pairs) {
      const KernelUnits units{length_, cutoff_, forceUnit_, torqueUnit_, points};
      const auto which = static_cast<std::size_t>(compiled(points) ? points.i - 1 : 0);
      const Weight weight{kind, points_.blend};
      if (!compiled(points))
        (withEnergies ? addPairs<true, anyPoints, Law>
                      : addPairs<false, anyPoints, Law>)(law_, units, weight, pairs, job, tally);
      else if (single_)
        singleKernels[which][withEnergies](*single_, units, weight, pairs, job, tally);
      else
        kernels[which][withEnergies](law_, units, weight, pairs, job, tally);
      tally.pointPairs += static_cast<std::int64_t>(points.i) * points.j * pairs.pairs();
    };
    auto unsifted = [&](Both<int> points, const LaneView& pairs) {
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
        // The force of a blended pair contains its energy times the slope of the weight.
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

  PairAction resolve(const Vec3d& separation, const Quatd& qi, const Quatd& qj,
                     Both<int>) const override {
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

  PairAction average(Both<int> n, const Vec3d& separation, const Vec3d& ei,
                     const Vec3d& ej) const override {
    PairAction sum;
    forPoints(n, separation, ei, ej, [&](const Vec3d& d) {
      const double r2 = dot(d, d);
      if (r2 >= cutoff_ * cutoff_) return;
      const auto u = law_(r2);
      sum.energy += u.energy;
      sum.force += u.slope * d;
    });
    const double share = 1.0 / (n.i * n.j);
    return {share * sum.energy, share * sum.force};
  }

 private:
  /// Is there a kernel for this number of points?
  bool compiled(Both<int> points) const {
    return points.same() && points.i <= mostCompiledPoints && length_.same();
  }

  /// Calls visit(p_jb - p_ia) for all points of a pair.
  template <class Visit>
  void forPoints(Both<int> n, const Vec3d& separation, const Vec3d& ei, const Vec3d& ej,
                 const Visit& visit) const {
    const Both<double> half{0.5 * (n.i - 1), 0.5 * (n.j - 1)},
        spacing{length_.i / n.i, length_.j / n.j};
    for (int a = 0; a < n.i; ++a)
      for (int b = 0; b < n.j; ++b)
        visit(separation + ((b - half.j) * spacing.j) * ej - ((a - half.i) * spacing.i) * ei);
  }

  template <class L>
  using Kernel = void (*)(const L&, const KernelUnits&, const Weight&, const LaneView&,
                          const PairJob&, PairTally&);
  template <class L>
  using Kernels = std::array<std::array<Kernel<L>, 2>, mostCompiledPoints>;

  /// By number of points less one, without and with energies.
  static constexpr auto kernels = []<std::size_t... N>(std::index_sequence<N...>) {
    return Kernels<Law>{{{addPairs<false, static_cast<int>(N) + 1, Law>,
                          addPairs<true, static_cast<int>(N) + 1, Law>}...}};
  }
  (std::make_index_sequence<mostCompiledPoints>{});
  static constexpr auto singleKernels = []<std::size_t... N>(std::index_sequence<N...>) {
    if constexpr (std::is_same_v<Single, NoSingle>)
      return Kernels<Single>{};
    else
      return Kernels<Single>{{{addPairsSingle<false, static_cast<int>(N) + 1, Single>,
                               addPairsSingle<true, static_cast<int>(N) + 1, Single>}...}};
  }
  (std::make_index_sequence<mostCompiledPoints>{});

  Law law_;
  std::optional<Single> single_;
};

}  // namespace

ViscousDamping ViscousDamping::between(const PairForce& force) const {
  const Both<double> length = force.length(), radius = force.radius();
  const double lengths = (length.i / (2.0 * radius.i)) * (length.j / (2.0 * radius.j));
  return {linear * lengths, angular * lengths};
}

void PairForce::setUnits(double largest, double length) {
  // A sum of eight full overlaps still fits into 63 bits.
  forceUnit_ = std::ldexp(1.0, std::ilogb(largest) + 4 - 63);
  torqueUnit_ = std::ldexp(forceUnit_, std::ilogb(length));
}

Both<double> PairForce::pointSpan() const {
  const Both<int> n = points_.near;
  return {0.5 * length_.i * (n.i - 1) / n.i, 0.5 * length_.j * (n.j - 1) / n.j};
}

std::unique_ptr<PairForce> makePairForce(const PairTable& law, const PairTraits& traits,
                                         const PairChoice& choice) {
  return std::make_unique<PairForceOf<PairTable, VdwSingle>>(law, traits, choice);
}

std::unique_ptr<PairForce> makePairForce(const Hertz& law, const PairTraits& traits,
                                         const PairChoice& choice) {
  return std::make_unique<PairForceOf<Hertz>>(law, traits, choice);
}

bool singlePrecisionPays() {
  return singlePays;
}

}  // namespace nanoweft
