/// What ends a run that has become unstable.
#pragma once

#include <string>

#include "nanoweft/base/units.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Throws RunError that names the fastest segment; `sign`: what else speaks for it, or nothing.
/// Collective.
[[noreturn]] void throwUnstable(const Moment& moment, const UnitSystem& units,
                                const std::string& sign);

}  // namespace nanoweft
