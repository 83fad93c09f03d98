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

typedef std::int64_t SumRecord __attribute__((vector_size(64)));

/// Three or six components, a pair a lane, to a record a pair; the last two are zero.
template <int components>
NW_INLINE void toRecords(const LaneIntegers* component, SumRecord* record) {
  static_assert(components == 3 || components == 6);
  if constexpr (laneCount == 8) {
    // Couples of components of the even and the odd lanes, then the quarters to their lanes.
    auto even = [](SumRecord a, SumRecord b) {
      return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    };
    auto odd = [](SumRecord a, SumRecord b) {
      return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    };
    auto lanes = [record](int first, SumRecord a, SumRecord b, SumRecord c) {
      const SumRecord zero{};
      auto halves = [](SumRecord x, SumRecord y, auto low) {
        if constexpr (low)
          return __builtin_shufflevector(x, y, 0, 1, 2, 3, 8, 9, 10, 11);
        else
          return __builtin_shufflevector(x, y, 4, 5, 6, 7, 12, 13, 14, 15);
      };
      auto quarters = [](SumRecord x, SumRecord y, auto low) {
        if constexpr (low)
          return __builtin_shufflevector(x, y, 0, 1, 4, 5, 8, 9, 12, 13);
        else
          return __builtin_shufflevector(x, y, 2, 3, 6, 7, 10, 11, 14, 15);
      };
      const std::true_type low;
      const std::false_type high;
      const SumRecord ab = halves(a, b, low), c0 = halves(c, zero, low);
      record[first] = quarters(ab, c0, low);
      record[first + 2] = quarters(ab, c0, high);
      const SumRecord AB = halves(a, b, high), C0 = halves(c, zero, high);
      record[first + 4] = quarters(AB, C0, low);
      record[first + 6] = quarters(AB, C0, high);
    };
    const SumRecord zero{};
    auto at = [&](int k) {
      if constexpr (components == 6) return component[k];
      return k < 3 ? component[k] : zero;
    };
    lanes(0, even(at(0), at(1)), even(at(2), at(3)), even(at(4), at(5)));
    lanes(1, odd(at(0), at(1)), odd(at(2), at(3)), odd(at(4), at(5)));
  } else {
    for (int k = 0; k < laneCount; ++k) {
      SumRecord r{};
      for (int c = 0; c < components; ++c) r[c] = component[c][k];
      record[k] = r;
    }
  }
}

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

NW_INLINE SumRecord loadSum(const ForceSum* p) {
  SumRecord r;
  std::memcpy(&r, p, sizeof r);
  return r;
}
NW_INLINE void storeSum(ForceSum* p, const SumRecord& r) {
  std::memcpy(p, &r, sizeof r);
}

}  // namespace detail

/// Adds a group of pairs to the records of their segments. Consecutive pairs share their first
/// segment, whose record is kept in a register: it would wait for its last store. Without a branch,
/// since where the first segment changes cannot be foreseen.
NW_INLINE void scatter(const SumShare& share, const std::int32_t* i, const std::int32_t* j,
                       const SumRecord* onI, const SumRecord* onJ) {
  using namespace detail;
  SumRecord kept{};
  std::int32_t last = -1;
#pragma GCC unroll 8
  for (int k = 0; k < laneCount; ++k) {
    const std::int64_t same = -static_cast<std::int64_t>(i[k] == last);
    last = i[k];
    ForceSum* const si = share.place(i[k]);
    const auto own = reinterpret_cast<std::intptr_t>(si),
               zero = reinterpret_cast<std::intptr_t>(&zeroSum);
    const SumRecord before =
        loadSum(reinterpret_cast<const ForceSum*>(own ^ ((own ^ zero) & same)));
    kept = (kept & (SumRecord{} + same)) + before + onI[k];
    storeSum(si, kept);
    ForceSum* const sj = share.place(j[k]);
    storeSum(sj, loadSum(sj) + onJ[k]);
  }
}

}  // namespace nanoweft
