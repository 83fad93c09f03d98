#include <petscsys.h>

#include <cmath>

#include "nanoweft/app/observers.hpp"

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
    double strain;
    int rank;
  } worst{0, state.rank()};
  struct {
    double strain = 0;
    long long fibre = 0;
    int index = 0;
  } bond;
  for (int i = 0; i < state.owned(); ++i) {
    const double strain = state.extension[i] / kinds[state.kind(i)].length;
    if (std::abs(strain) <= worst.strain) continue;
    worst.strain = std::abs(strain);
    bond = {strain, static_cast<long long>(state.fibre[i]), state.chain[2 * i]};
  }
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_DOUBLE_INT, MPI_MAXLOC, state.comm());
  if (worst.strain <= most) return;
  warned_ = true;
  MPI_Bcast(&bond, sizeof bond, MPI_BYTE, worst.rank, state.comm());
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
