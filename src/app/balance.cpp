#include "nanoweft/app/observers.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/motion/residual.hpp"

namespace nanoweft {

namespace {

/// Steps between looks.
constexpr long interval = 10;

class Balance : public Observer {
 public:
  explicit Balance(const ObserverContext& context)
      : units_(context.units), largest_(context.settings.relaxForce) {}

  void restore(const RunRecord& record) override {
    // A run that had converged has nothing to do, unless the restart asks for a smaller residual.
    if (record.reals.contains(endName)) balanced_ = record.needReals(endName, 1)[0] <= largest_;
  }
  std::string endReached(const Moment& moment) const override {
    return balanced_ ? format("had converged at step %lld", static_cast<long long>(moment.step()))
                     : "";
  }
  // A restart looks only at due steps, as the whole run would, so that it does not end earlier.
  void begin(const Moment& moment) override { observe(moment); }
  View view(const Moment& moment) const override {
    return isDue(moment, interval) ? View::motion : View::positions;
  }
  void observe(const Moment& moment) override {
    if (!isDue(moment, interval)) return;
    const System& s = moment.system;
    if (stillDriven(s.state, s.forces, s.boundaries)) return;
    balanced_ = largestResidual(s.state, s.forces, s.boundaries) <= largest_;
  }
  Verdict verdict(const Moment&) const override {
    return balanced_ ? Verdict::done : Verdict::goOn;
  }
  std::string reason() const override {
    return balanced_ ? format("converged: no force that nothing balances exceeds %g %s", largest_,
                              units_.force)
                     : "";
  }
  void save(RunRecord& record) const override {
    if (balanced_) record.reals[endName] = {largest_};
  }

 private:
  static constexpr const char* endName = "ended_by_relax_force";

  const UnitSystem& units_;
  double largest_;
  bool balanced_ = false;
};

}  // namespace

std::unique_ptr<Observer> makeBalance(const ObserverContext& context) {
  if (context.settings.relaxForce == 0) return nullptr;
  return std::make_unique<Balance>(context);
}

}  // namespace nanoweft
