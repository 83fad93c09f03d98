#include "nanoweft/record/energy_table.hpp"

#include "nanoweft/base/log.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

std::vector<std::string> columnsFor(const UnitSystem& units, const ExtraEnergies& extras) {
  std::vector<std::string> columns{timeColumn(units), "stretch", "shear",    "bending",
                                   "torsion",         "pair",    "kinetic",  "rotational",
                                   "total",           "damped",  "external", "broken"};
  if (extras.friction) columns.push_back("friction");
  if (extras.walls) columns.push_back("walls");
  if (extras.heat) columns.push_back("heat");
  return columns;
}

class EnergyTable : public TableObserver {
 public:
  EnergyTable(Options& options, const UnitSystem& units, const ExtraEnergies& extras, long interval)
      : TableObserver(options,
                      {.option = "energy_monitor",
                       .help = "energies through a viewer: ascii:FILE.csv, draw",
                       .columns = columnsFor(units, extras),
                       .abscissa = 0,
                       .curves = {1, 2, 3, 4, 5, 6, 7}},
                      interval),
        extras_(extras) {}

 protected:
  std::vector<double> row(const Moment& moment) override {
    const Energies& e = *moment.energies;
    std::vector<double> row{moment.state().time, e.stretch, e.shear,    e.bending,
                            e.torsion,           e.pair,    e.kinetic,  e.rotational,
                            e.total(),           e.damped,  e.external, e.broken};
    if (extras_.friction) row.push_back(e.friction);
    if (extras_.walls) row.push_back(e.walls);
    if (extras_.heat) row.push_back(e.heat);
    return row;
  }

 private:
  ExtraEnergies extras_;
};

}  // namespace

std::unique_ptr<Observer> makeEnergyTable(Options& options, const UnitSystem& units,
                                          const ExtraEnergies& extras, long interval) {
  auto table = std::make_unique<EnergyTable>(options, units, extras, interval);
  if (!table->wanted()) return nullptr;
  return table;
}

}  // namespace nanoweft
