/// How much energy may come out of nothing by round-off.
#pragma once

#include <cmath>
#include <cstdint>

#include "nanoweft/fibre/kinds.hpp"

namespace nanoweft {

/// For fibres at rest whose pairs have the energy `pair`. Strains below 1e-8 are round-off of
/// places far from the origin; forces and energies of pairs, which come from tables, agree to
/// about 1e-9.
inline double roundOff(const Kinds& kinds, std::int64_t segments, double pair) {
  return 1e-16 * kinds.energyScale() * static_cast<double>(segments) + 1e-8 * std::abs(pair);
}

}  // namespace nanoweft
