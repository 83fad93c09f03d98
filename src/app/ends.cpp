#include "nanoweft/app/observers.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

class Ends : public Observer {
 public:
  explicit Ends(const ObserverContext& context)
      : steps_(context.settings.maxSteps),
        time_(context.settings.maxTime),
        tension_(context.boundaries.tension()) {}

  std::string endReached(const Moment& moment) const override {
    const double strain = tension_ ? tension_->strain(moment.state().time) : 0.0;
    if (tension_ && tension_->over(moment.state().time))
      return format("had reached a strain of %.4g at step %lld", strain,
                    static_cast<long long>(moment.step()));
    return reached(moment) ? "is at or beyond the end that the options set" : "";
  }
  View view(const Moment& moment) const override {
    return reached(moment) ? View::energies : View::positions;
  }
  Verdict verdict(const Moment& moment) const override {
    return reached(moment) ? Verdict::done : Verdict::goOn;
  }

 private:
  bool reached(const Moment& moment) const {
    const State& s = moment.state();
    if (steps_ && s.step >= *steps_) return true;
    // Half a step of slack against round-off in the sum of steps.
    if (time_ && s.time > *time_ - 0.5 * moment.stepper.dt()) return true;
    return tension_ && tension_->over(s.time);
  }

  std::optional<long> steps_;
  std::optional<double> time_;
  const std::optional<Tension>& tension_;
};

}  // namespace

std::unique_ptr<Observer> makeEnds(const ObserverContext& context) {
  return std::make_unique<Ends>(context);
}

}  // namespace nanoweft
