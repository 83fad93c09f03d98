#include "nanoweft/app/observers.hpp"

#include <algorithm>
#include <utility>

#include "nanoweft/record/box_table.hpp"
#include "nanoweft/record/energy_table.hpp"
#include "nanoweft/record/group_table.hpp"
#include "nanoweft/record/kind_stress_table.hpp"
#include "nanoweft/record/kind_table.hpp"
#include "nanoweft/record/snapshot_writer.hpp"
#include "nanoweft/record/stress_table.hpp"
#include "nanoweft/record/wall_table.hpp"

namespace nanoweft {

Observers makeObservers(Options& options, const ObserverContext& c) {
  const RunSettings& s = c.settings;
  Observers all;
  auto add = [&](std::unique_ptr<Observer> one) {
    if (one) all.push_back(std::move(one));
  };
  // First the watches, which may refuse the numbers; then the observers that write them down; then
  // those that end the run.
  add(makeEnergyWatch(c));
  add(makeContactWatch(c));
  add(makeFlowWatch(c));
  const bool rubs = c.pairs.rubs() || std::ranges::any_of(c.walls, [](const Wall& w) {
                      return static_cast<bool>(w.friction);
                    });
  add(makeEnergyTable(options, c.units, {rubs, !c.walls.empty(), s.thermostat.has_value()},
                      s.monitorInterval));
  add(makeKindTable(options, c.units, c.kinds, s.monitorInterval));
  add(makeStressTable(options, c.units, c.boundaries, s.monitorInterval));
  add(makeKindStressTable(options, c.units, c.kinds, c.boundaries, s.monitorInterval));
  add(makeBoxTable(options, c.units, c.boxDrive, s.monitorInterval));
  add(makeWallTable(options, c.units, c.walls, s.monitorInterval));
  add(makeGroupTable(options, c.units, c.boundaries, s.monitorInterval));
  add(makeRelaxation(c));
  add(makeBalance(c));
  add(makeProgress(c));
  add(makeSnapshotWriter(s.snapshotFile, s.snapshotInterval, c.units));
  add(makeStepWatch(c));
  add(makeCheckpoints(c));
  add(makeFinalState(c));
  add(makeEnds(c));
  add(makeSignalStop(c));
  add(makeWallTimeStop(c));
  return all;
}

}  // namespace nanoweft
