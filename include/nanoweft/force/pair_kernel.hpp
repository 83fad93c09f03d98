/// The pair kernel: a pair's sum over its n x n point pairs, one pair in each SIMD lane.
#pragma once

#include <cmath>
#include <limits>

#include "nanoweft/base/both.hpp"
#include "nanoweft/base/floats.hpp"
#include "nanoweft/force/gather.hpp"
#include "nanoweft/force/lane_pairs.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/pair_table.hpp"
#include "nanoweft/force/sums.hpp"
#include "nanoweft/force/viscous_sum.hpp"

namespace nanoweft {

/// Energy, force on i (on j: the negative) and torques of one pair, averaged over the points.
template <class V>
struct PairResult {
  V energy{};
  Vec3<V> force, torqueI, torqueJ;
};

/// Sums of f, sa f, sb f and sa sb f, and of the energies, over the points of a pair.
template <class V>
struct PointSums {
  V f{}, a{}, b{}, ab{}, energy{};

  /// Adds the sums of f and sb f over the points of j, for the point of i at the place `sa`.
  NW_INLINE void add(double sa, const V& row, const V& rowB) {
    f += row;
    b += rowB;
    a = multiplyAdd(number<V>(sa), row, a);
    ab = multiplyAdd(number<V>(sa), rowB, ab);
  }
};

/// Dot products of a pair's separation and axes: all that the distances of its points depend on.
template <class V>
struct PairShape {
  V center2, alongI{}, alongJ{}, cosine{};
};

template <class V>
NW_INLINE PairShape<V> shapeOf(const Vec3<V>& separation, const Vec3<V>& ei, const Vec3<V>& ej) {
  return {fusedDot(separation, separation), fusedDot(separation, ei), fusedDot(separation, ej),
          fusedDot(ei, ej)};
}

/// Where point k of n lies along its segment.
NW_INLINE double pointPlace(int k, int n, double length) {
  return (k - 0.5 * (n - 1)) / n * length;
}

template <class V>
NW_INLINE V squaredDistance(const PairShape<V>& shape, double sa, double sb) {
  const V from2 = shape.center2 + sa * (sa - 2.0 * shape.alongI);
  return from2 + sb * (sb + 2.0 * (shape.alongJ - sa * shape.cosine));
}

/// The force of a point pair, u'(r)/r; adds its energy. Values beyond the cutoff are zero, so no
/// lane needs a mask.
template <bool Energies, class Law, class V>
NW_INLINE V addPoint(const Law& law, const V& r2, PointSums<V>& sums) {
  if constexpr (Energies) {
    const PairValue<V> value = law(r2);
    sums.energy += value.energy;
    return value.slope;
  } else {
    return law.slope(r2);
  }
}

/// Sums a law over the points of a pair. Distances of points follow from the dot products in
/// `shape`, so that a point pair costs little more than its force. With Law::couples, two points of
/// j that lie symmetrically to its centre are taken together and share most of the arithmetic.
template <bool Energies, int N, class Law, class V>
NW_INLINE PointSums<V> sumPoints(const Law& law, double length, const PairShape<V>& shape) {
  PointSums<V> sums;
  auto forceAt = [&](const V& r2) __attribute__((always_inline)) {
    return addPoint<Energies>(law, r2, sums);
  };
  auto place = [&](int k) { return pointPlace(k, N, length); };
#pragma GCC unroll 3
  for (int a = 0; a < N; ++a) {
    const double sa = place(a);
    // |separation - sa ei|^2 and twice its part along ej.
    const V from2 =
        multiplyAdd(number<V>(-2.0 * sa), shape.alongI, V(shape.center2 + number<V>(sa * sa)));
    const V along = number<V>(2.0) * multiplyAdd(number<V>(-sa), shape.cosine, shape.alongJ);
    V row = number<V>(0.0), rowB = number<V>(0.0);
    if constexpr (Law::couples) {
      if constexpr (N % 2 == 1) row = forceAt(from2);
#pragma GCC unroll 4
      for (int b = 0; b < N / 2; ++b) {
        const double sb = place(N - 1 - b);
        const V middle = from2 + number<V>(sb * sb), part = number<V>(sb) * along;
        const V behind = forceAt(V(middle - part)), before = forceAt(V(middle + part));
        row += behind + before;
        rowB = multiplyAdd(number<V>(sb), V(before - behind), rowB);
      }
    } else {
#pragma GCC unroll 9
      for (int b = 0; b < N; ++b) {
        const double sb = place(b);
        const V f = forceAt(multiplyAdd(number<V>(sb), along, V(from2 + number<V>(sb * sb))));
        row += f;
        rowB = multiplyAdd(number<V>(sb), f, rowB);
      }
    }
    sums.add(sa, row, rowB);
  }
  return sums;
}

/// What the kernels of a law share: segments and their points, cutoff, and the units of the integer
/// sums, which are powers of two.
struct KernelUnits {
  Both<double> length;
  double cutoff, force, torque;
  Both<int> points;
  /// Of the near part of a split law: the far part, if that acts between the centres and is to be
  /// added in the same pass.
  const PairTable* centres = nullptr;
};

/// In place of a number of points N that is equal for both segments and known to the compiler: the
/// numbers and lengths are those of KernelUnits.
inline constexpr int anyPoints = 0;

/// As `sumPoints` with any numbers of points; written out, since a common view of a point's line
/// made that kernel 3 % slower. Points of i that are out of reach of all of j in every lane are
/// left out, which matters for long segments.
template <bool Energies, class Law, class V>
NW_INLINE PointSums<V> sumAnyPoints(const Law& law, const KernelUnits& units,
                                    const PairShape<V>& shape) {
  PointSums<V> sums;
  const auto [ni, nj] = units.points;
  const double reach = units.cutoff + 0.5 * units.length.j, reach2 = reach * reach;
  for (int a = 0; a < ni; ++a) {
    const double sa = pointPlace(a, ni, units.length.i);
    const V from2 =
        multiplyAdd(number<V>(-2.0 * sa), shape.alongI, V(shape.center2 + number<V>(sa * sa)));
    if (lanesBelow(from2, reach2) == 0) continue;
    const V along = number<V>(2.0) * multiplyAdd(number<V>(-sa), shape.cosine, shape.alongJ);
    V row = number<V>(0.0), rowB = number<V>(0.0);
    for (int b = 0; b < nj; ++b) {
      const double sb = pointPlace(b, nj, units.length.j);
      const V r2 = multiplyAdd(number<V>(sb), along, V(from2 + number<V>(sb * sb)));
      const V f = addPoint<Energies>(law, r2, sums);
      row += f;
      rowB = multiplyAdd(number<V>(sb), f, rowB);
    }
    sums.add(sa, row, rowB);
  }
  return sums;
}

template <bool Energies, int N, class Law, class V>
NW_INLINE PointSums<V> sumPairPoints(const Law& law, const KernelUnits& units,
                                     const PairShape<V>& shape) {
  if constexpr (N == anyPoints)
    return sumAnyPoints<Energies>(law, units, shape);
  else
    return sumPoints<Energies, N>(law, units.length.i, shape);
}

/// Force and torques of a pair (means over its points) in units of the integer sums; its energy
/// in the unit of force times one length. The few sums over points are scaled instead of all
/// components; since units are powers of two, that changes no bits.
template <int N, class V>
NW_INLINE PairResult<V> assemble(const PointSums<V>& sums, const KernelUnits& units,
                                 const Vec3<V>& separation, const Vec3<V>& ei, const Vec3<V>& ej) {
  PairResult<V> result;
  const double share = N == anyPoints ? 1.0 / (units.points.i * units.points.j) : 1.0 / (N * N);
  const V perForce(share / units.force), f = perForce * sums.f;
  result.energy = perForce * sums.energy;
  if constexpr (N != 1) {
    const V perTorque(share / units.torque), ab = perTorque * sums.ab;
    result.force = multiplyAdd(V(perForce * sums.b), ej,
                               multiplyAdd(V(-(perForce * sums.a)), ei, f * separation));
    result.torqueI = fusedCross(ei, multiplyAdd(V(perTorque * sums.a), separation, ab * ej));
    result.torqueJ = fusedCross(ej, multiplyAdd(V(-(perTorque * sums.b)), separation, ab * ei));
  } else {
    result.force = f * separation;
    result.torqueI = result.torqueJ = {V(0.0), V(0.0), V(0.0)};
  }
  return result;
}

template <bool Energies, int N, class Law, class V>
NW_INLINE PairResult<V> resolvePair(const Law& law, const KernelUnits& units,
                                    const Vec3<V>& separation, const Vec3<V>& ei,
                                    const Vec3<V>& ej) {
  const auto sums = sumPairPoints<Energies, N>(law, units, shapeOf(separation, ei, ej));
  return assemble<N>(sums, units, separation, ei, ej);
}

/// One row of a group: in each lane the first segment and one of its partners.
template <int N>
struct LaneRow {
  const LaneGroup& group;
  const std::int32_t* j;
  int place;  ///< which of the partners
  Vec3<Lanes> separation, ei, ej{};

