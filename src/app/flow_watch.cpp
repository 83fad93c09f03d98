#include <petscsys.h>

#include <cmath>

#include "nanoweft/app/observers.hpp"
#include "nanoweft/base/gather.hpp"

namespace nanoweft {

namespace {

constexpr long interval = 100;
/// Plastic strain of a bond beyond which it warns: contacts go on as if it had its first length.
constexpr double most = 0.5;
/// Rest rotation beyond which it warns: at 3 rad flow stops.
constexpr double sharpest = 2.8;

class FlowWatch : public Observer {
 public:
  void begin(const Moment& moment) override { look(moment); }
  void observe(const Moment& moment) override {
    if (isDue(moment, interval)) look(moment);
  }

 private:
  void look(const Moment& moment) {
    lookAtLengths(moment);
    lookAtShapes(moment);
  }
  void lookAtLengths(const Moment& moment);
  void lookAtShapes(const Moment& moment);

  bool longWarned_ = false, sharpWarned_ = false;
};

struct FlowedBond {
  double measure = 0;
  long long fibre = 0;
  int index = 0;
};

/// The bond whose measure is farthest from 0, on all ranks.
template <class Measure>
FlowedBond farthestOf(const State& state, const Measure& measure) {
  FlowedBond bond;
  for (int i = 0; i < state.owned(); ++i)
    if (const double m = measure(i); std::abs(m) > std::abs(bond.measure))
      bond = {m, static_cast<long long>(state.fibre[i]), state.chain[2 * i]};
  largestOfRanks(std::abs(bond.measure), bond, state.comm());
  return bond;
}

void FlowWatch::lookAtLengths(const Moment& moment) {
  if (longWarned_) return;
  const State& state = moment.state();
  const Kinds& kinds = moment.system.forces.kinds();
  const auto bond =
      farthestOf(state, [&](int i) { return state.extension[i] / kinds[state.kind(i)].length; });
  if (std::abs(bond.measure) <= most) return;
  longWarned_ = true;
  PetscPrintf(state.comm(),
              "warning: step %lld: fibre %lld flows, and its bond behind segment %d has a rest "
              "length changed by %.0f %%; contacts and energies are doubtful there\n",
              static_cast<long long>(moment.step()), bond.fibre, bond.index, 100.0 * bond.measure);
}

void FlowWatch::lookAtShapes(const Moment& moment) {
  if (sharpWarned_) return;
  const State& state = moment.state();
  const auto bond = farthestOf(state, [&](int i) {
    const double* rest = state.rest + 3 * i;
    return norm(Vec3d{rest[0], rest[1], rest[2]});
  });
  if (bond.measure <= sharpest) return;
  sharpWarned_ = true;
  PetscPrintf(state.comm(),
              "warning: step %lld: fibre %lld flows, and its bond behind segment %d has a rest "
              "rotation of %.3g rad; at 3 rad it stops to flow and carries more than its yield "
              "moment\n",
              static_cast<long long>(moment.step()), bond.fibre, bond.index, bond.measure);
}

}  // namespace

std::unique_ptr<Observer> makeFlowWatch(const ObserverContext& context) {
  if (!context.kinds.yields()) return nullptr;
  return std::make_unique<FlowWatch>();
}

}  // namespace nanoweft
