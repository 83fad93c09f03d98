/// Sifts the pairs of the rim at every step: drops those out of reach and packs the others into
/// blocks, which the kernel resolves.
#pragma once

#include <cstdint>
#include <span>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/force/lane_pairs.hpp"
#include "nanoweft/force/pair_runs.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

/// A block of packed pairs as the kernel takes them: in each lane a first segment with one partner.
class PairBlock {
 public:
  static constexpr int capacity = 128;

  int count() const { return count_; }
  void clear() { count_ = 0; }
  /// Appends the pairs of the chosen lanes. There must be room for `laneCount` pairs.
  void put(unsigned chosen, const std::int32_t* i, const std::int32_t* j);
  /// Pads the last group with repetitions of its last pair, which the kernel leaves out.
  LaneView close();

 private:
  int count_ = 0;
  LaneGroup groups_[capacity / laneCount];
  alignas(64) std::int32_t i_[capacity], j_[capacity];
};

class PairSift {
 public:
  PairSift(const double* pose, const MinimumImage& nearest, double reach);

  /// Sets the pairs to be sifted next. `next` must have returned null for those before.
  void goOn(std::span<const ListPair> pairs) { pairs_ = pairs; }
  /// The next block, or null when more pairs are needed to fill one. With `last`, a block that is
  /// not full is handed out too.
  PairBlock* next(bool last);

 private:
  void sift();

  const double* pose_;
  const MinimumImage& nearest_;
  double reach2_;
  std::span<const ListPair> pairs_;
  bool given_ = false;  ///< the block has been handed out, to be cleared by the next call
  PairBlock block_;
};

}  // namespace nanoweft