  NW_INLINE LaneRow(const PairJob& job, const LaneGroup& g, const Vec3<Lanes>& xi,
                    const Vec3<Lanes>& axis, const std::int32_t* partners, int k)
      : group(g),
        j(partners + k * laneCount),
        place(k),
        separation((*job.nearest)(gatherPositions(job.pose, j) - xi)),
        ei(axis) {
    if constexpr (N != 1) ej = axis1(gatherOrientations(job.pose, j));
  }
  NW_INLINE PairShape<Lanes> shape() const { return shapeOf(separation, ei, ej); }
  /// False for padding lanes, those whose first segment has no partner left.
  NW_INLINE bool counts(int lane) const { return place < group.count[lane]; }
};

/// Viscous forces of those pairs of a row that have points within the cutoff (model.md 5).
/// Not inlined, since it is seldom used and would take registers from the kernel.
template <int N>
[[gnu::noinline]] void addViscous(const PairJob& job, const KernelUnits& units,
                                  const LaneRow<N>& row, PairTally& tally) {
  const auto shape = row.shape();
  Lanes closest2(std::numeric_limits<double>::infinity());
  const double cutoff = units.centres ? units.centres->cutoff() : units.cutoff;
  const auto [ni, nj] = units.centres ? Both<int>(1) : units.points;
  for (int a = 0; a < ni; ++a)
    for (int b = 0; b < nj; ++b) {
      const double sa = pointPlace(a, ni, units.length.i), sb = pointPlace(b, nj, units.length.j);
      closest2 = smaller(squaredDistance(shape, sa, sb), closest2);
    }
  const unsigned touching = lanesBelow(closest2, cutoff * cutoff);
  for (int k = 0; k < laneCount; ++k) {
    if (!(touching >> k & 1) || !row.counts(k)) continue;
    addDamping(job, row.group.first[k], row.j[k], tally);
  }
}

/// The far part of a split law that acts between the centres (KernelUnits::centres), if any.
class CentreForce {
 public:
  explicit CentreForce(const KernelUnits& units)
      : law_(units.centres ? PairTable::Kernel(*units.centres) : PairTable::Kernel()),
        perForce_(1.0 / units.force),
        acts_(units.centres) {}

