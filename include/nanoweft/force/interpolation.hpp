/// Polynomials through a function's values at Chebyshev points, for the tables of pair laws.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace nanoweft {

/// Coefficients of the polynomial in t, of degree n - 1, through f at the Chebyshev points of
/// [0, width].
template <std::size_t n, class F>
std::array<double, n> interpolate(const F& f, double width) {
  std::array<long double, n> x, divided;
  for (std::size_t k = 0; k < n; ++k) {
    x[k] = 0.5L * (1.0L - std::cos((k + 0.5L) * std::numbers::pi_v<long double> / n));
    divided[k] = f(static_cast<double>(x[k]) * width);
  }
  for (std::size_t order = 1; order < n; ++order)
    for (std::size_t k = n - 1; k >= order; --k)
      divided[k] = (divided[k] - divided[k - 1]) / (x[k] - x[k - order]);
  // Newton's form to powers of t/width, then of t.
  std::array<long double, n> c{};
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = n - 1; j > 0; --j) c[j] = c[j - 1] - x[k] * c[j];
    c[0] = divided[k] - x[k] * c[0];
  }
  std::array<double, n> result;
  long double scale = 1.0L;
  for (std::size_t k = 0; k < n; ++k, scale *= width) result[k] = static_cast<double>(c[k] / scale);
  return result;
}

/// The same for f on [0, 1], in powers of t - 1/2.
template <std::size_t n, class F>
std::array<double, n> centred(const F& f) {
  auto c = interpolate<n>(f, 1.0);
  for (std::size_t k = 0; k + 1 < n; ++k)
    for (std::size_t j = n - 1; j-- > k;) c[j] += 0.5 * c[j + 1];
  return c;
}

}  // namespace nanoweft
