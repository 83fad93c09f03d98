#include "nanoweft/force/pair_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/force/interpolation.hpp"

namespace nanoweft {

namespace {

/// The bits of x rounded to the upper 32; the lower 32 are zero.
std::uint64_t upperHalf(double x) {
  return (std::bit_cast<std::uint64_t>(x) + 0x80000000u) & 0xffffffff00000000u;
}

/// The four doubles of a row. The highest coefficients are rounded first; the lower ones are fitted
/// to what that leaves of the function.
template <class F>
std::array<double, 4> packedRow(const F& f, double width) {
  const std::uint64_t low = upperHalf(interpolate<5>(f, width)[4]);
  const double c4 = std::bit_cast<double>(low);
  auto cubic = [&](double t) { return f(t) - c4 * (t * t) * (t * t); };
  // The kernel reads c3 with c4 in its lower half; that number is rounded to the wanted one.
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
  zones_[0] = {(1.0 - first) / (joins.inner * joins.inner), first};
  const double end = placeNodes();
  last_ = std::ldexp(1.0, std::ilogb(end) + 1);

  const int rows = (std::ilogb(last_ / first) << bits) + 1;
  // The rows of coefficients, then the rows of energies, each with a spare row in front.
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
    if (begin >= end) continue;
    const Zone& zone = zones_[begin < 1.0 ? 0 : 1];
    double* row = table + columns * i;
    const auto c = packedRow(
        [&](double t) { return slope(std::sqrt((begin + t - zone.shift) / zone.scale)); }, width);
    std::copy(c.begin(), c.end(), row);
    const double half = 0.5 / zone.scale;
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
  constexpr std::int64_t skipped = columns * (std::bit_cast<std::int64_t>(first) >> (52 - bits));
  auto fromZero = [](const double* rows) {
    return reinterpret_cast<const double*>(reinterpret_cast<std::uintptr_t>(rows) -
                                           sizeof(double) * skipped);
  };
  table_ = fromZero(table);
  energies_ = fromZero(energies);
  memory_ = std::move(memory);
}

double PairTable::placeNodes() {
  const double inner = joins_.inner * joins_.inner, outer = joins_.outer * joins_.outer,
               cutoff = joins_.cutoff * joins_.cutoff;
  if (!(inner < outer && outer < cutoff))
    throw InputError(format("a pair law whose parts join at %g, %g and %g cannot be tabulated",
                            joins_.inner, joins_.outer, joins_.cutoff));
  // From the begin of the switch to the end are at least so many parts of the table.
  constexpr double fewest = 2;
  if ((cutoff - outer) / (outer - inner) * (1 << bits) < fewest)
    throw InputError(
        format("a pair law that fades from %.10g to %.10g does so too abruptly; begin earlier or "
               "end later "
               "(-pair_switch and -pair_cutoff, or those of its gap)",
               joins_.outer, joins_.cutoff));
  // The begin of the switch has to be a node, too. Of all nodes from y = 16 on, it gets the one for
  // which the cutoff lies least beyond a node. After some octaves the next ones bring nothing new.
  constexpr int octaves = 6;
  const double least = 1.0 + zones_[0].scale * (outer - inner);
  double octave = 16, best = 2.0, end = 0.0;
  while (2.0 * octave <= least) octave *= 2.0;
  for (int n = 0; n < octaves && best > joins_.miss; ++n, octave *= 2.0)
    for (int k = 0; k < 1 << bits; ++k) {
      const double image = octave + std::ldexp(octave * k, -bits),
                   scale = (image - 1.0) / (outer - inner), y = 1.0 + scale * (cutoff - inner),
                   width = std::ldexp(1.0, std::ilogb(y) - bits),
                   miss = y / width - std::floor(y / width);
      if (scale < zones_[0].scale || miss >= best) continue;
      best = miss;
      end = width * std::floor(y / width);
      zones_[1] = {scale, 1.0 - scale * inner};
    }
  return end;
}

PairTable PairTable::nearPart(double from) const {
  if (!(from > joins_.inner))
    throw InputError(
        format("-pair_far_from %g: must lie beyond %g, where the branches of the law join", from,
               joins_.inner));
  const double rest = slope(from * from);
  // The middle join only places nodes: the law is smooth there. The force ends with a kink.
  return PairTable({joins_.inner, 0.5 * (joins_.inner + from), from, 1e-3},
                   [&](double r) { return slope(r * r) - rest; });
}

PairTable PairTable::farPart(double from) const {
  return PairTable({from, joins_.outer, joins_.cutoff, joins_.miss}, [&](double r) {
    const double place = std::max(r, from);
    return slope(place * place);
  });
}

}  // namespace nanoweft
