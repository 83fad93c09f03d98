/// Sorts pairs by centre distance at every step: drops those out of reach and packs the others into
/// blocks of one class, which the kernel resolves with all points (near), with fewer points (far),
/// or, between the two ranges, with both and weights (blended):
///
///     U = (1 - w) U_n + w U_m,   w = 0 below Switch::from, 1 beyond Switch::to, C2 between.
#pragma once

#include <cstdint>
#include <span>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/base/vec.hpp"
#include "nanoweft/force/lane_pairs.hpp"
#include "nanoweft/force/pair_runs.hpp"
#include "nanoweft/force/switch.hpp"
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

/// The weight of a pair's energy: 1 (whole), 1 - w (fading) or w (rising) of its centre distance.
struct Weight {
  enum Kind { whole, fading, rising } kind = whole;
  Switch blend;

  /// Multiplies energy and torques, and the force by the product rule.
  template <class Result, class V>
  NW_INLINE void apply(const Vec3<V>& separation, Result& pair) const {
    if (kind == whole) return;
    const V r = norm(separation);
    V s, ds;
    blend.factor(r, s, ds);
    if (kind == rising) s = 1.0 - s, ds = -ds;
    pair.force = s * pair.force + V(pair.energy * ds / r) * separation;
    pair.energy = s * pair.energy;
    pair.torqueI = s * pair.torqueI;
    pair.torqueJ = s * pair.torqueJ;
  }
};

class PairSift {
 public:
  enum Class { near, blended, far };

  /// `blend`: where fewer points take over; at infinity when they do not.
  PairSift(const double* pose, const MinimumImage& nearest, const Switch& blend, double reach);

  /// Sets the pairs to be sorted next. `next` must have returned null for those before.
  void goOn(std::span<const ListPair> pairs) { pairs_ = pairs; }
  /// The next block and its class, or null when more pairs are needed to fill one. With `last`,
  /// blocks that are not full are handed out too.
  PairBlock* next(Class& which, bool last);

 private:
  void sift();
  PairBlock* handOut(Class which, Class& result);

  const double* pose_;
  const MinimumImage& nearest_;
  double from2_, to2_, reach2_;
  std::span<const ListPair> pairs_;
  PairBlock* given_ = nullptr;  ///< the block handed out last, to be cleared by the next call
  PairBlock blocks_[3];
};

}  // namespace nanoweft
