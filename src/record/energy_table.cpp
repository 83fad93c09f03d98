#include "nanoweft/record/energy_table.hpp"

#include "nanoweft/base/log.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

std::vector<std::string> columnsFor(const UnitSystem& units, bool friction) {
  std::vector<std::string> columns{timeColumn(units), "stretch", "shear",    "bending",
                                   "torsion",         "pair",    "kinetic",  "rotational",
                                   "total",           "damped",  "external", "broken"};
  if (friction) columns.push_back("friction");
  return columns;
}

class EnergyTable : public TableObserver {
 public:
  EnergyTable(Options& options, const UnitSystem& units, bool friction, long interval)
      : TableObserver(options,
                      {.option = "energy_monitor",
                       .help = "energies through a viewer: ascii:FILE.csv, draw",
                       .columns = columnsFor(units, friction),
                       .abscissa = 0,
                       .curves = {1, 2, 3, 4, 5, 6, 7}},
                      interval),
        friction_(friction) {}

 protected:
  std::vector<double> row(const Moment& moment) override {
    const Energies& e = *moment.energies;
    std::vector<double> row{moment.state().time, e.stretch, e.shear,    e.bending,
                            e.torsion,           e.pair,    e.kinetic,  e.rotational,
                            e.total(),           e.damped,  e.external, e.broken};
    if (friction_) row.push_back(e.friction);
    return row;
  }

 private:
  bool friction_;
};

}  // namespace

std::unique_ptr<Observer> makeEnergyTable(Options& options, const UnitSystem& units, bool friction,
                                          long interval) {
  auto table = std::make_unique<EnergyTable>(options, units, friction, interval);
  if (!table->wanted()) return nullptr;
  return table;
}

}  // namespace nanoweft
