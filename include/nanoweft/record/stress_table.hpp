/// -stress_monitor: a table of the stress in a tension test; and the strength, with or without it.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Reads the option; looks at the stress every `interval` steps. The boundaries must outlive it.
std::unique_ptr<Observer> makeStressTable(Options& options, const UnitSystem& units,
                                          const Boundaries& boundaries, long interval);

}  // namespace nanoweft
