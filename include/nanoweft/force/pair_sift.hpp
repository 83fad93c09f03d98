/// Pairs sifted by the distance of their centres: those in reach, packed into blocks that are
/// resolved with all points (near), with fewer points (far), or with both, weighted, where one
/// gives way to the other:
///
///     U = (1 - w) U_n + w U_m,   w = 0 below Blend::from, 1 beyond Blend::to, C2 between.
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

/// Packed pairs: as lanes, first segments with one partner each.
class PairBlock {
 public:
  static constexpr int capacity = 128;

  int count() const { return count_; }
  void clear() { count_ = 0; }
  /// Takes in the chosen lanes; there has to be room for a whole group.
  void put(unsigned chosen, const std::int32_t* i, const std::int32_t* j);
  /// Fills up the last group with repetitions of a pair that do not count.
  LaneView close();

 private:
  int count_ = 0;
  LaneGroup groups_[capacity / laneCount];
  alignas(64) std::int32_t i_[capacity], j_[capacity];
};

/// What a pair's energy is multiplied with: nothing, 1 - w or w of its centre distance.
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

  /// The pairs to go on with; those before have to be used up.
  void goOn(std::span<const ListPair> pairs) { pairs_ = pairs; }
  /// The next block and its class, or nothing. Pairs are held back until they fill a block or are
  /// the `last` ones.
  PairBlock* next(Class& which, bool last);

 private:
  void sift();
  PairBlock* handOut(Class which, Class& result);

  const double* pose_;
  const MinimumImage& nearest_;
  double from2_, to2_, reach2_;
  std::span<const ListPair> pairs_;
  PairBlock* given_ = nullptr;  ///< handed out last
  PairBlock blocks_[3];
};

}  // namespace nanoweft
