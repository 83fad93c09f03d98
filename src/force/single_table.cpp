#include "nanoweft/force/single_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "nanoweft/force/interpolation.hpp"

namespace nanoweft {

SingleTable::SingleTable(const PairTable& table) {
  const auto& joins = table.joins();
  const double ends[4] = {0.0, joins.inner * joins.inner, joins.outer * joins.outer,
                          joins.cutoff * joins.cutoff};
  const double images[4] = {first, 1.0, outer, last};
  origin_ = ends[1];
  double scale[3];
  for (int z = 0; z < 3; ++z) {
    scale[z] = (images[z + 1] - images[z]) / (ends[z + 1] - ends[z]);
    zones_[z] = {static_cast<float>(ends[z] - origin_), static_cast<float>(scale[z]),
                 static_cast<float>(images[z] - (ends[z] - origin_) * scale[z])};
  }
  auto memory = std::make_shared<SingleColumns>();
  auto set = [](ShortColumn* columns, int place, const auto& c) {
    for (std::size_t k = 0; k < terms; ++k) columns[k].at[place & 31] = static_cast<float>(c[k]);
  };
  const int firstPart = std::bit_cast<std::int32_t>(first) >> (23 - bits);
  const int parts = static_cast<int>(std::log2(last / first)) << bits;
  for (int i = 0; i < parts; ++i) {
    const double octave = std::ldexp(first, i >> bits), width = std::ldexp(octave, -bits);
    const double begin = octave + (i & ((1 << bits) - 1)) * width;
    const int z = begin < 1.0 ? 0 : begin < outer ? 1 : 2;
    auto squared = [&](double t) { return ends[z] + (begin - images[z] + t * width) / scale[z]; };
    set(memory->slope, firstPart + i,
        centred<terms>([&](double t) { return table.slope(squared(t)); }));
    set(memory->energy, firstPart + i,
        centred<terms>([&](double t) { return table(squared(t)).energy; }));
  }
  // A distance that round-off makes negative gets the part before the first: the values at zero.
  const std::array<double, terms> slope{table.slope(0.0)}, energy{table(0.0).energy};
  set(memory->slope, firstPart - 1, slope);
  set(memory->energy, firstPart - 1, energy);
  columns_ = memory.get();
  memory_ = std::move(memory);
  cutoff2_ = static_cast<float>(ends[3] - origin_);
  const int end = firstPart + parts;
  auto place = [this](float s) {
    float t;
    return placeOf(s, t);
  };
  while (place(cutoff2_) == end) cutoff2_ = std::nextafter(cutoff2_, 0.0f);
  while (place(cutoff2_) != end) cutoff2_ = std::nextafter(cutoff2_, 2.0f * cutoff2_);
}

}  // namespace nanoweft
