#include <petscsys.h>

#include <cmath>

#include "nanoweft/app/observers.hpp"
#include "nanoweft/base/gather.hpp"

namespace nanoweft {

namespace {

constexpr long interval = 100;
/// Plastic strain of a bond beyond which it warns: contacts go on as if it had its first length.
constexpr double most = 0.5;

class FlowWatch : public Observer {
 public:
  void begin(const Moment& moment) override { look(moment); }
  void observe(const Moment& moment) override {
    if (isDue(moment, interval)) look(moment);
  }

 private:
  void look(const Moment& moment);

  bool warned_ = false;
};

void FlowWatch::look(const Moment& moment) {
  if (warned_) return;
  const State& state = moment.state();
  const Kinds& kinds = moment.system.forces.kinds();
  struct {
    double strain = 0;
    long long fibre = 0;
    int index = 0;
  } bond;
  for (int i = 0; i < state.owned(); ++i)
    if (const double strain = state.extension[i] / kinds[state.kind(i)].length;
        std::abs(strain) > std::abs(bond.strain))
      bond = {strain, static_cast<long long>(state.fibre[i]), state.chain[2 * i]};
  if (largestOfRanks(std::abs(bond.strain), bond, state.comm()) <= most) return;
  warned_ = true;
  PetscPrintf(state.comm(),
              "warning: step %lld: fibre %lld flows, and its bond behind segment %d has a rest "
              "length changed by %.0f %%; contacts and energies are doubtful there\n",
              static_cast<long long>(moment.step()), bond.fibre, bond.index, 100.0 * bond.strain);
}

}  // namespace

std::unique_ptr<Observer> makeFlowWatch(const ObserverContext& context) {
  if (!context.kinds.yields()) return nullptr;
  return std::make_unique<FlowWatch>();
}

}  // namespace nanoweft