  /// Adds to a pair what the kernel of one point makes of the far part, to the bit: a pair has the
  /// same sum whether it has been drawn as a near one or not.
  template <bool Energies>
  NW_INLINE void addTo(PairResult<Lanes>& pair, const Vec3<Lanes>& separation,
                       const auto& counts) const {
    if (!acts_) return;
    const Lanes r2 = fusedDot(separation, separation);
    PairValue<Lanes> value{};
    if constexpr (Energies)
      value = law_(r2);
    else
      value.slope = law_.slope(r2);
    const Lanes f = perForce_ * select(counts, value.slope, Lanes(0.0));
    pair.force = multiplyAdd(f, separation, pair.force);
    if constexpr (Energies) pair.energy += perForce_ * select(counts, value.energy, Lanes(0.0));
  }

 private:
  PairTable::Kernel law_;
  Lanes perForce_;
  bool acts_;
};

/// A group and the sums of forces on its first segments, which `close` writes to memory.
template <bool Energies, int N>
class LaneSums {
 public:
  NW_INLINE LaneSums(const PairJob& job, const LaneGroup& group, const CentreForce& centres)
      : job_(job), group_(group), centres_(centres), x_(gatherPositions(job.pose, group.first)) {
    if constexpr (N != 1) e_ = axis1(gatherOrientations(job.pose, group.first));
    count_ = toLanes(loadNumbers(group.count));
  }

  NW_INLINE LaneRow<N> row(const std::int32_t* partners, int k) const {
    return {job_, group_, x_, e_, partners, k};
  }

  NW_INLINE void add(const LaneRow<N>& row, PointSums<Lanes> sums, const KernelUnits& units,
                     PairTally& tally) {
    const auto counts = count_ > Lanes(row.place);
    for (Lanes* sum : {&sums.f, &sums.a, &sums.b, &sums.ab, &sums.energy})
      *sum = select(counts, *sum, Lanes(0.0));
    auto pair = assemble<N>(sums, units, row.separation, row.ei, row.ej);
    if constexpr (N != 1) centres_.addTo<Energies>(pair, row.separation, counts);
    LaneIntegers onJ[6];
    auto whole = [](LaneIntegers* to, const Vec3<Lanes>& v) {
      to[0] = nearestIntegers(v.x);
      to[1] = nearestIntegers(v.y);
      to[2] = nearestIntegers(v.z);
    };
    LaneIntegers force[3], torque[3];
    whole(force, pair.force);
    for (int c = 0; c < 3; ++c) {
      total_[c] += force[c];
      onJ[c] = -force[c];
    }
    if constexpr (N != 1) {
      whole(torque, pair.torqueI);
      for (int c = 0; c < 3; ++c) total_[3 + c] += torque[c];
      whole(onJ + 3, pair.torqueJ);
    }
    put(row.j, onJ);
    if constexpr (Energies)
      for (int k = 0; k < laneCount; ++k)
        if (row.counts(k) && (job_.both || job_.mine(group_.first[k])))
          tally.energy.add(units.force * pair.energy[static_cast<std::size_t>(k)],
                           tally.energyUnit);
    if (job_.viscousSum) addViscous(job_, units, row, tally);
  }

