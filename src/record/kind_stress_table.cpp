#include "nanoweft/record/kind_stress_table.hpp"

#include "nanoweft/base/error.hpp"
#include "nanoweft/record/carriers.hpp"
#include "nanoweft/record/gage_stress.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

std::vector<std::string> columnsFor(const Kinds& kinds, const UnitSystem& units) {
  std::vector<std::string> columns{timeColumn(units), "strain"};
  for (const std::string& carrier : carrierNames(kinds)) columns.push_back(carrier + "_GPa");
  return columns;
}

class KindStressTable : public TableObserver {
 public:
  KindStressTable(Options& options, const UnitSystem& units, const Kinds& kinds,
                  const Boundaries& boundaries, long interval)
      : TableObserver(options,
                      {.option = "kind_stress_monitor",
                       .help = "axial stress that each kind of fibre carries in a tension test, "
                               "through a viewer: ascii:FILE.csv, draw",
                       .columns = columnsFor(kinds, units),
                       .abscissa = 1,
                       .curves = {2, 3}},
                      interval),
        units_(units),
        boundaries_(boundaries) {
    if (wanted() && kinds[0].kind.empty())
      throw InputError("-kind_stress_monitor: the fibres have no kinds; name them by -kinds");
  }

  void check(const OutputContext& context) const override {
    if (!boundaries_.tension())
      throw InputError("-kind_stress_monitor: there is no tension test; give -tension_rate");
    TableObserver::check(context);
  }

 protected:
  std::vector<double> row(const Moment& moment) override {
    const System& s = moment.system;
    const Tension& tension = *boundaries_.tension();
    std::vector<double> values{s.state.time, tension.strain(s.state.time)};
    for (const double stress : carriedStress(s.state, s.domain, s.forces, tension, units_))
      values.push_back(stress);
    return values;
  }

 private:
  const UnitSystem& units_;
  const Boundaries& boundaries_;
};

}  // namespace

std::unique_ptr<Observer> makeKindStressTable(Options& options, const UnitSystem& units,
                                              const Kinds& kinds, const Boundaries& boundaries,
                                              long interval) {
  auto table = std::make_unique<KindStressTable>(options, units, kinds, boundaries, interval);
  if (!table->wanted()) return nullptr;
  return table;
}

}  // namespace nanoweft
