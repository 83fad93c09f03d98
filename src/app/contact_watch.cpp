#include <petscsys.h>

#include <cmath>

#include "nanoweft/app/observers.hpp"
#include "nanoweft/force/overlap.hpp"

namespace nanoweft {

namespace {

constexpr long interval = 100;
/// Overlap in radii beyond which it warns: more than pressed fibres or the quadrature's error give.
constexpr double deepest = 0.1;

class ContactWatch : public Observer {
 public:
  void begin(const Moment& moment) override { look(moment); }
  void observe(const Moment& moment) override {
    if (isDue(moment, interval)) look(moment);
  }

 private:
  void look(const Moment& moment) {
    lookAtPairs(moment);
    lookAtWalls(moment);
  }
  void lookAtPairs(const Moment& moment);
  void lookAtWalls(const Moment& moment);

  bool warned_ = false, warnedOfWalls_ = false;
};

void ContactWatch::lookAtWalls(const Moment& moment) {
  const ForceField& forces = moment.system.forces;
  if (warnedOfWalls_ || !forces.walls()) return;
  const WallForces::Depth d = forces.walls().deepest(moment.state(), forces.nearest());
  if (!(d.radii > deepest)) return;
  warnedOfWalls_ = true;
  PetscPrintf(
      moment.state().comm(),
      "warning: step %lld: fibre %lld segment %d is %.0f %% of a radius deep in the wall %s; "
      "what its law says is doubtful there\n",
      static_cast<long long>(moment.step()), static_cast<long long>(d.fibre), d.index,
      100.0 * d.radii, forces.walls().list()[static_cast<std::size_t>(d.wall)].name.c_str());
}

void ContactWatch::lookAtPairs(const Moment& moment) {
  const ForceField& forces = moment.system.forces;
  if (warned_ || !forces.pairs()) return;
  const Overlap o = deepestOverlap(moment.state(), forces, deepest);
  if (std::isinf(o.depth)) return;
  warned_ = true;
  PetscPrintf(moment.state().comm(),
              "warning: step %lld: fibre %lld segment %d and fibre %lld segment %d overlap by %.0f "
              "%% of a radius; what the pair law says is doubtful there\n",
              static_cast<long long>(moment.step()), static_cast<long long>(o.fibre[0]), o.index[0],
              static_cast<long long>(o.fibre[1]), o.index[1], 100.0 * o.depth);
}

}  // namespace

std::unique_ptr<Observer> makeContactWatch(const ObserverContext&) {
  return std::make_unique<ContactWatch>();
}

}  // namespace nanoweft
