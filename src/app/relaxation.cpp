#include <cmath>

#include "nanoweft/app/observers.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/motion/residual.hpp"

namespace nanoweft {

namespace {

class Relaxation : public Observer {
 public:
  explicit Relaxation(const ObserverContext& context)
      : boxDrive_(context.boxDrive),
        tolerance_(context.settings.relaxTolerance),
        interval_(context.settings.relaxInterval) {}

  void restore(const RunRecord& record) override {
    const auto& elastic = record.needReals("relax_elastic", 2);
    const auto interval = static_cast<double>(interval_);
    restarted_ = true;
    // The last energy serves only if the interval is the same: energies an interval apart count.
    if (elastic[1] == interval) last_ = elastic[0];
    // A run that had converged has nothing to do, unless the restart asks for more.
    if (!record.reals.contains(endName)) return;
    const auto& end = record.needReals(endName, 2);
    converged_ = end[0] <= tolerance_ && end[1] == interval;
  }
  std::string endReached(const Moment& moment) const override {
    return converged_ ? format("had converged at step %lld", static_cast<long long>(moment.step()))
                      : "";
  }
  void begin(const Moment& moment) override {
    if (!restarted_ && tolerance_ > 0) last_ = moment.energies->elastic();
  }
  View view(const Moment& moment) const override {
    return looks(moment) ? View::energies : View::positions;
  }
  void observe(const Moment& moment) override {
    if (!looks(moment)) {
      // Without the option the energy of an earlier run becomes too old to compare with.
      if (isDue(moment, interval_)) last_ = -1;
      return;
    }
    const double elastic = moment.energies->elastic();
    const System& s = moment.system;
    // Without any elastic energy the motion tells whether some may come.
    const bool tells = elastic > 0 || moment.energies->kinetic + moment.energies->rotational == 0;
    const bool landed = s.forces.walls().borne(s.state.comm(), tolerance_);
    converged_ = last_ >= 0 && tells && landed &&
                 std::abs(elastic - last_) <= tolerance_ * elastic &&
                 !stillDriven(s.state, s.forces, s.boundaries) &&
                 !boxDrive_.underWay(s.state.box, s.state.time);
    last_ = elastic;
  }
  Verdict verdict(const Moment&) const override {
    return converged_ ? Verdict::done : Verdict::goOn;
  }
  std::string reason() const override {
    return converged_ ? format(
                            "converged: the elastic energy changed by less than %g of itself in "
                            "%ld steps",
                            tolerance_, interval_)
                      : "";
  }
  void save(RunRecord& record) const override {
    const auto interval = static_cast<double>(interval_);
    record.reals["relax_elastic"] = {last_, interval};
    if (converged_) record.reals[endName] = {tolerance_, interval};
  }

 private:
  static constexpr const char* endName = "ended_by_relax_tolerance";

  bool looks(const Moment& moment) const { return tolerance_ > 0 && isDue(moment, interval_); }

  const BoxDrive& boxDrive_;
  double tolerance_;  ///< 0: never converged
  long interval_;
  bool restarted_ = false, converged_ = false;
  double last_ = -1;  ///< elastic energy at the last look; -1: there was none
};

}  // namespace

std::unique_ptr<Observer> makeRelaxation(const ObserverContext& context) {
  // Made without -relax_tolerance, too: it passes the record of an earlier run on to checkpoints.
  return std::make_unique<Relaxation>(context);
}

}  // namespace nanoweft
