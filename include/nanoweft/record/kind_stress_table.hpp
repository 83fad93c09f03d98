/// -kind_stress_monitor: who carries the stress of a tension test.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Reads the option; a row every `interval` steps: the part of each carrier (carriers.hpp) in the
/// axial stress of the gage region. Null when no table is wanted. Throws InputError when kinds have
/// no names.
std::unique_ptr<Observer> makeKindStressTable(Options& options, const UnitSystem& units,
                                              const Kinds& kinds, const Boundaries& boundaries,
                                              long interval);

}  // namespace nanoweft
