#include <algorithm>
#include <cmath>

#include "nanoweft/app/instability.hpp"
#include "nanoweft/app/observers.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// It asks for energies every so many steps, and looks at those that others ask for besides.
constexpr long interval = 100;

class EnergyWatch : public Observer {
 public:
  explicit EnergyWatch(const ObserverContext& context)
      : units_(context.units),
        alarm_(context.settings.energyAlarm),
        booked_(context.boxDrive ? context.boxDrive.interval() : 1),
        thermostat_(context.settings.thermostat) {}

  void begin(const Moment& moment) override {
    began_ = moment.state().time;
    if (!std::isfinite(moment.energies->balance()))
      throw RunError(
          "the energy of the first state is not a finite number: check the fibre's parameters and "
          "the geometry");
  }
  View view(const Moment& moment) const override {
    return isDue(moment, (interval + booked_ - 1) / booked_ * booked_) ? View::energies
                                                                       : View::positions;
  }
  void observe(const Moment& moment) override;

  /// What a thermostat has brought in while it took as much out: kT/2 in each component of
  /// velocity and spin, 2 gamma times a unit of time.
  double turnedOver(const Moment& moment) const {
    if (!thermostat_) return 0;
    return 6.0 * thermostat_->thermal * thermostat_->damping * (moment.state().time - began_) *
           static_cast<double>(moment.state().total());
  }

 private:
  const UnitSystem& units_;
  double alarm_;
  long booked_;  ///< the accounts are whole every so many steps: a driven box books its work so
  std::optional<Thermostat> thermostat_;
  double began_ = 0;
  double available_ = 0;  ///< most energy so far that could turn into motion
};

void EnergyWatch::observe(const Moment& moment) {
  if (!moment.energies) return;
  const Energies &e = *moment.energies, &first = moment.first;
  if (!std::isfinite(e.total())) throwUnstable(moment, units_, "");
  if (alarm_ == 0 || !isDue(moment, booked_)) return;
  // Energy that could turn into motion: the start's own, the work done on the fibres, and what the
  // fibres gained by coming together. The most so far counts, since Verlet's error stays when the
  // motion that made it is over; a thermostat makes new motion all the time. The last term keeps
  // round-off of a scene at rest from an alarm.
  available_ = std::max(available_, first.elastic() + first.kinetic + first.rotational +
                                        std::abs(e.external - first.external) +
                                        std::abs(e.pair - first.pair) + turnedOver(moment) +
                                        1e-9 * moment.system.forces.kinds().energyScale() *
                                            static_cast<double>(moment.state().total()));
  const double risen = e.balance() - first.balance();
  if (risen > alarm_ * available_)
    throwUnstable(moment, units_,
                  format(" and energy has risen by %.3g %s out of nothing", risen, units_.energy));
}

}  // namespace

std::unique_ptr<Observer> makeEnergyWatch(const ObserverContext& context) {
  return std::make_unique<EnergyWatch>(context);
}

}  // namespace nanoweft
