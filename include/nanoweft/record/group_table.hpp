/// -group_monitor: by what the groups of -bc are held and loaded, where they are, and the work.
#pragma once

#include <memory>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

/// Reads the option; a row every `interval` steps with, for each name (model.md 15):
///
/// * force and torque on the group: in held components what balances the fibres, in others the
/// load;
///   the torque about the centre, or the mean position where there is none;
/// * mean position of its segments, unwrapped, and by how much it has changed since the run began;
/// * work that the group has brought in since then.
///
/// Null when no table is wanted. Throws InputError when there are no groups.
std::unique_ptr<Observer> makeGroupTable(Options& options, const UnitSystem& units,
                                         const Boundaries& boundaries, long interval);

}  // namespace nanoweft
