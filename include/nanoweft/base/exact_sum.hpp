/// Sums whose bits do not depend on the order of their terms.
///
/// Terms are rounded once to a fixed grid and added as integers, so any split over threads and
/// ranks gives the same total.
#pragma once

#include <mpi.h>

#include <cmath>
#include <cstdint>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// The unit of exact sums: a power of two, so that scaling by it is exact.
struct SumUnit {
  double unit = 1.0, inverse = 1.0;

  SumUnit() = default;
  /// `scale`: the typical size of one term; the grid is about 1e-22 of it.
  explicit SumUnit(double scale)
      : unit(std::ldexp(1.0, std::ilogb(scale) - 33)), inverse(1.0 / unit) {}
  /// What terms are rounded to.
  double grid() const { return std::ldexp(unit, -40); }
};

/// Sum of doubles on the grid `unit` * 2^-40, held as two integers: terms below 2^50 units (1e5
/// times the scale), sums below 2^62.
///
/// A term that is not a number or too large for the grid poisons the sum: value() is then NaN.
class ExactSum {
 public:
  void add(double term, const SumUnit& unit) {
    const double t = term * unit.inverse;
    if (!(std::abs(t) < 0x1p50)) {
      poisoned_ = 1;
      return;
    }
    const double whole = std::nearbyint(t);
    high_ += static_cast<std::int64_t>(whole);
    low_ += static_cast<std::int64_t>(std::nearbyint((t - whole) * 0x1p40));
    carry();
  }

  /// Makes value() NaN from now on.
  void poison() { poisoned_ = 1; }

  /// Adds a term of each lane: what add() of each would, in fewer operations.
  void merge(const class ExactLanes& lanes);

  void merge(const ExactSum& other) {
    high_ += other.high_;
    low_ += other.low_;
    poisoned_ |= other.poisoned_;
    carry();
  }

  double value(const SumUnit& unit) const {
    if (poisoned_) return NAN;
    return (static_cast<double>(high_) + static_cast<double>(low_) * 0x1p-40) * unit.unit;
  }

  /// Sum over all ranks of `n` sums, in place.
  static void reduce(ExactSum* sums, int n, MPI_Comm comm) {
    static_assert(sizeof(ExactSum) == 3 * sizeof(std::int64_t));
    MPI_Allreduce(MPI_IN_PLACE, sums, 3 * n, MPI_INT64_T, MPI_SUM, comm);
    for (int i = 0; i < n; ++i) sums[i].carry();
  }

  /// The three integers, for checkpoints.
  std::int64_t* data() { return &high_; }
  const std::int64_t* data() const { return &high_; }

 private:
  void carry() {
    high_ += low_ >> 40;
    low_ &= (std::int64_t{1} << 40) - 1;
  }

  std::int64_t high_ = 0, low_ = 0, poisoned_ = 0;
};

/// Exact sums, one a lane. The grid of add() and its limits are those of ExactSum.
class ExactLanes {
 public:
  NW_INLINE void add(const Lanes& term, const SumUnit& unit) {
    // 1.5 * 2^52 added rounds to an integer; what is left of the term goes to the low part.
    const Lanes magic(0x1.8p52), t = term * unit.inverse;
    poisoned_ = poisoned_ || !(abs(t) < Lanes(0x1p50));
    const Lanes whole = (t + magic) - magic;
    high_ += nearestIntegers(whole);
    low_ += nearestIntegers((t - whole) * 0x1p40);
    high_ += low_ >> 40;
    low_ &= (std::int64_t{1} << 40) - 1;
  }

 private:
  friend class ExactSum;
  LaneIntegers high_{}, low_{};
  Lanes::mask_type poisoned_{false};
};

inline void ExactSum::merge(const ExactLanes& lanes) {
  for (int k = 0; k < laneCount; ++k) {
    high_ += lanes.high_[k];
    low_ += lanes.low_[k];
    carry();
  }
  poisoned_ |= anyOf(lanes.poisoned_);
}

}  // namespace nanoweft
