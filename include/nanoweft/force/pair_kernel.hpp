/// The pair sum, a SIMD lane per pair: n x n point pairs of a block, integer scatter.
#pragma once

#include <cmath>
#include <limits>

#include "nanoweft/base/floats.hpp"
#include "nanoweft/force/gather.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/pair_sift.hpp"
#include "nanoweft/force/pair_table.hpp"
#include "nanoweft/force/sums.hpp"

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
};

/// How the two axes of a pair lie: all that distances of their points depend on.
template <class V>
struct PairShape {
  V center2, alongI{}, alongJ{}, cosine{};
};

template <class V>
NW_INLINE PairShape<V> shapeOf(const Vec3<V>& separation, const Vec3<V>& ei, const Vec3<V>& ej) {
  return {dot(separation, separation), dot(separation, ei), dot(separation, ej), dot(ei, ej)};
}

/// Where a point lies along its segment.
template <int N>
NW_INLINE double pointPlace(int k, double length) {
  return (k - 0.5 * (N - 1)) / N * length;
}

template <class V>
NW_INLINE V squaredDistance(const PairShape<V>& shape, double sa, double sb) {
  const V from2 = shape.center2 + sa * (sa - 2.0 * shape.alongI);
  return from2 + sb * (sb + 2.0 * (shape.alongJ - sa * shape.cosine));
}

/// Distances of points follow from dot products, so that a point pair costs little more than its
/// force. With Law::couples, points of j on both sides of its centre are taken together and share
/// most of the sums.
template <bool Energies, int N, class Law, class V>
NW_INLINE PointSums<V> sumPoints(const Law& law, double length, const PairShape<V>& shape) {
  PointSums<V> sums;
  auto forceAt = [&](const V& r2) __attribute__((always_inline)) {
    // Law values beyond the cutoff are zero, so no lane needs a mask.
    if constexpr (Energies) {
      const PairValue<V> value = law(r2);
      sums.energy += value.energy;
      return value.slope;
    } else {
      return law.slope(r2);
    }
  };
  auto place = [&](int k) { return pointPlace<N>(k, length); };
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
    sums.f += row;
    sums.b += rowB;
    sums.a = multiplyAdd(number<V>(sa), row, sums.a);
    sums.ab = multiplyAdd(number<V>(sa), rowB, sums.ab);
  }
  return sums;
}

/// What the kernels of a law share: segment length, cutoff, and the units of the integer sums,
/// which are powers of two.
struct KernelUnits {
  double length, cutoff, force, torque;
};

