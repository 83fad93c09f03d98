/// A pair law as a table of polynomials in the squared distance: no root, no division, no power and
/// no branch is left for the pair kernel, whatever the law.
///
/// The quantity tabulated is f(s) = u'(r)/r with s = r^2, by polynomials of degree five in equal
/// parts of octaves; the energy is their integral, u(s) = -1/2 int_s f, so that energy and force
/// agree to round-off. Where the law joins its branches, the table has a node. Against the law
/// itself both are within 1e-12 from half the inner join on, and 1e-10 from 0.3 of it; below a
/// tenth, where fibres have passed through each other, the force is rounded off to stay finite.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// Energy of a point pair and u'(r)/r, from which the force follows.
template <class V>
struct PairValue {
  V energy, slope;
};

class PairTable {
 public:
  /// Distances where the law is not smooth: the inner join, the begin of the switch, the end.
  struct Joins {
    double inner, outer, cutoff;
  };
  /// `slope`: u'(r)/r between the joins, taken one-sidedly at them.
  PairTable(const Joins& joins, const std::function<double(double r)>& slope);

  double cutoff() const { return joins_.cutoff; }

  /// u'(r)/r at s = r^2; zero beyond the cutoff.
  template <class V>
  NW_INLINE V slope(const V& s) const {
    V t;
    return polynomial(row<force>(s, t), t);
  }

  template <class V>
  NW_INLINE PairValue<V> operator()(const V& s) const {
    V t;
    const auto c = row<all>(s, t);
    // The integral of the force's polynomial from the row's begin; the row ends with the energy
    // there and the length of ds over dt, halved.
    V integral = (1.0 / 6.0) * c[5];
    for (int k = 4; k >= 0; --k) integral = multiplyAdd(integral, t, V((1.0 / (k + 1)) * c[k]));
    return {multiplyAdd(V(integral * t), c[7], c[6]), polynomial(c, t)};
  }

 private:
  static constexpr int force = 6, all = 8;  ///< columns of a row
  static constexpr int octaves = 6, bits = 7,
                       rows = (octaves << bits) + 1;  ///< and a spare one before
  static constexpr double first = 0.5, last = 32.0;

  /// Maps s to the scaled distance y in [1/2, 32): below the inner join [1/2, 1), up to the switch
  /// [1, 16), finest at contact, then [16, 32).
  struct Zone {
    double scale, shift;
  };

  template <class V>
  NW_INLINE V scaled(const V& s) const {
    const auto inside = s < V(inner2_);
    const auto middle = s < V(outer2_);
    const V scale =
        select(inside, V(zones_[0].scale), select(middle, V(zones_[1].scale), V(zones_[2].scale)));
    const V shift =
        select(inside, V(zones_[0].shift), select(middle, V(zones_[1].shift), V(zones_[2].shift)));
    const V y = multiplyAdd(s, scale, shift);
    // Written so that what is not a number finds the last row. Round-off below zero distance finds
    // the spare row before the first.
    return select(y < V(last), y, V(last));
  }

  /// The row of `s` and the place `t` within it.
  template <int columns, class V>
  NW_INLINE std::array<V, columns> row(const V& s, V& t) const {
    const V y = scaled(s);
    V begin;
    const auto place = octavePart<bits>(y, first, begin);
    t = y - begin;
    return loadRows<columns>(table_.get() + all, place);
  }

  template <class V, std::size_t n>
  NW_INLINE static V polynomial(const std::array<V, n>& c, const V& t) {
    V f = c[5];
    for (int k = 4; k >= 0; --k) f = multiplyAdd(f, t, c[k]);
    return f;
  }

  struct Free {
    void operator()(double* p) const { ::operator delete[](p, std::align_val_t(64)); }
  };

  Joins joins_;
  double inner2_, outer2_;
  Zone zones_[3];
  std::unique_ptr<double[], Free> table_;
};

}  // namespace nanoweft
