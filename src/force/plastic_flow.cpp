#include "nanoweft/force/plastic_flow.hpp"

#include <cmath>

#include "nanoweft/force/bond_geometry.hpp"

namespace nanoweft {

namespace {

/// A rest rotation beyond pi would be one the other way round, so folds stop short of it.
constexpr double sharpestRest = 3.0;
/// Of an energy, in differences of energies.
constexpr double roundOff = 1e-9;

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
  const double extension = state.extension[i];
  const double* shape = state.rest + 3 * i;
  const Vec3d rest{shape[0], shape[1], shape[2]};
  state.extension[i] += longer;
  // Both ends have taken half of the rest rotation, so the flow is inserted between the halves.
  const Quatd half = restHalfOf(state, kinds_, i);
  const Quatd whole = half * rotation(turn) * half;
  // The cosine of half the angle tells on which side of pi that is, which its vector does not.
  if (norm(turn) > 0 && whole.w > std::cos(0.5 * sharpestRest))
    setRest(state, i, rotationVector(whole));
  const BondGeometry<double> after = bondGeometry(state, kinds_, nearest_, i, j);
  const double lost = energy - bondEnergy(state, kinds_, i, after).total();
  // In a bond that is twisted far the halves turn its frames out of line, which may cost more.
  if (lost < -roundOff * energy) {
    state.extension[i] = extension;
    setRest(state, i, rest);
    return;
  }
  if (i < state.owned()) lost_.add(lost, unit_);
}

}  // namespace nanoweft
