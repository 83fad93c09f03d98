#include "nanoweft/record/box_table.hpp"

#include "nanoweft/base/error.hpp"
#include "nanoweft/record/gage_stress.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

class BoxTable : public TableObserver {
 public:
  BoxTable(Options& options, const UnitSystem& units, BoxDrive& drive, long interval)
      : TableObserver(options,
                      {.option = "box_monitor",
                       .help = "strain and stress of the periodic box through a viewer: "
                               "ascii:FILE.csv, draw",
                       .columns = columns(units, drive),
                       .abscissa = 0,
                       .curves = {4, 5, 6}},
                      interval),
        units_(units),
        drive_(drive) {}

  /// The run measures the stress for the drive where all forces are known.
  View view(const Moment& moment) const override {
    return drive_ && isDue(moment, drive_.interval()) ? View::energies
                                                      : TableObserver::view(moment);
  }
  void save(RunRecord& record) const override { drive_.save(record); }
  void check(const OutputContext& context) const override {
    if (wanted() && context.open)
      throw InputError(
          "-box_monitor: the box is open in all directions (-domain_periodic), so it has no "
          "stress");
    TableObserver::check(context);
  }

 protected:
  std::vector<double> row(const Moment& moment) override {
    const System& s = moment.system;
    std::vector<double> values{s.state.time};
    for (const double strain : drive_.strains(s.state.box)) values.push_back(strain);
    const auto stress = boxStress(s.state, s.domain, s.forces, drive_.volume(s.state.box), units_);
    values.insert(values.end(), stress.begin(), stress.begin() + 6);
    if (drive_.shears()) values.push_back(drive_.shear());
    return values;
  }

 private:
  static std::vector<std::string> columns(const UnitSystem& units, const BoxDrive& drive) {
    std::vector<std::string> names{timeColumn(units), "strain_x", "strain_y", "strain_z", "xx_GPa",
                                   "yy_GPa",          "zz_GPa",   "xy_GPa",   "xz_GPa",   "yz_GPa"};
    if (drive.shears()) names.push_back(std::string("strain_") + drive.shears());
    return names;
  }

  const UnitSystem& units_;
  BoxDrive& drive_;
};

}  // namespace

std::unique_ptr<Observer> makeBoxTable(Options& options, const UnitSystem& units, BoxDrive& drive,
                                       long interval) {
  auto table = std::make_unique<BoxTable>(options, units, drive, interval);
  if (!table->wanted() && !drive) return nullptr;
  return table;
}

}  // namespace nanoweft
