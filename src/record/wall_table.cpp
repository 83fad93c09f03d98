#include "nanoweft/record/wall_table.hpp"

#include "nanoweft/base/error.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

std::vector<std::string> columnsFor(const Walls& walls, const UnitSystem& units) {
  std::vector<std::string> columns{timeColumn(units)};
  for (const Wall& w : walls)
    for (const char* quantity : {"force", "torque", "way"})
      for (const char* axis : {"x", "y", "z"})
        columns.push_back(w.name + "_" + quantity + "_" + axis);
  return columns;
}

class WallTable : public TableObserver {
 public:
  WallTable(Options& options, const UnitSystem& units, const Walls& walls, long interval)
      : TableObserver(options,
                      {.option = "wall_monitor",
                       .help = "forces and torques of the fibres on walls, and the walls' ways, "
                               "through a viewer: ascii:FILE.csv, draw",
                       .columns = columnsFor(walls, units),
                       .abscissa = 0,
                       .curves = {1}},
                      interval) {
    if (wanted() && walls.empty()) throw InputError("-wall_monitor: there are no -walls");
  }

 protected:
  std::vector<double> row(const Moment& moment) override {
    const WallForces& walls = moment.system.forces.walls();
    const std::vector<double> felt = walls.felt(moment.state().comm());
    std::vector<double> values{moment.state().time};
    for (std::size_t w = 0; w < walls.list().size(); ++w) {
      values.insert(values.end(), felt.begin() + static_cast<std::ptrdiff_t>(9 * w),
                    felt.begin() + static_cast<std::ptrdiff_t>(9 * w + 6));
      const Vec3d& way = walls.list()[w].moved;
      values.insert(values.end(), {way.x, way.y, way.z});
    }
    return values;
  }
};

}  // namespace

std::unique_ptr<Observer> makeWallTable(Options& options, const UnitSystem& units,
                                        const Walls& walls, long interval) {
  auto table = std::make_unique<WallTable>(options, units, walls, interval);
  if (!table->wanted()) return nullptr;
  return table;
}

}  // namespace nanoweft
