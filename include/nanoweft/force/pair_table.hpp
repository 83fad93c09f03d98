/// A pair law as a table of polynomials in the squared distance. The pair kernel evaluates it
/// without root, division, power or branch, whatever the law.
///
/// The quantity tabulated is f(s) = u'(r)/r with s = r^2, by polynomials of degree four in equal
/// parts of octaves; the energy is their integral, u(s) = -1/2 int_s f, so that energy and force
/// agree to round-off. Where the law joins its branches, the table has a node. Against the law
/// itself both are within 1e-11 from 0.3 of the inner join on, and 1e-9 from 0.2 of it; below a
/// tenth, where fibres have passed through each other, the force is rounded off to stay finite.
///
/// A row is four doubles, half a cache line, since loading rows is most of a point pair's work. The
/// fourth double holds the two highest coefficients: read as it stands it is c3, its lower half
/// moved up is c4. Each keeps 20 bits, more than its share of the value needs.
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

/// A table to be evaluated. Its constants are of the type V: a kernel makes them SIMD vectors once
/// instead of at every use.
template <class V>
class PairRows {
 public:
  /// Points are summed in couples (sumPoints in pair_kernel.hpp).
  static constexpr bool couples = true;

  double cutoff() const { return cutoff_; }

  PairRows() = default;
  template <class W>
  explicit PairRows(const PairRows<W>& other)
      : cutoff_(other.cutoff_),
        last_(other.last_),
        table_(other.table_),
        energies_(other.energies_) {
    for (int z = 0; z < 2; ++z) zones_[z] = {V(other.zones_[z].scale), V(other.zones_[z].shift)};
  }

  /// u'(r)/r at s = r^2; zero beyond the cutoff.
  NW_INLINE V slope(const V& s) const {
    V t;
    return force(loadRows<columns>(table_, rowOf(s, t)), t);
  }

  NW_INLINE PairValue<V> operator()(const V& s) const {
    V t;
    const auto place = rowOf(s, t);
    const auto c = loadRows<columns>(table_, place);
    // The integral of the force's polynomial from the row's begin, the energy there, and the length
    // of ds over dt, halved.
    const auto base = loadRows<2>(energies_, place);
    V integral = multiplyAdd(V(0.2 * lowerHalf(c[3])), t, V(0.25 * c[3]));
    integral = multiplyAdd(integral, t, V((1.0 / 3.0) * c[2]));
    integral = multiplyAdd(integral, t, V(0.5 * c[1]));
    integral = multiplyAdd(integral, t, V(c[0]));
    return {multiplyAdd(V(integral * t), V(base[1]), V(base[0])), force(c, t)};
  }

 protected:
  template <class W>
  friend class PairRows;

  static constexpr int columns = 4, bits = 9;
  static constexpr double first = 0.5;

  /// Maps s linearly to the scaled distance y. Below the inner join y lies in [1/2, 1), beyond it
  /// from 1 on. The second line is steeper, so the right line is always the higher of the two.
  /// Parts are finest just beyond y = 1, at contact.
  struct Zone {
    V scale, shift;
  };

  /// Where the row of `s` begins, and the place `t` within it.
  NW_INLINE auto rowOf(const V& s, V& t) const {
    const V inside = multiplyAdd(s, zones_[0].scale, zones_[0].shift),
            outside = multiplyAdd(s, zones_[1].scale, zones_[1].shift);
    // A NaN gets the last row. A distance that round-off makes negative gets the spare row before
    // the first.
    const V y = smaller(larger(inside, outside), last_);
    V begin;
    const auto place = octavePart<bits, columns>(y, begin);
    t = y - begin;
    return place;
  }

  NW_INLINE static V force(const std::array<V, columns>& c, const V& t) {
    const V high = multiplyAdd(V(lowerHalf(c[3])), t, c[3]);
    return multiplyAdd(multiplyAdd(multiplyAdd(high, t, c[2]), t, c[1]), t, c[0]);
  }

  double cutoff_;
  V last_;
  Zone zones_[2];
  // Rows of coefficients, and rows of the energy and half of ds/dt. Both pointers point to where
  // the row of y = 0 would be, since rows are counted from that one.
  const double *table_, *energies_;
};

class PairTable : public PairRows<double> {
 public:
  using Kernel = PairRows<Lanes>;
  /// Distances where the law is not smooth: the inner join, the begin of the switch, the end.
  struct Joins {
    double inner, outer, cutoff;
    /// How far the cutoff may lie beyond a node, in parts, where that can be had: the law ends
    /// there. A law whose force ends with a kink needs less than one that fades smoothly, and gets
    /// more rows.
    double miss = 1e-2;
  };
  /// `slope`: u'(r)/r between the joins, taken one-sidedly at them. Throws InputError for joins
  /// that do not follow each other, or leave too little room for the switch.
  PairTable(const Joins& joins, const std::function<double(double r)>& slope);

  const Joins& joins() const { return joins_; }
  /// The two parts of the law when it is split at a distance (PointChoice).
  PairTable nearPart(double from) const;
  PairTable farPart(double from) const;

 private:
  /// Sets the second zone; returns where the law ends, a node at or just before the cutoff.
  double placeNodes();

  Joins joins_;
  std::shared_ptr<const double[]> memory_;
};

}  // namespace nanoweft
