#include "nanoweft/record/stress_table.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/base/error.hpp"
#include "nanoweft/record/gage_stress.hpp"
#include "nanoweft/record/grip_stress.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

std::vector<std::string> columnsFor(const Boundaries& boundaries, const UnitSystem& units) {
  std::vector<std::string> columns{timeColumn(units),  "strain",        "stress_left_GPa",
                                   "stress_right_GPa", "broken_bonds",  "virial_xx_GPa",
                                   "virial_yy_GPa",    "virial_zz_GPa", "virial_xy_GPa",
                                   "virial_xz_GPa",    "virial_yz_GPa"};
  if (boundaries.tension() && boundaries.tension()->lateral) columns.push_back("lateral_strain");
  return columns;
}

class StressTable : public TableObserver {
 public:
  StressTable(Options& options, const UnitSystem& units, const Boundaries& boundaries,
              long interval)
      : TableObserver(options,
                      {.option = "stress_monitor",
                       .help = "stress of a tension test through a viewer: ascii:FILE.csv, draw",
                       .columns = columnsFor(boundaries, units),
                       .abscissa = 1,
                       .curves = {2, 3}},
                      interval),
        units_(units),
        boundaries_(boundaries) {}

  void check(const OutputContext& context) const override {
    if (wanted() && !boundaries_.tension())
      throw InputError("-stress_monitor: there is no tension test; give -tension_rate");
    TableObserver::check(context);
  }
  void begin(const Moment& moment) override {
    if (!boundaries_.tension()) return;
    measure(moment);
    TableObserver::begin(moment);
  }
  View view(const Moment& moment) const override {
    if (!boundaries_.tension() || !isDue(moment, interval())) return View::positions;
    return wanted() ? View::energies : View::motion;
  }
  void observe(const Moment& moment) override {
    if (!boundaries_.tension() || !isDue(moment, interval())) return;
    measure(moment);
    TableObserver::observe(moment);
  }
  void finish(const Moment& moment) override {
    if (!boundaries_.tension()) return;
    measure(moment);
    TableObserver::finish(moment);
  }
  void summarise(const Moment& moment) const override;

  // A checkpoint and a stage both carry it.
  void saveStage(RunRecord& record) const override {
    record.reals["tension_strength"] = {strength_};
    record.reals[lowestName] = {lowest_};
  }
  void restore(const RunRecord& record) override { restoreStage(record); }
  void restoreStage(const RunRecord& record) override {
    strength_ = record.needReals("tension_strength", 1)[0];
    // Files of earlier programs lack it.
    if (record.reals.contains(lowestName)) lowest_ = record.needReals(lowestName, 1)[0];
  }

 protected:
  std::vector<double> row(const Moment& moment) override {
    const System& s = moment.system;
    const Tension& tension = *boundaries_.tension();
    std::vector<double> values{s.state.time, tension.strain(s.state.time), grips_[0], grips_[1],
                               static_cast<double>(moment.energies->brokenBonds)};
    const auto virial = gageStress(s.state, s.domain, s.forces, tension, units_);
    values.insert(values.end(), virial.begin(), virial.end());
    if (tension.lateral) values.push_back(spreadAcross(s.state, tension) / tension.spread - 1.0);
    return values;
  }

 private:
  static constexpr const char* lowestName = "tension_lowest_stress";

  void measure(const Moment& moment) {
    grips_ = gripStress(moment.state(), moment.system.forces, *boundaries_.tension(), units_);
    felt_ = std::max({felt_, std::abs(grips_[0]), std::abs(grips_[1])});
    // The strength must not depend on restarts, so a row that is there only because a run ended
    // between two due steps does not count.
    if (!isDue(moment, interval())) return;
    strength_ = std::max(strength_, stress());
    lowest_ = std::min(lowest_, stress());
  }
  double stress() const { return 0.5 * (grips_[0] + grips_[1]); }

  const UnitSystem& units_;
  const Boundaries& boundaries_;
  std::array<double, 2> grips_{};  ///< stress when last looked at, GPa
  /// The largest and the smallest stress of the whole test.
  double strength_ = -std::numeric_limits<double>::infinity(),
         lowest_ = std::numeric_limits<double>::infinity();
  double felt_ = 0;  ///< the largest stress or pressure on a grip of this process
};

void StressTable::summarise(const Moment& moment) const {
  if (!boundaries_.tension()) return;
  const MPI_Comm comm = moment.state().comm();
  const Tension& tension = *boundaries_.tension();
  const bool presses = tension.presses();
  PetscPrintf(comm, "strain %.2f %%, %s %.4g GPa, broken bonds %lld\n",
              100 * tension.strain(moment.state().time), presses ? "largest pressure" : "strength",
              presses ? 0.0 - std::min(lowest_, stress()) : std::max(strength_, stress()),
              static_cast<long long>(moment.energies->brokenBonds));
  // Grips that hold only stray fibres feel nothing but round-off.
  const double area = tension.width * tension.thickness * units_.gigapascal;
  if (felt_ * area < 1e-14 * moment.system.forces.kinds().forceScale())
    PetscPrintf(comm,
                "warning: the grips have felt no force: nothing joins them (-tension_ends says "
                "where the piece ends when stray fibres lie beyond)\n");
}

}  // namespace

std::unique_ptr<Observer> makeStressTable(Options& options, const UnitSystem& units,
                                          const Boundaries& boundaries, long interval) {
  return std::make_unique<StressTable>(options, units, boundaries, interval);
}

}  // namespace nanoweft
