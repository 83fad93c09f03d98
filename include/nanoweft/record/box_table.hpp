/// -box_monitor: strain and stress of the periodic box.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/motion/box_drive.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Reads the option; a row every `interval` steps: the strain of each direction and the whole
/// tensor of the stress, virial less motion, over `drive`'s volume.
/// Null when no table is wanted and the box is not driven.
std::unique_ptr<Observer> makeBoxTable(Options& options, const UnitSystem& units, BoxDrive& drive,
                                       long interval);

}  // namespace nanoweft
