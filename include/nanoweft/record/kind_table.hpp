/// -kind_monitor: a table of the energies of each kind of fibre and of each two kinds.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Reads the option; a row every `interval` steps. Null when no table is wanted. Throws InputError
/// when kinds have no names.
std::unique_ptr<Observer> makeKindTable(Options& options, const UnitSystem& units,
                                        const Kinds& kinds, long interval);

}  // namespace nanoweft