/// Force and torques of the means over N x N points, in units of the sums; the energy in units of
/// the force times one length. (Scaled with the few sums over points instead of all components;
/// powers of two change no bits.)
template <int N, class V>
NW_INLINE PairResult<V> assemble(const PointSums<V>& sums, const KernelUnits& units,
                                 const Vec3<V>& separation, const Vec3<V>& ei, const Vec3<V>& ej) {
  PairResult<V> result;
  constexpr double share = 1.0 / (N * N);
  const V perForce(share / units.force), f = perForce * sums.f;
  result.energy = perForce * sums.energy;
  if constexpr (N > 1) {
    const V perTorque(share / units.torque), ab = perTorque * sums.ab;
    result.force = f * separation - V(perForce * sums.a) * ei + V(perForce * sums.b) * ej;
    result.torqueI = cross(ei, V(perTorque * sums.a) * separation + ab * ej);
    result.torqueJ = cross(ej, ab * ei - V(perTorque * sums.b) * separation);
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
  const auto sums = sumPoints<Energies, N>(law, units.length, shapeOf(separation, ei, ej));
  return assemble<N>(sums, units, separation, ei, ej);
}

/// A SIMD group of a block's pairs.
template <int N>
struct PairGroup {
  const std::int32_t *i, *j, *sumI, *sumJ;
  int used;  ///< lanes beyond repeat a pair and do not count
  Vec3<Lanes> separation, ei{}, ej{};

  NW_INLINE PairGroup(const PairBlock& block, const PairJob& job, int first)
      : i(block.i + first),
        j(block.j + first),
        sumI(block.sumI + first),
        sumJ(block.sumJ + first),
        used(std::min(laneCount, block.count - first)),
        separation(block.separation(first)) {
    if constexpr (N > 1) {
      ei = axis1(gatherOrientations(job.pose, i));
      ej = axis1(gatherOrientations(job.pose, j));
    }
  }
};

/// Viscous forces of those pairs of a group of which points are within the cutoff (physics.md 5).
/// Not inlined: seldom used, it would take registers from the rest.
template <int N>
[[gnu::noinline]] void addViscous(const PairJob& job, const KernelUnits& units,
                                  const PairGroup<N>& group) {
  const auto shape = shapeOf(group.separation, group.ei, group.ej);
  Lanes closest2(std::numeric_limits<double>::infinity());
  for (int a = 0; a < N; ++a)
    for (int b = 0; b < N; ++b) {
      const double sa = pointPlace<N>(a, units.length), sb = pointPlace<N>(b, units.length);
      closest2 = smaller(squaredDistance(shape, sa, sb), closest2);
    }
  const unsigned touching = lanesBelow(closest2, units.cutoff * units.cutoff);
  for (int k = 0; k < group.used; ++k) {
    if (!(touching >> k & 1)) continue;
    const std::int32_t i = group.i[k], j = group.j[k];
    const bool mineI = i >= job.begin && i < job.end, mineJ = j >= job.begin && j < job.end;
    for (int c = 0; c < 3; ++c) {
      const auto f = std::llrint(job.viscous.linear *
                                 (job.velocity[3 * j + c] - job.velocity[3 * i + c]) / units.force);
      const auto t = std::llrint(job.viscous.angular *
                                 (job.angular[3 * j + c] - job.angular[3 * i + c]) / units.torque);
      if (mineI) {
        job.viscousSum[6 * i + c] += f;
        job.viscousSum[6 * i + 3 + c] += t;
      }
      if (mineJ) {
        job.viscousSum[6 * j + c] -= f;
        job.viscousSum[6 * j + 3 + c] -= t;
      }
    }
  }
}

/// Adds pairs to the sums of a block's job.
template <bool Energies, int N>
struct PairAdder {
  const KernelUnits& units;
  const Weight& weight;
  const PairJob& job;
  PairTally& tally;

  NW_INLINE void operator()(const PairGroup<N>& group, PairResult<Lanes>& pair) {
    if constexpr (Energies) weight.apply(group.separation, pair);
    Row rows[laneCount];
    auto whole = [](LaneIntegers* to, const Vec3<Lanes>& v) {
      to[0] = nearestIntegers(v.x);
      to[1] = nearestIntegers(v.y);
      to[2] = nearestIntegers(v.z);
    };
    constexpr int components = N > 1 ? 6 : 3;
    LaneIntegers component[6];
    whole(component, pair.force);
    if constexpr (N > 1) whole(component + 3, pair.torqueI);
    toRows<components>(component, rows);
    addRows(job.sum, group.sumI, rows);
    for (int c = 0; c < 3; ++c) component[c] = -component[c];
    if constexpr (N > 1) whole(component + 3, pair.torqueJ);
    toRows<components>(component, rows);
    addRows(job.sum, group.sumJ, rows);
    if constexpr (Energies)
      for (int k = 0; k < group.used; ++k)
        if (group.i[k] >= job.begin && group.i[k] < job.end)
          tally.energy.add(units.force * pair.energy[static_cast<std::size_t>(k)],
                           tally.energyUnit);
    // A blended pair comes twice; its damping acts once.
    if (job.viscousSum && weight.kind != Weight::rising) addViscous(job, units, group);
  }
};

/// Adds the pairs of a block, N points on each axis; `weight` multiplies their energies.
template <bool Energies, int N, class Law>
void addBlock(const Law& shared, const KernelUnits& units, const Weight& weight,
              const PairBlock& block, const PairJob& job, PairTally& tally) {
  typename Law::Kernel law(shared);
  keepInMemory(law);
  PairAdder<Energies, N> add{units, weight, job, tally};
  for (int first = 0; first < block.count; first += laneCount) {
    const PairGroup<N> group(block, job, first);
    auto pair = resolvePair<Energies, N>(law, units, group.separation, group.ei, group.ej);
    add(group, pair);
  }
}

/// The same with the sums over points in single precision, two groups at a time. Distances of
/// centres and axes before, forces and torques after them are in doubles.
template <bool Energies, int N, class Law>
void addBlockSingle(const Law& shared, const KernelUnits& units, const Weight& weight,
                    const PairBlock& block, const PairJob& job, PairTally& tally) {
  typename Law::Kernel law(shared);
  keepInMemory(law);
  PairAdder<Energies, N> add{units, weight, job, tally};
  for (int first = 0; first < block.count; first += floatCount) {
    const int second = first + laneCount;
    const PairGroup<N> groups[2] = {{block, job, first},
                                    {block, job, second < block.count ? second : first}};
    auto shape = [&](const PairGroup<N>& g) {
      auto result = shapeOf(g.separation, g.ei, g.ej);
      result.center2 -= law.origin();
      return result;
    };
    const auto low = shape(groups[0]), high = shape(groups[1]);
    const PairShape<Floats> both{rounded(low.center2, high.center2),
                                 rounded(low.alongI, high.alongI), rounded(low.alongJ, high.alongJ),
                                 rounded(low.cosine, high.cosine)};
    const auto sums = sumPoints<Energies, N>(law, units.length, both);
    const int count = second < block.count ? 2 : 1;
#pragma GCC unroll 1
    for (int k = 0; k < count; ++k) {
      PointSums<Lanes> part{half(sums.f, k), half(sums.a, k), half(sums.b, k), half(sums.ab, k)};
      if constexpr (Energies) part.energy = half(sums.energy, k);
      const PairGroup<N>& group = groups[k];
      auto pair = assemble<N>(part, units, group.separation, group.ei, group.ej);
      add(group, pair);
    }
  }
}

}  // namespace nanoweft
