/// A smooth step from one to zero, which ends a pair law at its cutoff.
#pragma once

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// 1 - x^3 (10 - 15x + 6x^2) between `from` and `to`, twice continuously differentiable.
struct Switch {
  double from = 0, to = 0;

  /// The step and its derivative.
  template <class V>
  NW_INLINE void factor(const V& r, V& s, V& ds) const {
    const double inverse = 1.0 / (to - from);
    V x = (r - from) * inverse;
    x = select(x < V(0.0), V(0.0), select(x > V(1.0), V(1.0), x));
    s = 1.0 - x * x * x * (10.0 - x * (15.0 - 6.0 * x));
    const V rest = x * (1.0 - x);
    ds = (-30.0 * inverse) * rest * rest;
  }

  /// The second derivative of the step.
  double curvature(double r) const {
    const double x = (r - from) / (to - from);
    return x > 0.0 && x < 1.0
               ? -60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / ((to - from) * (to - from))
               : 0.0;
  }

  /// Multiplies u by S and u' by the product rule.
  template <class V>
  NW_INLINE void apply(const V& r, V& u, V& du) const {
    if (!anyOf(r > V(from))) return;
    V s, ds;
    factor(r, s, ds);
    du = du * s + u * ds;
    u = u * s;
  }
};

}  // namespace nanoweft
