#include "nanoweft/force/pair_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nanoweft {

namespace {

constexpr int degree = 5;

/// Coefficients of the polynomial in t through f at the Chebyshev points of [0, width].
template <class F>
std::array<double, degree + 1> interpolate(const F& f, double width) {
  std::array<long double, degree + 1> x, divided;
  for (int k = 0; k <= degree; ++k) {
    const auto a = static_cast<std::size_t>(k);
    x[a] = 0.5L * (1.0L - std::cos((k + 0.5L) * std::numbers::pi_v<long double> / (degree + 1)));
    divided[a] = f(static_cast<double>(x[a]) * width);
  }
  for (std::size_t order = 1; order <= degree; ++order)
    for (std::size_t k = degree; k >= order; --k)
      divided[k] = (divided[k] - divided[k - 1]) / (x[k] - x[k - order]);
  // Newton's form to powers of t/width, then of t.
  std::array<long double, degree + 1> c{};
  for (std::size_t k = degree + 1; k-- > 0;) {
    for (std::size_t j = degree; j > 0; --j) c[j] = c[j - 1] - x[k] * c[j];
    c[0] = divided[k] - x[k] * c[0];
  }
  std::array<double, degree + 1> result;
  long double scale = 1.0L;
  for (std::size_t k = 0; k <= degree; ++k, scale *= width)
    result[k] = static_cast<double>(c[k] / scale);
  return result;
}

}  // namespace

PairTable::PairTable(const Joins& joins, const std::function<double(double r)>& slope)
    : joins_(joins),
      inner2_(joins.inner * joins.inner),
      outer2_(joins.outer * joins.outer),
      table_(static_cast<double*>(
          ::operator new[]((rows + 1) * all * sizeof(double), std::align_val_t(64)))) {
  const double ends[4] = {0.0, inner2_, outer2_, joins.cutoff * joins.cutoff};
  const double images[4] = {first, 1.0, 16.0, last};
  for (int z = 0; z < 3; ++z) {
    zones_[z].scale = (images[z + 1] - images[z]) / (ends[z + 1] - ends[z]);
    zones_[z].shift = images[z] - ends[z] * zones_[z].scale;
  }
  std::fill_n(table_.get(), (rows + 1) * all, 0.0);
  double energy = 0.0;  // from the cutoff inwards
  for (int i = rows - 2; i >= 0; --i) {
    const double octave = std::ldexp(first, i >> bits), width = std::ldexp(octave, -bits);
    const double begin = octave + (i & ((1 << bits) - 1)) * width;
    const int z = begin < 1.0 ? 0 : begin < 16.0 ? 1 : 2;
    const auto c = interpolate(
        [&](double t) {
          const double s = ends[z] + (begin - images[z] + t) / zones_[z].scale;
          return slope(std::sqrt(s));
        },
        width);
    const double half = 0.5 / zones_[z].scale;
    double integral = 0.0;
    for (int k = degree; k >= 0; --k)
      integral = (integral + c[static_cast<std::size_t>(k)] / (k + 1)) * width;
    energy -= half * integral;
    double* row = table_.get() + all * (i + 1);
    std::copy(c.begin(), c.end(), row);
    row[6] = energy;
    row[7] = half;
  }
  // The spare row: the value at zero distance.
  table_[0] = table_[all];
  table_[6] = energy;
}

}  // namespace nanoweft
