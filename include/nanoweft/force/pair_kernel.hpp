/// The pair sum, a SIMD lane per pair: gathers of pose records, n x n point pairs, integer scatter.
#pragma once

#include <cmath>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/vdw.hpp"

namespace nanoweft {

/// Energy, force on i (on j: the negative) and torques of one pair, averaged over the points.
template <class V>
struct PairResult {
  V energy{};
  Vec3<V> force, torqueI, torqueJ;
  decltype(V() < V()) touching{false};  ///< some points are within the cutoff
};

template <bool Energies, int N, class Law, class V>
NW_INLINE PairResult<V> resolvePair(const Law& law, double length, const Vec3<V>& separation,
                                    const Quat<V>& qi, const Quat<V>& qj) {
  const double spacing = length / N;
  const V cutoff2(law.cutoff() * law.cutoff());
  const Vec3<V> ei = axis1(qi), ej = axis1(qj);
  PairResult<V> result;
  Vec3<V> force{V(0.0), V(0.0), V(0.0)}, momentI = force, momentJ = force;
  V energy(0.0);
  for (int a = 0; a < N; ++a) {
    const V sa((a - 0.5 * (N - 1)) * spacing);
    const Vec3<V> from = separation - sa * ei;
    Vec3<V> row{V(0.0), V(0.0), V(0.0)};
    for (int b = 0; b < N; ++b) {
      const V sb((b - 0.5 * (N - 1)) * spacing);
      const Vec3<V> d = from + sb * ej;
      const V r2 = dot(d, d);
      const auto near = r2 < cutoff2;
      if (!anyOf(near)) continue;
      result.touching = result.touching || near;
      const PairValue<V> value = law(r2);
      // Law values beyond the cutoff are zero, so no lane needs a mask.
      const Vec3<V> f = value.slope * d;
      row += f;
      if constexpr (N > 1) momentJ += sb * f;
      if constexpr (Energies) energy += value.energy;
    }
    force += row;
    if constexpr (N > 1) momentI += sa * row;
  }
  const V share(1.0 / (N * N));
  result.energy = share * energy;
  result.force = share * force;
  if constexpr (N > 1) {
    result.torqueI = cross(ei, share * momentI);
    result.torqueJ = -cross(ej, share * momentJ);
  } else {
    result.torqueI = result.torqueJ = {V(0.0), V(0.0), V(0.0)};
  }
  return result;
}

/// Pose records of `laneCount` segments, transposed.
struct GatheredPose {
  Vec3<Lanes> position;
  Quat<Lanes> orientation;

  NW_INLINE GatheredPose(const double* pose, const std::int32_t* index) {
    alignas(64) double t[8][laneCount];
    for (int k = 0; k < laneCount; ++k) {
      const double* p = pose + 8 * static_cast<std::size_t>(index[k]);
      for (int c = 0; c < 8; ++c) t[c][k] = p[c];
    }
    auto load = [&](int c) { return Lanes(t[c], stdx::element_aligned); };
    position = {load(0), load(1), load(2)};
    orientation = {load(4), load(5), load(6), load(7)};
  }
};

template <bool Energies, int N, class Law>
void addPairs(const Law& law, double length, double reach, double forceUnit, double torqueUnit,
              const PairJob& job, PairTally& tally) {
  const Lanes reach2(reach * reach);
  const Lanes perForce(1.0 / forceUnit), perTorque(1.0 / torqueUnit);
  for (std::size_t first = 0; first < job.count; first += laneCount) {
    const int used = static_cast<int>(std::min<std::size_t>(laneCount, job.count - first));
    std::int32_t i[laneCount], j[laneCount];
    for (int k = 0; k < laneCount; ++k) {
      // A partial group repeats its last pair in lanes whose results are not used.
      const ListPair& pair = job.pairs[first + static_cast<std::size_t>(std::min(k, used - 1))];
      i[k] = pair.i;
      j[k] = pair.j;
    }
    const GatheredPose pi(job.pose, i), pj(job.pose, j);
    const Vec3<Lanes> separation = (*job.nearest)(pj.position - pi.position);
    if (!anyOf(dot(separation, separation) < reach2)) continue;
    const auto pair =
        resolvePair<Energies, N>(law, length, separation, pi.orientation, pj.orientation);
    if (!anyOf(pair.touching)) continue;
    alignas(64) double scaled[9][laneCount];
    auto store = [&](int row, const Vec3<Lanes>& v, const Lanes& scale) {
      (v.x * scale).copy_to(scaled[row], stdx::element_aligned);
      (v.y * scale).copy_to(scaled[row + 1], stdx::element_aligned);
      (v.z * scale).copy_to(scaled[row + 2], stdx::element_aligned);
    };
    store(0, pair.force, perForce);
    store(3, pair.torqueI, perTorque);
    store(6, pair.torqueJ, perTorque);
    tally.resolved += used;
    for (int k = 0; k < used; ++k) {
      const bool mineI = i[k] >= job.begin && i[k] < job.end;
      const bool mineJ = j[k] >= job.begin && j[k] < job.end;
      std::int64_t* si = job.sum + 6 * static_cast<std::size_t>(i[k]);
      std::int64_t* sj = job.sum + 6 * static_cast<std::size_t>(j[k]);
      for (int c = 0; c < 3; ++c) {
        const std::int64_t f = std::llrint(scaled[c][k]);
        if (mineI) {
          si[c] += f;
          si[3 + c] += std::llrint(scaled[3 + c][k]);
        }
        if (mineJ) {
          sj[c] -= f;
          sj[3 + c] += std::llrint(scaled[6 + c][k]);
        }
      }
      if constexpr (Energies)
        if (mineI) tally.energy.add(pair.energy[static_cast<std::size_t>(k)], tally.energyUnit);
      if (job.viscousSum && pair.touching[static_cast<std::size_t>(k)]) {
        const double* vi = job.velocity + 3 * static_cast<std::size_t>(i[k]);
        const double* vj = job.velocity + 3 * static_cast<std::size_t>(j[k]);
        const double* wi = job.angular + 3 * static_cast<std::size_t>(i[k]);
        const double* wj = job.angular + 3 * static_cast<std::size_t>(j[k]);
        for (int c = 0; c < 3; ++c) {
          const auto f = std::llrint(job.viscous.linear * (vj[c] - vi[c]) / forceUnit);
          const auto t = std::llrint(job.viscous.angular * (wj[c] - wi[c]) / torqueUnit);
          if (mineI) {
            job.viscousSum[6 * i[k] + c] += f;
            job.viscousSum[6 * i[k] + 3 + c] += t;
          }
          if (mineJ) {
            job.viscousSum[6 * j[k] + c] -= f;
            job.viscousSum[6 * j[k] + 3 + c] -= t;
          }
        }
      }
    }
  }
}

}  // namespace nanoweft
