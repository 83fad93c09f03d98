/// Contact of two stiff fibres where their axes come closest (model.md 18), after the all-angle
/// beam contact of Meier, Wall and Popp (2017). With S(x) = x^3 (10 - 15 x + 6 x^2) held between 0
/// and 1, r = x_j - x_i, c = e_i.e_j, sin^2 = 1 - c^2:
///
///     s = (r.e_i - c r.e_j)/sin^2,  t = (c r.e_i - r.e_j)/sin^2,  rho = |r + t e_j - s e_i|
///     phi(x) = 1 - S(|x|) towards a neighbour,  1 - S(2|x| - 1) towards a free end
///     k = S((sin - 0.2)/0.2)
///     U = k V(touch - rho, sin) phi(s/Ti) phi(t/Tj)
///         + (1-k)/2 [ sum_a (Ti/n) phi(t_a/Tj) W(touch - rho_a) + the same with i and j exchanged
///         ]
///
/// where p_a are the midpoints of n parts of i's axis, t_a their place along j's line and rho_a
/// their distance from it. phi adds up to 1 along a straight chain, so a crossing has one and the
/// same force wherever it falls. Hertz: V = 8/15 E* sqrt(R) delta^(5/2) with R = sqrt(ra rb)/sin,
/// W = pi/8 E* delta^2 a length.
///
/// U depends on r.r, r.e_i, r.e_j and c alone; `Slopes` holds its derivatives by them.
#pragma once

#include <cmath>
#include <numbers>

#include "nanoweft/base/both.hpp"
#include "nanoweft/base/simd.hpp"
#include "nanoweft/base/vec.hpp"

namespace nanoweft {

/// Which ends of a segment have no neighbour: 1 or 0, in SIMD a number a lane.
template <class V>
struct FreeEnds {
  V previous{}, next{};
};

/// Energy of a contact, force on i (on j: the negative) and torques.
template <class V>
struct ContactAction {
  V energy{};
  Vec3<V> force, torqueI, torqueJ;
};

/// Where and how hard two segments press on each other: means over their contact, weighted by load.
struct ContactPatch {
  double load = 0, stiffness = 0;  ///< normal force and its slope by the overlap
  double share = 0;                ///< that these two segments have in the contact of their fibres
  double placeI = 0, overlap = 0;  ///< along i's axis from its centre
  Vec3d normal;                    ///< unit vector from i to j
};

class ContactLaw {
 public:
  /// `modulus`: E*.
  ContactLaw(double modulus, Both<double> radius, Both<double> length, int points)
      : touch_(radius.i + radius.j),
        length_(length),
        points_(points),
        crossed_(8.0 / 15.0 * modulus * std::pow(radius.i * radius.j, 0.25)),
        line_(std::numbers::pi / 8.0 * modulus) {}

  double touch() const { return touch_; }
  /// Centre distance beyond which two segments do not touch.
  double reach() const { return std::hypot(touch_, length_.i + length_.j); }
  /// Force of two fibres crossed at a right angle, and its slope, at an overlap.
  double crossedForce(double overlap) const { return 2.5 * crossed_ * std::pow(overlap, 1.5); }
  double crossedStiffness(double overlap) const { return 3.75 * crossed_ * std::sqrt(overlap); }
  /// Stiffness of two segments that lie along each other.
  double lineStiffness() const { return 2.0 * line_ * std::min(length_.i, length_.j); }

  /// False where two segments cannot touch; cheap.
  template <class V>
  NW_INLINE auto mayTouch(const Vec3<V>& r, const Vec3<V>& ei, const Vec3<V>& ej) const {
    const Invariants<V> x(r, ei, ej);
    const V sine2 = 1.0 - x.c * x.c, safe = larger(sine2, V(0.04));
    const V s = (x.a - x.c * x.b) / safe, t = (x.c * x.a - x.b) / safe;
    const V rho2 = x.r2 - s * x.a + t * x.b;
    const auto crosses = sine2 > V(0.04) && rho2 < V(touch_ * touch_) &&
                         s * s < V(length_.i * length_.i) && t * t < V(length_.j * length_.j);
    // Of two lines at less than sin = 0.4, a point of i is at most 0.2 Ti farther from j's line
    // than i's centre is.
    const double aside = touch_ + 0.2 * std::max(length_.i, length_.j);
    const V fromJ = x.r2 - x.b * x.b, fromI = x.r2 - x.a * x.a;
    const auto lies = sine2 < V(0.16) && smaller(fromI, fromJ) < V(aside * aside);
    return crosses || lies;
  }

