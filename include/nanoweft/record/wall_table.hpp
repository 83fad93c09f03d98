/// -wall_monitor: what walls feel, and where they are.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/force/wall.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Reads the option; a row every `interval` steps: for each wall the force of the fibres on it, its
/// torque about the wall's point, and the way of that point. Null when no table is wanted.
std::unique_ptr<Observer> makeWallTable(Options& options, const UnitSystem& units,
                                        const Walls& walls, long interval);

}  // namespace nanoweft
