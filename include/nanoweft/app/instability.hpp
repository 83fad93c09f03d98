/// The error that ends an unstable run.
#pragma once

#include <string>

#include "nanoweft/base/units.hpp"
#include "nanoweft/motion/box_drive.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Throws a RunError that names the fastest segment; `sign`: another sign of the instability to be
/// named, or empty; `remedy`: what would help. Collective.
[[noreturn]] void throwUnstable(const Moment& moment, const UnitSystem& units,
                                const std::string& sign = "",
                                const std::string& remedy = "take a smaller -ts_dt");

/// What helps where the energy balance drifts, for people.
std::string remedyOfDrift(const BoxDrive& box);

}  // namespace nanoweft
