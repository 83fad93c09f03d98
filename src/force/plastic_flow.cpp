#include "nanoweft/force/plastic_flow.hpp"

#include "nanoweft/force/bond_geometry.hpp"

namespace nanoweft {

namespace {

/// A rest rotation beyond pi would be one the other way round, so folds stop short of it.
constexpr double sharpestRest = 3.0;

}  // namespace

void PlasticFlow::flow(State& state, const BondList& bonds, int thread, Share share) {
  bonds.forEach(thread, [&](int i, int j) {
    const bool mine = i >= share.begin && i < share.end;
    if ((mine || i >= state.owned()) && kinds_[state.kind(i)].yield) flow(state, i, j);
  });
}

void PlasticFlow::flow(State& state, int i, int j) {
  const Yield& yield = kinds_[state.kind(i)].yield;
  const BondGeometry<double> before = bondGeometry(state, kinds_, nearest_, i, j);
  const double longer =
      yield.flowOfLength(norm(before.separation) - bondLaw(state, kinds_, i).length);
  const Vec3d turn = yield.flowOfShape(before);
  if (longer == 0 && norm(turn) == 0) return;
  const double energy = bondEnergy(state, kinds_, i, before).total();
  state.extension[i] += longer;
  // Both ends have taken half of the rest rotation, so the flow is inserted between the halves.
  const Quatd half = restHalfOf(state, kinds_, i);
  const Vec3d rest = rotationVector(half * rotation(turn) * half);
  if (norm(turn) > 0 && norm(rest) < sharpestRest) setRest(state, i, rest);
  const BondGeometry<double> after = bondGeometry(state, kinds_, nearest_, i, j);
  if (i < state.owned()) lost_.add(energy - bondEnergy(state, kinds_, i, after).total(), unit_);
}

}  // namespace nanoweft
