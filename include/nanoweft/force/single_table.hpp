/// A pair law's table in single precision. It has so few pieces that the kernel keeps them in
/// registers; in double precision, most of a point pair's work is to load rows from memory.
///
/// Squared distances are counted from that of the inner join, `origin`: forces are steepest there,
/// so distances near it must be rounded least.
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

struct SingleColumns {
  static constexpr int terms = 8;
  ShortColumn slope[terms], energy[terms];
};

/// A table to be evaluated, with constants of the type V (as in PairRows).
template <class V>
class SingleRows {
 public:
  static constexpr bool couples = false;  ///< couples would need too many registers

  double origin() const { return origin_; }
  float cutoff2() const { return cutoff2_; }

  SingleRows() = default;
  template <class W>
  explicit SingleRows(const SingleRows<W>& other)
      : origin_(other.origin_), cutoff2_(other.cutoff2_), columns_(other.columns_) {
    for (int z = 0; z < 3; ++z)
      zones_[z] = {V(other.zones_[z].begin), V(other.zones_[z].scale), V(other.zones_[z].shift)};
  }

  NW_INLINE V slope(const V& s) const {
    V t;
    const auto place = placeOf(s, t);
    return value(columns_->slope, place, t);
  }
  NW_INLINE PairValue<V> operator()(const V& s) const {
    V t;
    const auto place = placeOf(s, t);
    return {value(columns_->energy, place, t), value(columns_->slope, place, t)};
  }

 protected:
  template <class W>
  friend class SingleRows;

  static constexpr int bits = 2, terms = SingleColumns::terms;
  static constexpr float first = 0.5f, outer = 32.0f, last = 64.0f;

  /// y = scale s + shift from s = begin on.
  struct Zone {
    V begin, scale, shift;
  };

  NW_INLINE auto placeOf(const V& s, V& t) const {
    auto line = [&](const Zone& z) { return multiplyAdd(s, z.scale, z.shift); };
    const V near = select(s < zones_[1].begin, line(zones_[0]), line(zones_[1]));
    // A NaN gets the last part.
    const V y = smaller(select(s < zones_[2].begin, near, line(zones_[2])), V(last));
    return octavePart<bits>(y, t);
  }

  template <class Place>
  NW_INLINE static V value(const ShortColumn* c, const Place& place, const V& t) {
    V sum = c[terms - 1][place];
#pragma GCC unroll 8
    for (int k = terms - 2; k >= 0; --k) sum = multiplyAdd(sum, t, V(c[k][place]));
    return sum;
  }

  double origin_;
  float cutoff2_;  ///< the smallest squared distance of the last part, which is zero
  Zone zones_[3];
  const SingleColumns* columns_;
};

class SingleTable : public SingleRows<float> {
 public:
  using Kernel = SingleRows<Floats>;
  explicit SingleTable(const PairTable& table);

 private:
  std::shared_ptr<const SingleColumns> memory_;
};

}  // namespace nanoweft
