#include <petscsys.h>

#include <cmath>

#include "nanoweft/app/observers.hpp"

namespace nanoweft {

namespace {

class StepWatch : public Observer {
 public:
  explicit StepWatch(const ObserverContext& context)
      : units_(context.units),
        interval_(context.settings.limitInterval),
        unsafe_(context.settings.unsafeStep) {}

  View view(const Moment& moment) const override {
    return isDue(moment, interval_) ? View::motion : View::positions;
  }
  void observe(const Moment& moment) override;

 private:
  const UnitSystem& units_;
  long interval_;
  bool unsafe_, warned_ = false;
};

void StepWatch::observe(const Moment& moment) {
  if (!isDue(moment, interval_)) return;
  System& s = moment.system;
  const double limit = presentStepLimit(s.state, s.forces, s.domain.halo());
  moment.limits.note(limit);
  if (std::isnan(limit)) {
    if (!warned_)
      PetscPrintf(s.state.comm(),
                  "warning: step %lld: the stable step cannot be estimated: something is more than "
                  "1e5 times as stiff as the bonds\n",
                  static_cast<long long>(moment.step()));
    warned_ = true;
    return;
  }
  Stepper& stepper = moment.stepper;
  if (stepper.adapts()) {
    if (!unsafe_) stepper.limit(adaptedShare * limit);
  } else if (stepper.dt() > limit && !warned_) {
    PetscPrintf(s.state.comm(),
                "warning: step %lld: -ts_dt %g is beyond the stable step of the present state, "
                "%.4g %s\n",
                static_cast<long long>(moment.step()), stepper.dt(), limit, units_.time);
    warned_ = true;
  }
}

}  // namespace

std::unique_ptr<Observer> makeStepWatch(const ObserverContext& context) {
  if (context.settings.limitInterval == 0) return nullptr;
  return std::make_unique<StepWatch>(context);
}

}  // namespace nanoweft
