#include "nanoweft/force/pair_sift.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "nanoweft/force/gather.hpp"

namespace nanoweft {

namespace {

/// Second segments lie anywhere: what will be read and written of them is fetched in time.
NW_INLINE void fetchAhead(const PairJob& job, std::span<const ListPair> pairs) {
  constexpr std::size_t ahead = 64;
  if (ahead + laneCount > pairs.size()) return;
  for (std::size_t k = 0; k < laneCount; ++k) {
    const auto partner = static_cast<std::size_t>(pairs[ahead + k].j);
    __builtin_prefetch(job.pose + 8 * partner);
    __builtin_prefetch(job.sum + partner, 1);  // even if that of a ghost is not there
  }
}

NW_INLINE Vec3<Lanes> separationOf(const PairJob& job, const std::int32_t* i,
                                   const std::int32_t* j) {
  return (*job.nearest)(gatherPositions(job.pose, j) - gatherPositions(job.pose, i));
}

/// The segments of a SIMD group of pairs; lanes beyond the last pair repeat it.
NW_INLINE void segmentsOf(std::span<const ListPair> pairs, std::int32_t* i, std::int32_t* j) {
  static_assert(sizeof(ListPair) == sizeof(std::int64_t));
  if (pairs.size() >= laneCount) return splitWords(pairs.data(), i, j);
  for (std::size_t k = 0; k < laneCount; ++k) {
    const ListPair& p = pairs[std::min(k, pairs.size() - 1)];
    i[k] = p.i;
    j[k] = p.j;
  }
}

}  // namespace

void PairBlock::close(const PairJob& job) {
  for (int n = count; n % laneCount; ++n) {
    i[n] = i[n - 1];
    j[n] = j[n - 1];
    x[n] = x[n - 1];
    y[n] = y[n - 1];
    z[n] = z[n - 1];
  }
  const LaneNumbers spare = LaneNumbers{} + job.spare;
  auto place = [&](const std::int32_t* segments, std::int32_t* sums) {
    for (int k = 0; k < count; k += laneCount) {
      const LaneNumbers s = loadNumbers(segments + k);
      const LaneNumbers places = (s >= job.begin) & (s < job.end) ? s : spare;
      std::memcpy(sums + k, &places, sizeof places);
    }
    for (int n = count; n % laneCount; ++n) sums[n] = job.spare;
  };
  place(i, sumI);
  place(j, sumJ);
}

void takeAll(const PairJob& job, std::span<const ListPair> pairs, PairBlock& block) {
  block.count = static_cast<int>(std::min<std::size_t>(PairBlock::capacity, pairs.size()));
  for (int k = 0; k < block.count; k += laneCount) {
    const auto rest = pairs.subspan(static_cast<std::size_t>(k));
    fetchAhead(job, rest);
    segmentsOf(rest, block.i + k, block.j + k);
    const Vec3<Lanes> d = separationOf(job, block.i + k, block.j + k);
    d.x.copy_to(block.x + k, stdx::element_aligned);
    d.y.copy_to(block.y + k, stdx::element_aligned);
    d.z.copy_to(block.z + k, stdx::element_aligned);
  }
  block.close(job);
}

PairSift::PairSift(const PairJob& job, const Switch& blend, double reach)
    : job_(job),
      from2_(blend.from * blend.from),
      to2_(blend.to * blend.to),
      reach2_(reach * reach),
      blends_(std::isfinite(blend.to)) {
  if (!job.draws) return;
  // Of the core all have to be near until the next drawing; out of reach they would do no harm.
  const double core = std::min(reach, blend.from - (job.drawnRange - reach));
  core2_ = core > 0 ? core * core : 0.0;
  drawn2_ = job.drawnRange * job.drawnRange;
}

void PairSift::goOn(std::span<const ListPair> pairs) {
  pairs_ = pairs;
  if (!job_.draws) return;
  // Whole vectors are written, of which a part counts.
  auto makeRoom = [&](std::vector<ListPair>& to, std::size_t used) {
    if (const std::size_t needed = used + pairs.size() + laneCount; to.size() < needed)
      to.resize(needed);
  };
  makeRoom(job_.drawn->core, drawn_.core);
  makeRoom(job_.drawn->rim, drawn_.rim);
}

void PairSift::sift() {
  const std::size_t used = std::min<std::size_t>(laneCount, pairs_.size());
  alignas(64) std::int32_t i[laneCount], j[laneCount];
  fetchAhead(job_, pairs_);
  segmentsOf(pairs_, i, j);
  const Vec3<Lanes> d = separationOf(job_, i, j);
  const Lanes r2 = dot(d, d);
  const unsigned valid = (1u << used) - 1;
  if (job_.draws) {
    static_assert(sizeof(ListPair) == sizeof(double));
    alignas(64) double words[laneCount], packed[laneCount];
    std::memcpy(words, pairs_.data(), used * sizeof(double));
    const Lanes all(words, stdx::vector_aligned);
    auto draw = [&](unsigned chosen, std::vector<ListPair>& to, std::size_t& end) {
      packLanes(chosen, all, packed);
      std::memcpy(static_cast<void*>(&to[end]), packed, sizeof packed);
      end += static_cast<std::size_t>(std::popcount(chosen));
    };
    const unsigned core = lanesBelow(r2, core2_) & valid;
    draw(core, job_.drawn->core, drawn_.core);
    draw(lanesBelow(r2, drawn2_) & valid & ~core, job_.drawn->rim, drawn_.rim);
  }
  pairs_ = pairs_.subspan(used);
  const unsigned inNear = lanesBelow(r2, from2_) & valid, inBlend = lanesBelow(r2, to2_) & valid,
                 inReach = lanesBelow(r2, reach2_) & valid;
  if (!inReach) return;
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
  b.close(job_);
  given_ = &b;
  result = which;
  return &b;
}

const PairBlock* PairSift::next(Class& which, bool last) {
  if (given_) given_->count = 0;
  given_ = nullptr;
  while (!pairs_.empty()) {
    for (Class c : {near, blended, far})
      if (blocks_[c].count > PairBlock::capacity - 2 * laneCount) return handOut(c, which);
    sift();
  }
  if (!last) return nullptr;
  for (Class c : {near, blended, far})
    if (blocks_[c].count > 0) return handOut(c, which);
  return nullptr;
}

}  // namespace nanoweft
