/// The pair sum, a SIMD lane per pair: n x n point pairs of a block, integer scatter.
#pragma once

#include <cmath>

#include "nanoweft/base/simd.hpp"
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
  decltype(V() < V()) touching{false};  ///< some points are within the cutoff
};

/// Distances of points and moments of their forces follow from the dot products of the separation
/// and the two axes, so that a point pair costs little more than its force.
template <bool Energies, int N, class Law, class V>
NW_INLINE PairResult<V> resolvePair(const Law& law, double length, const Vec3<V>& separation,
                                    const Vec3<V>& ei, const Vec3<V>& ej) {
  const V cutoff2(law.cutoff() * law.cutoff());
  const V alongI = dot(separation, ei), alongJ = dot(separation, ej), cosine = dot(ei, ej),
          center2 = dot(separation, separation);
  PairResult<V> result;
  // Sums of f, sa f, sb f and sa sb f over the points.
  V sum(0.0), sumA(0.0), sumB(0.0), sumAB(0.0), energy(0.0);
#pragma GCC unroll 3
  for (int a = 0; a < N; ++a) {
    const double sa = (a - 0.5 * (N - 1)) / N * length;
    // |separation - sa ei|^2 and twice its part along ej.
    const V from2 = multiplyAdd(V(-2.0 * sa), alongI, V(center2 + sa * sa));
    const V along = 2.0 * multiplyAdd(V(-sa), cosine, alongJ);
    V row(0.0), rowB(0.0);
#pragma GCC unroll 9
    for (int b = 0; b < N; ++b) {
      const double sb = (b - 0.5 * (N - 1)) / N * length;
      const V r2 = multiplyAdd(V(sb), along, V(from2 + sb * sb));
      const auto near = r2 < cutoff2;
      if (!anyOf(near)) continue;
      result.touching = result.touching || near;
      // Law values beyond the cutoff are zero, so no lane needs a mask.
      V f;
      if constexpr (Energies) {
        const PairValue<V> value = law(r2);
        f = value.slope;
        energy += value.energy;
      } else {
        f = law.slope(r2);
      }
      row += f;
      rowB = multiplyAdd(V(sb), f, rowB);
    }
    sum += row;
    sumB += rowB;
    sumA = multiplyAdd(V(sa), row, sumA);
    sumAB = multiplyAdd(V(sa), rowB, sumAB);
  }
  const V share(1.0 / (N * N));
  result.energy = share * energy;
  sum *= share;
  if constexpr (N > 1) {
    sumA *= share, sumB *= share, sumAB *= share;
    result.force = sum * separation - sumA * ei + sumB * ej;
    result.torqueI = cross(ei, sumA * separation + sumAB * ej);
    result.torqueJ = cross(ej, sumAB * ei - sumB * separation);
  } else {
    result.force = sum * separation;
    result.torqueI = result.torqueJ = {V(0.0), V(0.0), V(0.0)};
  }
  return result;
}

/// What the kernels of a law share: segment length and the units of the integer sums.
struct KernelUnits {
  double length, force, torque;
};

/// Viscous forces of a pair in reach (physics.md 5). Not inlined: seldom used, it would take
/// registers from the rest.
[[gnu::noinline]] inline void addViscous(const PairJob& job, const KernelUnits& units,
                                         std::int32_t i, std::int32_t j) {
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

/// Adds the pairs of a block, N points on each axis; `weight` multiplies their energies.
template <bool Energies, int N, class Law>
void addBlock(const Law& shared, const KernelUnits& units, const Weight& weight,
              const PairBlock& block, const PairJob& job, PairTally& tally) {
  const typename Law::Kernel law = shared;
  const Lanes perForce(1.0 / units.force), perTorque(1.0 / units.torque);
  ForceSum others{};
  const SumShare share{job.sum, job.begin, job.end, &others};
  for (int first = 0; first < block.count; first += laneCount) {
    const int used = std::min(laneCount, block.count - first);
    const std::int32_t *i = block.i + first, *j = block.j + first;
    const Vec3<Lanes> separation = block.separation(first);
    PairResult<Lanes> pair;
    if constexpr (N > 1)
      pair = resolvePair<Energies, N>(law, units.length, separation,
                                      axis1(gatherOrientations(job.pose, i)),
                                      axis1(gatherOrientations(job.pose, j)));
    else
      pair = resolvePair<Energies, N>(law, units.length, separation, {}, {});
    if (!anyOf(pair.touching)) continue;
    if constexpr (Energies) weight.apply(separation, pair);
    Row onI[laneCount], onJ[laneCount];
    auto whole = [](LaneIntegers* to, const Vec3<Lanes>& v, const Lanes& scale) {
      to[0] = nearestIntegers(v.x * scale);
      to[1] = nearestIntegers(v.y * scale);
      to[2] = nearestIntegers(v.z * scale);
    };
    constexpr int components = N > 1 ? 6 : 3;
    LaneIntegers component[6];
    whole(component, pair.force, perForce);
    if constexpr (N > 1) whole(component + 3, pair.torqueI, perTorque);
    toRows<components>(component, onI);
    for (int c = 0; c < 3; ++c) component[c] = -component[c];
    if constexpr (N > 1) whole(component + 3, pair.torqueJ, perTorque);
    toRows<components>(component, onJ);
    for (int k = used; k < laneCount; ++k) onI[k] = onJ[k] = Row{};
    scatter(share, i, j, onI, onJ);
    if constexpr (Energies)
      for (int k = 0; k < used; ++k)
        if (share.owns(i[k]))
          tally.energy.add(pair.energy[static_cast<std::size_t>(k)], tally.energyUnit);
    // A blended pair comes twice; its damping acts once.
    if (job.viscousSum && weight.kind != Weight::rising)
      for (int k = 0; k < used; ++k)
        if (pair.touching[static_cast<std::size_t>(k)]) addViscous(job, units, i[k], j[k]);
  }
}

}  // namespace nanoweft
