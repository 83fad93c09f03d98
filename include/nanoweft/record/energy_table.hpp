/// -energy_monitor: a table of energies and energy accounts.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Reads the option; a row every `interval` steps, with a column for the work of friction where
/// there is `friction`. Null when no table is wanted.
std::unique_ptr<Observer> makeEnergyTable(Options& options, const UnitSystem& units, bool friction,
                                          long interval);

}  // namespace nanoweft
