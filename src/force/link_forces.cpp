#include "nanoweft/force/link_forces.hpp"

#include <algorithm>
#include <limits>

namespace nanoweft {

LinkForces::LinkForces(const LinkLaws& laws, const Kinds& kinds) : laws_(laws) {
  const double longest = kinds.longest();
  double force = kinds.forceScale(), torque = kinds.energyScale();
  for (const LinkLaw& law : laws) {
    force = std::max(force, law.bond.stretch * longest);
    torque = std::max(torque, law.bond.stretch * longest * longest + law.bond.shear);
  }
  forceUnit_ = SumUnit(force);
  torqueUnit_ = SumUnit(torque);
}

void LinkForces::build(const State& state, const Domain& domain) {
  ends_.clear();
  owned_.clear();
  for (std::size_t k = 0; k < state.links.size(); ++k) {
    auto& ends = ends_.emplace_back();
    for (int side = 0; side < 2; ++side) {
      const auto at = static_cast<std::size_t>(side);
      const int local = domain.localIndex(state.links[k].row[at]);
      // The other end of a broken link may be far from all that this rank knows.
      ends[at] = local >= 0 ? local : std::numeric_limits<int>::max();
      if (ends[at] < state.owned()) owned_.push_back({ends[at], k, side});
    }
  }
  std::ranges::stable_sort(owned_, {}, &End::segment);
}

LinkForces::Action LinkForces::resolve(const State& state, const MinimumImage& nearest,
                                       std::size_t k) const {
  const Link& link = state.links[k];
  const LinkLaw& law = this->law(link);
  const auto [i, j] = ends_[k];
  Action action;
  action.separation = nearest(state.position(j) - state.position(i));
  if (law.spring) {
    const double r = norm(action.separation), longer = r - link.length;
    // Ends that coincide have no direction.
    if (r > 0) action.force.force = (law.bond.stretch * longer / r) * action.separation;
    action.force.length = r;
    action.energy.stretch = 0.5 * law.bond.stretch * longer * longer;
    return action;
  }
  const BondGeometry<double> bond{action.separation, state.orientation(i) * link.frame[0],
                                  state.orientation(j) * link.frame[1]};
  EvmBond own = law.bond;
  own.length = link.length;
  action.force = own.force(bond);
  action.energy = own.energy(bond);
  return action;
}

bool LinkForces::breaks(const Link& link, const Action& action) const {
  const double strain = (action.force.length - link.length) / link.length;
  const LinkLaw& law = this->law(link);
  return strain > law.breakStrain || norm(action.force.force) > law.breakForce;
}

void LinkForces::add(State& state, const MinimumImage& nearest, bool energies, bool mayBreak,
                     BondTally& tally) {
  std::vector<Action> actions(state.links.size());
  tooLong_ = false;
  for (std::size_t k = 0; k < actions.size(); ++k) {
    Link& link = state.links[k];
    if (link.broken) continue;
    actions[k] = resolve(state, nearest, k);
    const bool counts = ends_[k][0] < state.owned();  // for the owner of the first end
    if (mayBreak && breaks(link, actions[k])) {
      if (counts) tally.released.add(actions[k].energy.total(), tally.energyUnit);
      link.broken = 1;
      continue;
    }
    tooLong_ = tooLong_ || nearest.shareOfHalf(actions[k].separation) > mostOfHalf;
    if (energies && counts) {
      tally.stretch.add(actions[k].energy.stretch, tally.energyUnit);
      tally.shear.add(actions[k].energy.shear, tally.energyUnit);
      tally.bending.add(actions[k].energy.bending, tally.energyUnit);
      tally.torsion.add(actions[k].energy.torsion, tally.energyUnit);
    }
  }
  for (std::size_t begin = 0, end = 0; begin < owned_.size(); begin = end) {
    const int i = owned_[begin].segment;
    ExactSum force[3], torque[3];
    for (; end < owned_.size() && owned_[end].segment == i; ++end) {
      const auto& [segment, k, side] = owned_[end];
      if (state.links[k].broken) continue;
      const Vec3d f = side == 0 ? actions[k].force.force : -actions[k].force.force,
                  t = side == 0 ? actions[k].force.torqueI : actions[k].force.torqueJ;
      const double fs[3] = {f.x, f.y, f.z}, ts[3] = {t.x, t.y, t.z};
      for (int c = 0; c < 3; ++c) {
        force[c].add(fs[c], forceUnit_);
        torque[c].add(ts[c], torqueUnit_);
      }
    }
    for (int c = 0; c < 3; ++c) {
      state.force[3 * i + c] += force[c].value(forceUnit_);
      state.torque[3 * i + c] += torque[c].value(torqueUnit_);
    }
  }
}

}  // namespace nanoweft
