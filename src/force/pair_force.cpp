#include "nanoweft/force/pair_force.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "nanoweft/base/messages.hpp"
#include "nanoweft/force/hertz.hpp"
#include "nanoweft/force/pair_kernel.hpp"
#include "nanoweft/force/pair_sift.hpp"
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
    traits_ = traits;
    points_ = choice.points;
    exclude_ = choice.exclude;
    length_ = choice.length;
    cutoff_ = traits.cutoff;
    auto reachOf = [&](double cutoff, Both<int> n) {
      const Both<double> from = outermost(n, length_);
      return cutoff + (from.i + from.j);
    };
    reach_ = reachOf(cutoff_, points_.far);
    if (points_.split()) {
      reach_ = std::max(reach_, reachOf(points_.from, points_.near));
      if constexpr (std::is_same_v<Law, PairTable>)
        parts_.emplace(law_.nearPart(points_.from), law_.farPart(points_.from));
    }
    if (choice.single) single_.emplace(parts_ ? parts_->near : law_);
    setUnits(traits.largestForce, std::max(length_.i, length_.j));
  }

  void add(const PairJob& job, bool energies, PairTally& tally) const override {
    const KernelUnits all{length_, cutoff_, forceUnit_, torqueUnit_, points_.far};
    KernelUnits nearby = all;
    nearby.cutoff = points_.from;
    nearby.points = points_.near;
    // Damping acts once on a pair, with its far part.
    PairJob nearJob = job;
    if constexpr (std::is_same_v<Law, PairTable>) {
      if (farBetweenCentres())
        nearby.centres = &parts_->far;
      else
        nearJob.viscousSum = nullptr;
    }
    auto inside = [&](const LaneView& pairs) {
      if (parts_)
        resolve(parts_->far, nullptr, all, energies, pairs, job, tally);
      else
        resolve(law_, single_ ? &*single_ : nullptr, all, energies, pairs, job, tally);
      tally.resolved += pairs.pairs();
    };
    PairSift sift(job.pose, *job.nearest, reach_);
    const DrawnPairs& drawn = *job.drawn;
    const std::span<const ListPair> rim = drawn.rim;
    const Chunks chunks = drawn.existing(job.chunks);
    for (std::size_t k = chunks.begin; k < chunks.end; ++k) {
      const DrawnPairs::Ends begin = drawn.begin(k), &end = drawn.ends[k];
      if (job.messages) letMessagesGoOn();
      if (parts_) {
        const LaneView pairs = drawn.near.between(begin.near, end.near);
        resolve(parts_->near, single_ ? &*single_ : nullptr, nearby, energies, pairs, nearJob,
                tally);
        if (nearby.centres) {
          tally.resolved += pairs.pairs();
          tally.pointPairs += pairs.pairs();
        }
      }
      inside(drawn.inside.between(begin.inside, end.inside));
      sift.goOn(rim.subspan(begin.rim, end.rim - begin.rim));
      while (PairBlock* block = sift.next(k + 1 == chunks.end)) inside(block->close());
    }
  }

  PairAction resolve(const Vec3d& separation, const Quatd& qi, const Quatd& qj,
                     Both<int>) const override {
    const Vec3d ei = axis1(qi), ej = axis1(qj);
    if (!parts_) return averageOf(law_, cutoff_, points_.near, separation, ei, ej);
    const PairAction far = averageOf(parts_->far, cutoff_, points_.far, separation, ei, ej),
                     near = averageOf(parts_->near, points_.from, points_.near, separation, ei, ej);
    return {near.energy + far.energy, near.force + far.force};
  }

  double closest(const Vec3d& separation, const Quatd& qi, const Quatd& qj) const override {
    double smallest = std::numeric_limits<double>::infinity();
    forPoints(points_.near, separation, axis1(qi), axis1(qj),
              [&](const Vec3d& d) { smallest = std::min(smallest, norm(d)); });
    return smallest;
  }

  PairAction average(Both<int> n, const Vec3d& separation, const Vec3d& ei,
                     const Vec3d& ej) const override {
    return averageOf(law_, cutoff_, n, separation, ei, ej);
  }

 private:
  struct Parts {
    Law near, far;
    Parts(Law n, Law f) : near(std::move(n)), far(std::move(f)) {}
  };

  /// Adds the forces of pairs by a law, or by its table in single precision unless null.
  void resolve(const Law& law, const Single* single, const KernelUnits& units, bool energies,
               const LaneView& pairs, const PairJob& job, PairTally& tally) const {
    const Both<int> points = units.points;
    const bool own = compiled(points, length_);
    const auto which = static_cast<std::size_t>(own ? points.i - 1 : 0);
    if (!own)
      (energies ? addPairs<true, anyPoints, Law>
                : addPairs<false, anyPoints, Law>)(law, units, pairs, job, tally);
    else if (single)
      singleKernels[which][energies](*single, units, pairs, job, tally);
    else
      kernels[which][energies](law, units, pairs, job, tally);
    tally.pointPairs += static_cast<std::int64_t>(points.i) * points.j * pairs.pairs();
  }

  PairAction averageOf(const Law& law, double cutoff, Both<int> n, const Vec3d& separation,
                       const Vec3d& ei, const Vec3d& ej) const {
    PairAction sum;
    forPoints(n, separation, ei, ej, [&](const Vec3d& d) {
      const double r2 = dot(d, d);
      if (r2 >= cutoff * cutoff) return;
      const auto u = law(r2);
      sum.energy += u.energy;
      sum.force += u.slope * d;
    });
    const double share = 1.0 / (n.i * n.j);
    return {share * sum.energy, share * sum.force};
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
  using Kernel = void (*)(const L&, const KernelUnits&, const LaneView&, const PairJob&,
                          PairTally&);
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
  std::optional<Parts> parts_;    ///< of a law that is split
  std::optional<Single> single_;  ///< of the near part, or of a law that is not split
};

}  // namespace

ViscousDamping ViscousDamping::between(const PairForce& force) const {
  const Both<double> length = force.length(), radius = force.radius();
  const double lengths = (length.i / (2.0 * radius.i)) * (length.j / (2.0 * radius.j));
  return {linear * lengths, angular * lengths};
}

ForceUnits ForceUnits::holding(double largest, double length) {
  const double force = std::ldexp(1.0, std::ilogb(largest) + 4 - 63);
  return {force, std::ldexp(force, std::ilogb(length))};
}

void PairForce::setUnits(double largest, double length) {
  const auto [force, torque] = ForceUnits::holding(largest, length);
  forceUnit_ = force, torqueUnit_ = torque;
}

Both<double> PairForce::pointSpan() const {
  return outermost(points_.near, length_);
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
