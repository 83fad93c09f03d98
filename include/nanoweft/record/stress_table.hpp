/// -stress_monitor: a table of the stress in a tension test. The observer also finds the strength
/// (the largest stress) for the summary, with or without a table.
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
