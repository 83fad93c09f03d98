/// Sums of pair forces, a record of integers a segment, and how a SIMD group of pairs is added to
/// them.
#pragma once

#include <cstdint>
#include <cstring>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// Force and torque on a segment in units of the pair law, and two zeros: a cache line.
struct alignas(64) ForceSum {
  std::int64_t at[8];
};

/// Which segments' sums a thread keeps; where those of others go, nobody looks.
struct SumShare {
  ForceSum* sum;
  std::int32_t begin, end;
  ForceSum* others;

  bool owns(std::int32_t k) const { return k >= begin && k < end; }
  NW_INLINE ForceSum* place(std::int32_t k) const { return owns(k) ? sum + k : others; }
};

namespace detail {

inline constexpr ForceSum zeroSum{};

NW_INLINE Row loadSum(const ForceSum* p) {
  Row r;
  std::memcpy(&r, p, sizeof r);
  return r;
}
NW_INLINE void storeSum(ForceSum* p, const Row& r) {
  std::memcpy(p, &r, sizeof r);
}

}  // namespace detail

/// Adds a group of pairs to the records of their segments. Consecutive pairs share their first
/// segment, whose record is kept in a register: it would wait for its last store. Without a branch,
/// since where the first segment changes cannot be foreseen.
NW_INLINE void scatter(const SumShare& share, const std::int32_t* i, const std::int32_t* j,
                       const Row* onI, const Row* onJ) {
  using namespace detail;
  Row kept{};
  std::int32_t last = -1;
#pragma GCC unroll 8
  for (int k = 0; k < laneCount; ++k) {
    const std::int64_t same = -static_cast<std::int64_t>(i[k] == last);
    last = i[k];
    ForceSum* const si = share.place(i[k]);
    const auto own = reinterpret_cast<std::intptr_t>(si),
               zero = reinterpret_cast<std::intptr_t>(&zeroSum);
    const Row before = loadSum(reinterpret_cast<const ForceSum*>(own ^ ((own ^ zero) & same)));
    kept = (kept & (Row{} + same)) + before + onI[k];
    storeSum(si, kept);
    ForceSum* const sj = share.place(j[k]);
    storeSum(sj, loadSum(sj) + onJ[k]);
  }
}

}  // namespace nanoweft
