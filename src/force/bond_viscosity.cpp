#include "nanoweft/force/bond_viscosity.hpp"

#include "nanoweft/force/bond_geometry.hpp"

namespace nanoweft {

void addBondViscosity(State& state, const Kinds& kinds, const MinimumImage& nearest,
                      const BondList& bonds, int thread, Share share) {
  auto add = [&](int i, const Vec3d& force, const Vec3d& torque) {
    if (i < share.begin || i >= share.end) return;
    const double parts[6] = {force.x, force.y, force.z, torque.x, torque.y, torque.z};
    for (int c = 0; c < 6; ++c) state.viscous[6 * i + c] += parts[c];
  };
  bonds.forEach(thread, [&](int i, int j) {
    const BondViscosity& law = kinds[state.kind(i)].viscosity;
    if (!law) return;
    const auto bond = law.force(bondGeometry(state, kinds, nearest, i, j),
                                {triple(state.velocity, i), triple(state.velocity, j),
                                 triple(state.angular, i), triple(state.angular, j)});
    add(i, bond.force, bond.torqueI);
    add(j, -bond.force, bond.torqueJ);
  });
}

}  // namespace nanoweft
