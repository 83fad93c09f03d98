#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/app/observers.hpp"
#include "nanoweft/app/wall_time.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

class Progress : public Observer {
 public:
  explicit Progress(const ObserverContext& context)
      : settings_(context.settings), units_(context.units), boundaries_(context.boundaries) {}

  void begin(const Moment& moment) override { note(moment); }
  bool wishes(const Moment& moment) override {
    return moment.state().rank() == 0 && MPI_Wtime() - wall_ > settings_.progressSeconds;
  }
  void hear() override { asked_ = true; }
  View view(const Moment&) const override { return asked_ ? View::energies : View::positions; }
  void observe(const Moment& moment) override {
    if (!asked_) return;
    print(moment);
    note(moment);
    asked_ = false;
  }

 private:
  void note(const Moment& moment) {
    wall_ = MPI_Wtime();
    step_ = moment.step();
  }
  void print(const Moment& moment) const;
  /// Steps to whichever end can be foreseen, or infinity.
  double stepsLeft(const Moment& moment) const;

  const RunSettings& settings_;
  const UnitSystem& units_;
  const Boundaries& boundaries_;
  double wall_ = 0;        ///< of the last line
  std::int64_t step_ = 0;  ///< of the last line
  bool asked_ = false;
};

double Progress::stepsLeft(const Moment& moment) const {
  const State& s = moment.state();
  const double dt = moment.stepper.dt();
  double left = std::numeric_limits<double>::infinity();
  if (settings_.maxSteps) left = static_cast<double>(*settings_.maxSteps - s.step);
  if (settings_.maxTime) left = std::min(left, (*settings_.maxTime - s.time) / dt);
  if (const auto& t = boundaries_.tension()) left = std::min(left, t->timeLeft(s.time) / dt);
  return left;
}

void Progress::print(const Moment& moment) const {
  const State& s = moment.state();
  const Energies& e = *moment.energies;
  const double perStep =
      (MPI_Wtime() - wall_) / static_cast<double>(std::max<std::int64_t>(1, s.step - step_));
  const double perDay = 86400.0 / perStep * moment.stepper.dt() * units_.secondsPerTime * 1e9;
  std::string line = format("step %lld  time %.5g %s  elastic %.6g  pair %.6g  kinetic %.4g %s",
                            static_cast<long long>(s.step), s.time, units_.time, e.elastic(),
                            e.pair, e.kinetic + e.rotational, units_.energy);
  if (const auto& t = boundaries_.tension())
    line += format("  strain %.1f %%  broken %lld", 100 * t->strain(s.time),
                   static_cast<long long>(e.brokenBonds));
  line += format("  %.3g ns/day", perDay);
  if (const double left = stepsLeft(moment); std::isfinite(left))
    line += format("  %s %s", settings_.relaxTolerance > 0 ? "at most" : "left",
                   roundedDuration(left * perStep).c_str());
  PetscPrintf(s.comm(), "%s\n", line.c_str());
}

}  // namespace

std::unique_ptr<Observer> makeProgress(const ObserverContext& context) {
  if (context.settings.progressSeconds == 0) return nullptr;
  return std::make_unique<Progress>(context);
}

}  // namespace nanoweft
