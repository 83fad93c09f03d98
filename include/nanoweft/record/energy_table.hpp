/// -energy_monitor: a table of energies and energy accounts.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Columns that only some runs have.
struct ExtraEnergies {
  bool friction = false, walls = false, heat = false;
};

/// Reads the option; a row every `interval` steps. Null when no table is wanted.
std::unique_ptr<Observer> makeEnergyTable(Options& options, const UnitSystem& units,
                                          const ExtraEnergies& extras, long interval);

}  // namespace nanoweft
