/// A pair law as a table of polynomials in the squared distance: no root, no division, no power and
/// no branch is left for the pair kernel, whatever the law.
///
/// The quantity tabulated is f(s) = u'(r)/r with s = r^2, by polynomials of degree four in equal
/// parts of octaves; the energy is their integral, u(s) = -1/2 int_s f, so that energy and force
/// agree to round-off. Where the law joins its branches, the table has a node. Against the law
/// itself both are within 1e-11 from 0.3 of the inner join on, and 1e-9 from 0.2 of it; below a
/// tenth, where fibres have passed through each other, the force is rounded off to stay finite.
///
/// A row is four doubles, half a cache line, since loading rows is most of a point pair's work. The
/// fourth holds the two highest coefficients, 20 bits of each, which is more than their share of
/// the value needs: read as a double it is c3, its lower half moved up is c4.
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

/// What a kernel needs of a table, to be copied for its own use: a copy's constants stay in
/// registers.
class PairRows {
 public:
  double cutoff() const { return cutoff_; }
  double cutoff2() const { return cutoff_ * cutoff_; }

  /// u'(r)/r at s = r^2; zero beyond the cutoff.
  template <class V>
  NW_INLINE V slope(const V& s) const {
    V t;
    return force(loadRows<columns>(table_, rowOf(s, t)), t);
  }

  template <class V>
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
  static constexpr int columns = 4, bits = 9;
  static constexpr double first = 0.5;

  /// Maps s to the scaled distance y: below the inner join [1/2, 1), up to the switch from 1 to a
  /// power of two, 16 or more, finest at contact, then on to another. Each zone is steeper than the
  /// one before, so that the highest of the three lines is the right one.
  struct Zone {
    double scale, shift;
  };

  /// Where the row of `s` begins, and the place `t` within it.
  template <class V>
  NW_INLINE auto rowOf(const V& s, V& t) const {
    const V inside = multiplyAdd(s, V(zones_[0].scale), V(zones_[0].shift)),
            middle = multiplyAdd(s, V(zones_[1].scale), V(zones_[1].shift)),
            outside = multiplyAdd(s, V(zones_[2].scale), V(zones_[2].shift));
    // What is not a number finds the last row. Round-off below zero distance finds the spare row
    // before the first.
    const V y = smaller(larger(larger(inside, middle), outside), V(last_));
    V begin;
    const auto place = octavePart<bits, columns>(y, first, begin);
    t = y - begin;
    return place;
  }

  template <class V>
  NW_INLINE static V force(const std::array<V, columns>& c, const V& t) {
    const V high = multiplyAdd(V(lowerHalf(c[3])), t, c[3]);
    return multiplyAdd(multiplyAdd(multiplyAdd(high, t, c[2]), t, c[1]), t, c[0]);
  }

  double cutoff_, last_;
  Zone zones_[3];
  const double *table_, *energies_;  ///< coefficients; energy and half of ds/dt
};

class PairTable : public PairRows {
 public:
  using Kernel = PairRows;
  /// Distances where the law is not smooth: the inner join, the begin of the switch, the end.
  struct Joins {
    double inner, outer, cutoff;
  };
  /// `slope`: u'(r)/r between the joins, taken one-sidedly at them.
  PairTable(const Joins& joins, const std::function<double(double r)>& slope);

  const Joins& joins() const { return joins_; }

 private:
  Joins joins_;
  std::shared_ptr<const double[]> memory_;
};

}  // namespace nanoweft
