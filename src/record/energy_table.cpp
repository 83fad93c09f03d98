#include "nanoweft/record/energy_table.hpp"

#include "nanoweft/base/log.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

class EnergyTable : public TableObserver {
 public:
  EnergyTable(Options& options, const UnitSystem& units, long interval)
      : TableObserver(
            options,
            {.option = "energy_monitor",
             .help = "energies through a viewer: ascii:FILE.csv, draw",
             .columns = {timeColumn(units), "stretch", "shear", "bending", "torsion", "pair",
                         "kinetic", "rotational", "total", "damped", "external", "broken"},
             .abscissa = 0,
             .curves = {1, 2, 3, 4, 5, 6, 7}},
            interval) {}

 protected:
  std::vector<double> row(const Moment& moment) override {
    const Energies& e = *moment.energies;
    return {moment.state().time, e.stretch,    e.shear,   e.bending, e.torsion,  e.pair,
            e.kinetic,           e.rotational, e.total(), e.damped,  e.external, e.broken};
  }
};

}  // namespace

std::unique_ptr<Observer> makeEnergyTable(Options& options, const UnitSystem& units,
                                          long interval) {
  auto table = std::make_unique<EnergyTable>(options, units, interval);
  if (!table->wanted()) return nullptr;
  return table;
}

}  // namespace nanoweft
