#include "nanoweft/force/pair_sift.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "nanoweft/force/gather.hpp"

namespace nanoweft {

namespace {

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

void PairBlock::put(unsigned chosen, const std::int32_t* i, const std::int32_t* j) {
  packLanes(chosen, i, i_ + count_);
  packLanes(chosen, j, j_ + count_);
  count_ += std::popcount(chosen);
}

LaneView PairBlock::close() {
  const int groups = (count_ + laneCount - 1) / laneCount;
  for (int n = count_; n < groups * laneCount; ++n) {
    i_[n] = i_[n - 1];
    j_[n] = j_[n - 1];
  }
  for (int n = 0; n < groups * laneCount; ++n) {
    groups_[n / laneCount].first[n % laneCount] = i_[n];
    groups_[n / laneCount].count[n % laneCount] = n < count_;
  }
  return {{groups_, static_cast<std::size_t>(groups)}, j_, j_ + groups * laneCount};
}

PairSift::PairSift(const double* pose, const MinimumImage& nearest, double reach)
    : pose_(pose), nearest_(nearest), reach2_(reach * reach) {}

void PairSift::sift() {
  const std::size_t used = std::min<std::size_t>(laneCount, pairs_.size());
  alignas(64) std::int32_t i[laneCount], j[laneCount];
  constexpr std::size_t ahead = 32;
  if (ahead + laneCount <= pairs_.size())
    for (std::size_t k = 0; k < laneCount; ++k) {
      const ListPair& p = pairs_[ahead + k];
      __builtin_prefetch(pose_ + 8 * static_cast<std::size_t>(p.i));
      __builtin_prefetch(pose_ + 8 * static_cast<std::size_t>(p.j));
    }
  segmentsOf(pairs_, i, j);
  pairs_ = pairs_.subspan(used);
  const Vec3<Lanes> d = nearest_(gatherPositions(pose_, j) - gatherPositions(pose_, i));
  block_.put(lanesBelow(dot(d, d), reach2_) & ((1u << used) - 1), i, j);
}

PairBlock* PairSift::next(bool last) {
  if (std::exchange(given_, false)) block_.clear();
  while (!pairs_.empty() && block_.count() <= PairBlock::capacity - 2 * laneCount) sift();
  given_ = block_.count() > (last ? 0 : PairBlock::capacity - 2 * laneCount);
  return given_ ? &block_ : nullptr;
}

}  // namespace nanoweft
