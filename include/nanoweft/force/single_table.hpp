/// A pair law's table for single precision: so few pieces that they are looked up in registers
/// instead of memory, which is most of a point pair's work in doubles.
///
/// Squared distances are counted from that of the inner join, `origin`: forces are steepest there,
/// so rounding has to be least.
///
/// Tabulated are f(s) = u'(r)/r, s = r^2, and the energy, both by polynomials of degree seven in
/// quarters of octaves of a scaled distance y: [1/2, 1) below the inner join, [1, 32) up to the
/// switch, [32, 64) within it. From 0.6 of the inner join on, round-off is most of their error;
/// below half of it, where fibres have passed through each other, they are rough.
#pragma once

#include <memory>

#include "nanoweft/base/floats.hpp"
#include "nanoweft/force/pair_table.hpp"

namespace nanoweft {

class SingleRows {
 public:
  double origin() const { return origin_; }
  float cutoff2() const { return cutoff2_; }

  template <class V>
  NW_INLINE V slope(const V& s) const {
    V t;
    const auto place = placeOf(s, t);
    return value(columns_->slope, place, t);
  }
  template <class V>
  NW_INLINE PairValue<V> operator()(const V& s) const {
    V t;
    const auto place = placeOf(s, t);
    return {value(columns_->energy, place, t), value(columns_->slope, place, t)};
  }

 protected:
  static constexpr int bits = 2, terms = 8;
  static constexpr float first = 0.5f, outer = 32.0f, last = 64.0f;

  struct Columns {
    ShortColumn slope[terms], energy[terms];
  };

  /// y = scale s + shift from s = begin on.
  struct Zone {
    float begin, scale, shift;
  };

  template <class V>
  NW_INLINE auto placeOf(const V& s, V& t) const {
    auto line = [&](const Zone& z) { return multiplyAdd(s, V(z.scale), V(z.shift)); };
    const V near = select(s < V(zones_[1].begin), line(zones_[0]), line(zones_[1]));
    // What is not a number finds the last part.
    const V y = smaller(select(s < V(zones_[2].begin), near, line(zones_[2])), V(last));
    return octavePart<bits>(y, t);
  }

  template <class Place, class V>
  NW_INLINE static V value(const ShortColumn* c, const Place& place, const V& t) {
    V sum = c[terms - 1][place];
#pragma GCC unroll 8
    for (int k = terms - 2; k >= 0; --k) sum = multiplyAdd(sum, t, V(c[k][place]));
    return sum;
  }

  double origin_;
  float cutoff2_;  ///< the smallest squared distance of the last part, which is zero
  Zone zones_[3];
  const Columns* columns_;
};

class SingleTable : public SingleRows {
 public:
  using Kernel = SingleRows;
  explicit SingleTable(const PairTable& table);

 private:
  std::shared_ptr<const Columns> memory_;
};

}  // namespace nanoweft
