#include "nanoweft/force/pair_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "nanoweft/force/interpolation.hpp"

namespace nanoweft {

namespace {

/// The upper half of a number's bits, rounded to nearest, in the upper half.
std::uint64_t upperHalf(double x) {
  return (std::bit_cast<std::uint64_t>(x) + 0x80000000u) & 0xffffffff00000000u;
}

/// A row's columns. What rounding the highest coefficients leaves is taken up by the lower ones.
template <class F>
std::array<double, 4> packedRow(const F& f, double width) {
  const std::uint64_t low = upperHalf(interpolate<5>(f, width)[4]);
  const double c4 = std::bit_cast<double>(low);
  auto cubic = [&](double t) { return f(t) - c4 * (t * t) * (t * t); };
  // Rounded as the number that it is with c4 in its lower half.
  const double wanted = interpolate<4>(cubic, width)[3];
  const std::uint64_t high =
      upperHalf(std::bit_cast<double>(std::bit_cast<std::uint64_t>(wanted) - (low >> 32)));
  const double c3 = std::bit_cast<double>(high | low >> 32);
  const auto c = interpolate<3>([&](double t) { return cubic(t) - c3 * t * t * t; }, width);
  return {c[0], c[1], c[2], c3};
}

}  // namespace

PairTable::PairTable(const Joins& joins, const std::function<double(double r)>& slope) {
  joins_ = joins;
  cutoff_ = joins.cutoff;
  const double ends[4] = {0.0, joins.inner * joins.inner, joins.outer * joins.outer,
                          joins.cutoff * joins.cutoff};
  double images[4] = {first, 1.0, 16.0, 0.0};
  auto scale = [&](int z) { return (images[z + 1] - images[z]) / (ends[z + 1] - ends[z]); };
  while (scale(1) < scale(0)) images[2] *= 2;
  images[3] = 2 * images[2];
  while (scale(2) < scale(1)) images[3] *= 2;
  last_ = images[3];
  for (int z = 0; z < 3; ++z) zones_[z] = {scale(z), images[z] - ends[z] * scale(z)};

  const int rows = (std::ilogb(last_ / first) << bits) + 1;
  // Row by row the coefficients, then the energies, each with a spare row before.
  const auto size = static_cast<std::size_t>((rows + 1) * columns);
  std::shared_ptr<double[]> memory(
      static_cast<double*>(::operator new[](2 * size * sizeof(double), std::align_val_t(64))),
      [](double* p) { ::operator delete[](p, std::align_val_t(64)); });
  std::fill_n(memory.get(), 2 * size, 0.0);
  double* const table = memory.get() + columns;
  double* const energies = table + size;
  double energy = 0.0;  // from the cutoff inwards
  for (int i = rows - 2; i >= 0; --i) {
    const double octave = std::ldexp(first, i >> bits), width = std::ldexp(octave, -bits);
    const double begin = octave + (i & ((1 << bits) - 1)) * width;
    const int z = begin < 1.0 ? 0 : begin < images[2] ? 1 : 2;
    double* row = table + columns * i;
    const auto c = packedRow(
        [&](double t) {
          const double s = ends[z] + (begin - images[z] + t) / zones_[z].scale;
          return slope(std::sqrt(s));
        },
        width);
    std::copy(c.begin(), c.end(), row);
    const double half = 0.5 / zones_[z].scale;
    double integral = 0.2 * lowerHalf(c[3]) * width;
    for (int k = 3; k >= 0; --k)
      integral = (integral + c[static_cast<std::size_t>(k)] / (k + 1)) * width;
    energy -= half * integral;
    energies[columns * i] = energy;
    energies[columns * i + 1] = half;
  }
  // The spare row: the value at zero distance.
  table[-columns] = table[0];
  energies[-columns] = energy;
  table_ = table;
  energies_ = energies;
  memory_ = std::move(memory);
}

}  // namespace nanoweft
