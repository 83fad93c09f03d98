/// The records in which the pair kernel sums the forces on segments, as integers.
#pragma once

#include <cstdint>
#include <cstring>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// Force and torque on a segment in units of the pair law, and two zeros: a cache line.
struct alignas(64) ForceSum {
  std::int64_t at[8];
};

/// Some of the six sums' highest two bits, in the sign: negative where one is beyond a quarter of
/// the integers' range. From there to three quarters, which would come out with the wrong sign,
/// that is seen.
NW_INLINE std::int64_t atEdge(const std::int64_t* sums) {
  std::int64_t edge = 0;
  for (int c = 0; c < 6; ++c) edge |= sums[c] ^ (sums[c] << 1);
  return edge;
}

/// Adds the row of each lane to the record that `place` names for it; lanes may name the same one.
NW_INLINE void addRows(ForceSum* sum, const std::int32_t* place, const Row* rows) {
#pragma GCC unroll 8
  for (int k = 0; k < laneCount; ++k) {
    ForceSum* const record = sum + place[k];
    Row r;
    std::memcpy(&r, record, sizeof r);
    r += rows[k];
    std::memcpy(record, &r, sizeof r);
  }
}

}  // namespace nanoweft
