/// Kinking of thin tubes (model.md 12): beyond a critical angle between the axes of a bond's
/// segments the bending energy grows linearly, not quadratically.
///
/// With theta = |e1_i - e1_j| (the angle, to second order) and K the bond's stiffness in
/// antisymmetric bending, bending alone costs K theta^2/2. A kink takes from it
///
///     (1 - residual) K/2 g(theta - angle),
///     g(t) = 0 for t < 0;  t^3/(3 w) up to w = angle/10;  t^2 - w t + w^2/3 beyond,
///
/// which is smooth to the second derivative. Beyond the join the moment stays what it is there, but
/// for the residual stiffness.
#pragma once

#include <cmath>

#include "nanoweft/fibre/bond.hpp"

namespace nanoweft {

template <class C>
struct KinkOf {
  C angle{};  ///< 0: the bond does not kink
  C taken{};  ///< (1 - residual) K                    (eV)

  /// Adds the kink to what the bond's law says.
  template <class V>
  NW_INLINE void add(const BondGeometry<V>& bond, BondForce<V>& force) const {
    const Vec3<V> ei = axis1(bond.qi), ej = axis1(bond.qj), d = ei - ej;
    const V theta = root(V(dot(d, d)));
    const V width = V(0.1 * angle), t = theta - V(angle);
    const V within = t * t / width, beyond = 2.0 * t - width;
    const V slope = select(t < V(0.0), V(0.0), select(t < width, within, beyond));
    // theta has no direction at zero, where there is no kink either.
    const V perTheta = select(t < V(0.0), V(0.0), V(slope / theta));
    const Vec3<V> couple = V(V(-0.5 * taken) * perTheta) * cross(ei, ej);
    force.torqueI += couple;
    force.torqueJ += -couple;
  }
  template <class V>
  NW_INLINE void add(const BondGeometry<V>& bond, BondEnergy<V>& energy) const {
    const Vec3<V> d = axis1(bond.qi) - axis1(bond.qj);
    const V theta = root(V(dot(d, d)));
    const V width = V(0.1 * angle), t = theta - V(angle);
    const V within = t * t * t / (3.0 * width), beyond = t * (t - width) + width * width / 3.0;
    const V g = select(t < V(0.0), V(0.0), select(t < width, within, beyond));
    energy.bending += V(-0.5 * taken) * g;
  }

 private:
  template <class V>
  NW_INLINE static V root(const V& x) {
    using std::sqrt;
    return sqrt(x);
  }
};
using Kink = KinkOf<double>;

}  // namespace nanoweft
