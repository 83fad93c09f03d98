/// Listed pairs, sifted by the distance of their centres: those in reach, packed into blocks that
/// are resolved with all points (near), with fewer points (far), or with both, weighted, where one
/// gives way to the other:
///
///     U = (1 - w) U_n + w U_m,   w = 0 below Blend::from, 1 beyond Blend::to, C2 between.
///
/// On the way pairs can be drawn, for the steps to come.
#pragma once

#include <cstdint>

#include "nanoweft/base/simd.hpp"
#include "nanoweft/base/vec.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/switch.hpp"

namespace nanoweft {

/// Packed pairs and their separations x_j - x_i.
struct PairBlock {
  static constexpr int capacity = 128;

  int count = 0;
  alignas(64) std::int32_t i[capacity], j[capacity];
  /// Where their sums are kept: those of other threads and ranks in the job's spare record.
  alignas(64) std::int32_t sumI[capacity], sumJ[capacity];
  alignas(64) double x[capacity], y[capacity], z[capacity];

  NW_INLINE Vec3<Lanes> separation(int first) const {
    auto load = [&](const double* from) { return Lanes(from + first, stdx::element_aligned); };
    return {load(x), load(y), load(z)};
  }
  /// To be called when all pairs are in: fills up the last SIMD group with repetitions of a pair,
  /// which go to the spare record.
  void close(const PairJob& job);
};

/// Pairs as they are, as many as a block holds.
void takeAll(const PairJob& job, std::span<const ListPair> pairs, PairBlock& block);

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
  PairSift(const PairJob& job, const Switch& blend, double reach);

  /// The pairs to go on with; those before have to be used up.
  void goOn(std::span<const ListPair> pairs);
  /// Where the drawn pairs end by now.
  const DrawnPairs::Ends& drawn() const { return drawn_; }
  /// The next block and its class, filled up, or nothing. Pairs are held back until they fill a
  /// block or are the `last` ones.
  const PairBlock* next(Class& which, bool last);

 private:
  void sift();
  const PairBlock* handOut(Class which, Class& result);

  const PairJob& job_;
  double from2_, to2_, reach2_;
  double core2_ = 0, drawn2_ = 0;  ///< squared ranges of the drawn pairs
  bool blends_;
  std::span<const ListPair> pairs_;
  DrawnPairs::Ends drawn_{0, 0};
  PairBlock* given_ = nullptr;  ///< handed out last
  PairBlock blocks_[3];
};

}  // namespace nanoweft