  template <class V>
  NW_INLINE ContactAction<V> operator()(const Vec3<V>& r, const Vec3<V>& ei, const Vec3<V>& ej,
                                        const FreeEnds<V>& endsI, const FreeEnds<V>& endsJ) const {
    const Invariants<V> x(r, ei, ej);
    const V sine = root(larger(V(1.0 - x.c * x.c), V(1e-30)));
    const Step<V> k = step(V(5.0 * sine - 1.0));
    Slopes<V> slopes;
    if (anyOf(sine > V(0.2))) addCrossing(x, sine, k, endsI, endsJ, slopes);
    if (anyOf(sine < V(0.4))) {
      Slopes<V> line;
      addLine<true>(x, endsJ, line);
      addLine<false>(x, endsI, line);
      const V share = 1.0 - k.value;
      slopes.r2 += share * line.r2;
      slopes.a += share * line.a;
      slopes.b += share * line.b;
      // Where sin does not enter the weight, its slope must not divide by it.
      slopes.c += share * line.c +
                  select(sine > V(0.2), V(5.0 * k.slope * line.energy * x.c / sine), V(0.0));
      slopes.energy += share * line.energy;
    }
    ContactAction<V> action;
    action.energy = slopes.energy;
    action.force = V(2.0 * slopes.r2) * r + slopes.a * ei + slopes.b * ej;
    action.torqueI = -cross(ei, slopes.a * r + slopes.c * ej);
    action.torqueJ = -cross(ej, slopes.b * r + slopes.c * ei);
    return action;
  }

  /// What friction acts on; the load is zero where the segments do not touch.
  ContactPatch patch(const Vec3d& r, const Vec3d& ei, const Vec3d& ej,
                     const FreeEnds<double>& endsI, const FreeEnds<double>& endsJ) const {
    ContactPatch sum;
    auto add = [&](double weight, double load, double stiffness, double placeI, double placeJ) {
      const Vec3d n = r + placeJ * ej - placeI * ei;
      const double rho = norm(n);
      if (!(load > 0 && rho > 0)) return;
      sum.share += weight;
      sum.load += load;
      sum.stiffness += stiffness;
      sum.placeI += load * placeI;
      sum.overlap += load * (touch_ - rho);
      sum.normal += (load / rho) * n;
    };
    auto overlapAt = [&](double placeI, double placeJ) {
      return larger(touch_ - norm(r + placeJ * ej - placeI * ei), 0.0);
    };
    const double a = dot(r, ei), b = dot(r, ej), c = dot(ei, ej),
                 sine = root(larger(1.0 - c * c, 0.0));
    const double k = step(5.0 * sine - 1.0).value;
    if (k > 0) {
      const double s = (a - c * b) / (sine * sine), t = (c * a - b) / (sine * sine);
      const double d = overlapAt(s, t), weight = k * share(s / length_.i, endsI).value *
                                                 share(t / length_.j, endsJ).value;
      const double slope = 2.5 * crossed_ * d * root(d / sine);
      add(weight, weight * slope, d > 0 ? 1.5 * weight * slope / d : 0.0, s, t);
    }
    for (int n = 0; n < points_ && k < 1; ++n) {
      const double place = (n + 0.5) / points_ - 0.5;
      auto addPoint = [&](double placeI, double placeJ, double own, double phi) {
        const double part = (1.0 - k) / points_ * phi, stiffness = part * own * line_;
        add(0.5 * part, stiffness * overlapAt(placeI, placeJ), stiffness, placeI, placeJ);
      };
      const double u = place * length_.i, t = u * c - b, v = place * length_.j, s = a + v * c;
      addPoint(u, t, length_.i, share(t / length_.j, endsJ).value);
      addPoint(s, v, length_.j, share(s / length_.i, endsI).value);
    }
    if (!(sum.load > 0)) return sum;
    sum.placeI /= sum.load;
    sum.overlap /= sum.load;
    const double size = norm(sum.normal);
    sum.normal = (size > 0 ? 1.0 / size : 0.0) * sum.normal;
    return sum;
  }

 private:
  template <class V>
  struct Invariants {
    V r2, a, b, c;
    NW_INLINE Invariants(const Vec3<V>& r, const Vec3<V>& ei, const Vec3<V>& ej)
        : r2(dot(r, r)), a(dot(r, ei)), b(dot(r, ej)), c(dot(ei, ej)) {}
  };
  template <class V>
  struct Slopes {
    V energy{}, r2{}, a{}, b{}, c{};
  };
  template <class V>
  struct Step {
    V value, slope;
  };

