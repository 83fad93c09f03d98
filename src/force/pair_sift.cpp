#include "nanoweft/force/pair_sift.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "nanoweft/force/gather.hpp"

namespace nanoweft {

PairSift::PairSift(const PairJob& job, const Switch& blend, double reach)
    : job_(job),
      from2_(blend.from * blend.from),
      to2_(blend.to * blend.to),
      reach2_(reach * reach),
      blends_(std::isfinite(blend.to)) {
  if (job_.kept) job_.kept->clear();
}

void PairSift::keep(unsigned chosen, std::size_t first) {
  static_assert(sizeof(ListPair) == sizeof(double));
  alignas(64) double pairs[laneCount] = {}, packed[laneCount];
  std::memcpy(pairs, job_.pairs + first,
              std::min<std::size_t>(laneCount, job_.count - first) * sizeof(double));
  packLanes(chosen, Lanes(pairs, stdx::element_aligned), packed);
  ListPair some[laneCount];
  std::memcpy(static_cast<void*>(some), packed, sizeof some);
  job_.kept->insert(job_.kept->end(), some, some + std::popcount(chosen));
}

void PairSift::sift(std::size_t first) {
  const std::size_t used = std::min<std::size_t>(laneCount, job_.count - first);
  alignas(64) std::int32_t i[laneCount], j[laneCount];
  // Second segments lie anywhere: what will be read and written of them is fetched in time.
  if (constexpr std::size_t ahead = 64; first + ahead + laneCount <= job_.count)
    for (std::size_t k = 0; k < laneCount; ++k) {
      const auto partner = static_cast<std::size_t>(job_.pairs[first + ahead + k].j);
      __builtin_prefetch(job_.pose + 8 * partner);
      __builtin_prefetch(job_.sum + partner, 1);
    }
  if (used == laneCount) {
    for (std::size_t k = 0; k < laneCount; ++k) {
      i[k] = job_.pairs[first + k].i;
      j[k] = job_.pairs[first + k].j;
    }
  } else {
    for (std::size_t k = 0; k < laneCount; ++k) {
      i[k] = job_.pairs[first + std::min(k, used - 1)].i;
      j[k] = job_.pairs[first + std::min(k, used - 1)].j;
    }
  }
  const Vec3<Lanes> d =
      (*job_.nearest)(gatherPositions(job_.pose, j) - gatherPositions(job_.pose, i));
  const Lanes r2 = dot(d, d);
  const unsigned valid = (1u << used) - 1;
  if (job_.kept) keep(lanesBelow(r2, job_.keepRange * job_.keepRange) & valid, first);
  const unsigned inNear = lanesBelow(r2, from2_) & valid, inBlend = lanesBelow(r2, to2_) & valid,
                 inReach = lanesBelow(r2, reach2_) & valid;
  auto pack = [&](Class which, unsigned chosen) {
    PairBlock& b = blocks_[which];
    packLanes(chosen, i, b.i + b.count);
    packLanes(chosen, j, b.j + b.count);
    packLanes(chosen, d.x, b.x + b.count);
    packLanes(chosen, d.y, b.y + b.count);
    packLanes(chosen, d.z, b.z + b.count);
    b.count += std::popcount(chosen);
  };
  pack(near, inReach & inNear);
  if (!blends_) return;
  pack(blended, inReach & inBlend & ~inNear);
  pack(far, inReach & ~inBlend);
}

const PairBlock* PairSift::handOut(Class which, Class& result) {
  PairBlock& b = blocks_[which];
  for (int n = b.count; n % laneCount; ++n) {
    b.i[n] = b.i[n - 1];
    b.j[n] = b.j[n - 1];
    b.x[n] = b.x[n - 1];
    b.y[n] = b.y[n - 1];
    b.z[n] = b.z[n - 1];
  }
  given_ = which;
  result = which;
  return &b;
}

const PairBlock* PairSift::next(Class& which) {
  blocks_[given_].count = 0;
  for (; place_ < job_.count; place_ += laneCount) {
    for (Class c : {near, blended, far})
      if (blocks_[c].count > PairBlock::capacity - 2 * laneCount) return handOut(c, which);
    sift(place_);
  }
  for (Class c : {near, blended, far})
    if (blocks_[c].count > 0) return handOut(c, which);
  return nullptr;
}

}  // namespace nanoweft
