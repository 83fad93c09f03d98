/// -snapshot_file: snapshots of a run at an interval.
#pragma once

#include <memory>
#include <string>

#include "nanoweft/base/units.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Snapshots `name`_<step>.h5 every `interval` steps; null for an empty name.
std::unique_ptr<Observer> makeSnapshotWriter(const std::string& name, long interval,
                                             const UnitSystem& units);

}  // namespace nanoweft
