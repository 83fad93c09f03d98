#include <algorithm>
#include <cmath>

#include "nanoweft/app/instability.hpp"
#include "nanoweft/app/observers.hpp"
#include "nanoweft/app/round_off.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// It asks for energies every so many steps. Of those that others ask for it looks at no more than
/// whether they are numbers.
constexpr long interval = 100;

class EnergyWatch : public Observer {
 public:
  explicit EnergyWatch(const ObserverContext& context)
      : units_(context.units),
        alarm_(context.settings.energyAlarm),
        // A minimiser chooses its steps itself.
        dt_(context.settings.minimises() ? std::nullopt : context.settings.dt),
        box_(context.boxDrive),
        booked_(context.boxDrive ? context.boxDrive.interval() : 1),
        thermostat_(context.settings.thermostat) {}

  void begin(const Moment& moment) override {
    requireSums(moment);
    if (!std::isfinite(moment.energies->balance()))
      throw RunError(
          "the energy of the first state is not a finite number: check the fibre's parameters and "
          "the geometry");
    if (goesOn_) return;
    const Energies& first = moment.first;
    start_ = {first.balance(), first.elastic() + first.kinetic + first.rotational, first.external,
              first.pair, moment.state().time};
  }
  void restore(const RunRecord& record) override {
    // Whoever goes on with another step judges that one. Checkpoints of earlier programs lack the
    // record.
    const bool otherStep = dt_ && *dt_ != record.needReals("time_step", 1)[0];
    if (otherStep || !record.reals.contains(name)) return;
    const auto& r = record.needReals(name, 6);
    start_ = {r[0], r[1], r[2], r[3], r[4]};
    available_ = r[5];
    goesOn_ = true;
  }
  void save(RunRecord& record) const override {
    record.reals[name] = {start_.balance, start_.own,  start_.external,
                          start_.pair,    start_.time, available_};
  }
  View view(const Moment& moment) const override {
    return looks(moment) ? View::energies : View::positions;
  }
  void observe(const Moment& moment) override;
  void finish(const Moment& moment) override {
    // A run that goes on from here does not look at this step: nothing is kept of it.
    if (moved_ && moment.energies && judges(moment)) judge(moment, availableAt(moment));
  }

 private:
  static constexpr const char* name = "energy_watch";

  /// What a thermostat has brought in while it took as much out: kT/2 in each component of
  /// velocity and spin, 2 gamma times a unit of time.
  double turnedOver(const Moment& moment) const {
    if (!thermostat_) return 0;
    return 6.0 * thermostat_->thermal * thermostat_->damping * (moment.state().time - start_.time) *
           static_cast<double>(moment.state().total());
  }
  /// Most energy so far that could turn into motion, with that of now.
  double availableAt(const Moment& moment) const;
  void judge(const Moment& moment, double available) const;
  bool judges(const Moment& moment) const { return alarm_ != 0 && isDue(moment, booked_); }
  bool looks(const Moment& moment) const {
    return isDue(moment, (interval + booked_ - 1) / booked_ * booked_);
  }
  static void requireSums(const Moment& moment) {
    const Energies& e = *moment.energies;
    if (std::isfinite(e.pair) || !std::isfinite(e.elastic() + e.kinetic + e.rotational)) return;
    throw RunError(beyondSumsText(moment.state().step));
  }

  const UnitSystem& units_;
  double alarm_;
  std::optional<double> dt_;
  const BoxDrive& box_;
  long booked_;  ///< the accounts are whole every so many steps: a driven box books its work so
  std::optional<Thermostat> thermostat_;
  /// What the run started with: energy balance, elastic energy and that of motion, accounts, time.
  struct {
    double balance, own, external, pair, time;
  } start_{};
  bool moved_ = false;    ///< has it made a step?
  bool goesOn_ = false;   ///< a restart that has what the run started with
  double available_ = 0;  ///< most energy so far that could turn into motion
};

void EnergyWatch::observe(const Moment& moment) {
  moved_ = true;
  if (!moment.energies) return;
  const Energies& e = *moment.energies;
  requireSums(moment);
  if (!std::isfinite(e.total())) throwUnstable(moment, units_);
  // At its own steps alone: others look when the clock says so, or as often as a table asks.
  if (!looks(moment) || !judges(moment)) return;
  available_ = availableAt(moment);
  judge(moment, available_);
}

double EnergyWatch::availableAt(const Moment& moment) const {
  const Energies& e = *moment.energies;
  // The start's own, the work done on the fibres (by a box, both ways), and what the fibres gained
  // by coming together. The most so far counts, since Verlet's error stays when the motion that
  // made it is over; a thermostat makes new motion all the time. The last term keeps round-off of a
  // scene at rest from an alarm.
  return std::max(available_,
                  start_.own + std::abs(e.external - start_.external) +
                      std::abs(e.pair - start_.pair) + turnedOver(moment) + box_.turnedOver() +
                      roundOff(moment.system.forces.kinds(), moment.state().total(), start_.pair));
}

void EnergyWatch::judge(const Moment& moment, double available) const {
  const double risen = moment.energies->balance() - start_.balance;
  if (risen > alarm_ * available)
    throwUnstable(moment, units_,
                  format(" and energy has risen by %.3g %s out of nothing", risen, units_.energy),
                  remedyOfDrift(box_));
}

}  // namespace

std::unique_ptr<Observer> makeEnergyWatch(const ObserverContext& context) {
  return std::make_unique<EnergyWatch>(context);
}

}  // namespace nanoweft
