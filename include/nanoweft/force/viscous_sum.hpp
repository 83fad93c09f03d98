/// The sums of what viscous damping and friction do to segments, as integers.
#pragma once

#include <cmath>
#include <cstdint>

#include "nanoweft/force/pair_force.hpp"

namespace nanoweft {

/// A force in units of its sum. One that is beyond the range of sums, or no number, is left out and
/// noted.
inline std::int64_t wholeUnits(double force, double unit, PairTally& tally) {
  const double units = force / unit;
  if (std::abs(units) < 0x1p62) return std::llrint(units);
  tally.beyondSums = true;
  return 0;
}

/// Viscous damping of two segments that interact (model.md 5), on those that are the thread's.
inline void addDamping(const PairJob& job, std::int32_t i, std::int32_t j, PairTally& tally) {
  for (int c = 0; c < 3; ++c) {
    const auto f =
        wholeUnits(job.viscous.linear * (job.velocity[3 * j + c] - job.velocity[3 * i + c]),
                   job.viscousUnits.force, tally);
    const auto t =
        wholeUnits(job.viscous.angular * (job.angular[3 * j + c] - job.angular[3 * i + c]),
                   job.viscousUnits.torque, tally);
    if (job.mine(i)) {
      job.viscousSum[6 * i + c] += f;
      job.viscousSum[6 * i + 3 + c] += t;
    }
    if (job.mine(j)) {
      job.viscousSum[6 * j + c] -= f;
      job.viscousSum[6 * j + 3 + c] -= t;
    }
  }
}

}  // namespace nanoweft