  template <class V>
  NW_INLINE static V root(const V& x) {
    using std::sqrt;
    return sqrt(x);
  }
  /// S and its derivative.
  template <class V>
  NW_INLINE static Step<V> step(const V& x) {
    const V y = smaller(larger(x, V(0.0)), V(1.0)), y2 = y * y;
    return {y * y2 * (10.0 + y * (6.0 * y - 15.0)), 30.0 * y2 * (1.0 - y) * (1.0 - y)};
  }
  /// phi and its derivative.
  template <class V>
  NW_INLINE static Step<V> share(const V& x, const FreeEnds<V>& ends) {
    const auto ahead = x > V(0.0);
    const V free = select(ahead, ends.next, ends.previous);
    const V size = select(ahead, x, V(-x));
    const Step<V> s = step(V(size * (1.0 + free) - free));
    const V slope = s.slope * (1.0 + free);
    return {1.0 - s.value, select(ahead, V(-slope), slope)};
  }

  template <class V>
  NW_INLINE void addCrossing(const Invariants<V>& x, const V& sine, const Step<V>& k,
                             const FreeEnds<V>& endsI, const FreeEnds<V>& endsJ,
                             Slopes<V>& slopes) const {
    const auto& [r2, a, b, c] = x;
    const V safe = larger(sine, V(0.2)), perSine2 = 1.0 / (safe * safe);
    const V s = (a - c * b) * perSine2, t = (c * a - b) * perSine2;
    const V rho = root(larger(V(r2 - s * a + t * b), V(nearest2())));
    const V overlap = larger(V(touch_ - rho), V(0.0));
    const V slope = (2.5 * crossed_) * overlap * root(V(overlap / safe)), v = 0.4 * overlap * slope;
    const Step<V> pi = share(V(s * (1.0 / length_.i)), endsI),
                  pj = share(V(t * (1.0 / length_.j)), endsJ);
    const V both = pi.value * pj.value, weight = k.value * both;
    const V alongRho = -(weight * slope) / rho;
    const V alongS = k.value * v * pi.slope * pj.value * (1.0 / length_.i),
            alongT = k.value * v * pi.value * pj.slope * (1.0 / length_.j);
    slopes.energy += weight * v;
    slopes.r2 += 0.5 * alongRho;
    slopes.a += perSine2 * (alongS + c * alongT) - alongRho * s;
    slopes.b += alongRho * t - perSine2 * (c * alongS + alongT);
    slopes.c += perSine2 * (alongS * (2.0 * c * s - b) + alongT * (2.0 * c * t + a)) -
                alongRho * s * t - (5.0 * k.slope - 0.5 * k.value / safe) * v * both * c / safe;
  }

  /// The points of i against j's line, or, with i and j exchanged, those of j against i's.
  template <bool ofI, class V>
  NW_INLINE void addLine(const Invariants<V>& x, const FreeEnds<V>& ends, Slopes<V>& slopes) const {
    const double own = ofI ? length_.i : length_.j, other = ofI ? length_.j : length_.i;
    const double weight = 0.5 * own / points_;
    // Seen from the points' segment: the other's centre along the own axis and along its own.
    const V alongOwn = ofI ? x.a : V(-x.b), alongOther = ofI ? x.b : V(-x.a);
    V forOwn{}, forOther{};
    for (int n = 0; n < points_; ++n) {
      const double u = ((n + 0.5) / points_ - 0.5) * own;
      const V place = u * x.c - alongOther;
      const V rho = root(larger(V(x.r2 + u * (u - 2.0 * alongOwn) - place * place), V(nearest2())));
      const V overlap = larger(V(touch_ - rho), V(0.0));
      const Step<V> p = share(V(place * (1.0 / other)), ends);
      const V w = (weight * line_) * overlap * overlap;
      const V alongRho = (-2.0 * weight * line_) * p.value * overlap / rho,
              alongPlace = (1.0 / other) * p.slope * w;
      slopes.energy += p.value * w;
      slopes.r2 += 0.5 * alongRho;
      forOwn -= alongRho * u;
      forOther += alongRho * place - alongPlace;
      slopes.c += u * (alongPlace - alongRho * place);
    }
    slopes.a += ofI ? forOwn : V(-forOther);
    slopes.b += ofI ? forOther : V(-forOwn);
  }

  /// The least rho^2. It is a difference of squares of the segments' lengths, so near zero it is
  /// all round-off, and the force r + t e_j - s e_i over rho would be too. Below, the force fades
  /// out.
  double nearest2() const { return 1e-8 * touch_ * touch_; }

  double touch_;
  Both<double> length_;
  int points_;
  double crossed_, line_;  ///< V = crossed_ delta^(5/2)/sqrt(sin), W = line_ delta^2
};

}  // namespace nanoweft