  NW_INLINE void close() const { put(group_.first, total_); }

 private:
  /// Adds the lanes' sums to the segments' records, or to the spare ones for others' segments.
  NW_INLINE void put(const std::int32_t* segments, const LaneIntegers* sums) const {
    Row rows[laneCount];
    toRows<N == 1 ? 3 : 6>(sums, rows);
    // `segments` serve as record numbers unless a lane needs the spare record: numbers that have
    // just been stored as a vector are slow to load one by one.
    const LaneNumbers s = loadNumbers(segments);
    const LaneNumbers others = (s < job_.begin) | (s >= job_.end);
    if (none(others)) return addRows(job_.sum, segments, rows);
    const LaneNumbers places = others ? (job_.both ? s : LaneNumbers{}) + job_.spare : s;
    std::int32_t place[laneCount];
    std::memcpy(place, &places, sizeof places);
    addRows(job_.sum, place, rows);
  }

  const PairJob& job_;
  const LaneGroup& group_;
  const CentreForce& centres_;
  Vec3<Lanes> x_, e_{};
  Lanes count_;
  LaneIntegers total_[6]{};
};

/// Prefetches poses and sums of the partners eight rows ahead, which may lie anywhere in memory.
NW_INLINE void fetchAhead(const PairJob& job, const std::int32_t* partners,
                          const std::int32_t* end) {
  constexpr int ahead = 8 * laneCount;
  if (end - partners < ahead + laneCount) return;
  for (int k = 0; k < laneCount; ++k) {
    const auto partner = static_cast<std::size_t>(partners[ahead + k]);
    __builtin_prefetch(job.pose + 8 * partner);
    // A ghost has no record; prefetching beyond the end of the array is harmless.
    __builtin_prefetch(job.sum + partner, 1);
  }
}

/// Adds the forces of pairs with N (or any) points on each axis.
template <bool Energies, int N, class Law>
void addPairs(const Law& shared, const KernelUnits& units, const LaneView& pairs,
              const PairJob& job, PairTally& tally) {
  typename Law::Kernel law(shared);
  keepInMemory(law);
  CentreForce centres(units);
  keepInMemory(centres);
  const std::int32_t* partners = pairs.partners;
  for (const LaneGroup& group : pairs.groups) {
    LaneSums<Energies, N> sums(job, group, centres);
    for (int k = 0; k < group.depth(); ++k) {
      fetchAhead(job, partners + k * laneCount, pairs.end);
      const auto row = sums.row(partners, k);
      sums.add(row, sumPairPoints<Energies, N>(law, units, row.shape()), units, tally);
    }
    sums.close();
    partners += group.depth() * laneCount;
  }
}

/// As addPairs, with the sums over points in single precision, two rows at a time. Centre distances
/// and axes before the sums, and forces and torques after them, are in double precision.
template <bool Energies, int N, class Law>
void addPairsSingle(const Law& shared, const KernelUnits& units, const LaneView& pairs,
                    const PairJob& job, PairTally& tally) {
  typename Law::Kernel law(shared);
  keepInMemory(law);
  CentreForce centres(units);
  keepInMemory(centres);
  const std::int32_t* partners = pairs.partners;
  for (const LaneGroup& group : pairs.groups) {
    LaneSums<Energies, N> sums(job, group, centres);
    for (int k = 0; k < group.depth(); k += 2) {
      fetchAhead(job, partners + k * laneCount, pairs.end);
      const int count = std::min(2, group.depth() - k);
      const LaneRow<N> rows[2] = {sums.row(partners, k), sums.row(partners, k + count - 1)};
      auto shape = [&](const LaneRow<N>& row) {
        auto result = row.shape();
        result.center2 -= law.origin();
        return result;
      };
      const auto low = shape(rows[0]), high = shape(rows[1]);
      const PairShape<Floats> both{
          rounded(low.center2, high.center2), rounded(low.alongI, high.alongI),
          rounded(low.alongJ, high.alongJ), rounded(low.cosine, high.cosine)};
      const auto points = sumPoints<Energies, N>(law, units.length.i, both);
#pragma GCC unroll 1
      for (int n = 0; n < count; ++n) {
        PointSums<Lanes> part{half(points.f, n), half(points.a, n), half(points.b, n),
                              half(points.ab, n)};
        if constexpr (Energies) part.energy = half(points.energy, n);
        sums.add(rows[n], part, units, tally);
      }
    }
    sums.close();
    partners += group.depth() * laneCount;
  }
}

}  // namespace nanoweft
