#include "nanoweft/record/energies.hpp"

namespace nanoweft {

Energies sumEnergies(const State& state, const ForceField& forces, const ForceOutcome& outcome,
                     const EnergyAccounts& accounts) {
  const SumUnit& unit = forces.energyUnit();
  constexpr int count = 13;
  ExactSum sums[count] = {outcome.stretch,
                          outcome.shear,
                          outcome.bending,
                          outcome.torsion,
                          outcome.pair,
                          {},
                          {},
                          accounts.damped,
                          accounts.external,
                          accounts.broken,
                          accounts.friction,
                          outcome.wall,
                          accounts.heat};
  std::int64_t brokenBonds = 0;
  for (int i = 0; i < state.owned(); ++i) {
    const double* v = state.velocity + 3 * i;
    const double* w = state.angular + 3 * i;
    const Fibre& fibre = forces.kinds()[state.kind(i)];
    const double halfMass = 0.5 * fibre.mass, halfInertia = 0.5 * fibre.inertia;
    sums[5].add(halfMass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), unit);
    sums[6].add(halfInertia * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]), unit);
    brokenBonds += (state.bond[i] & nextBroken) != 0;
  }
  for (std::size_t k = 0; k < state.links.size(); ++k)
    brokenBonds += state.links[k].broken && forces.links().ends(k)[0] < state.owned();
  ExactSum::reduce(sums, count, state.comm());
  MPI_Allreduce(MPI_IN_PLACE, &brokenBonds, 1, MPI_INT64_T, MPI_SUM, state.comm());
  Energies e;
  double* const values[count] = {&e.stretch,  &e.shear,      &e.bending, &e.torsion,  &e.pair,
                                 &e.kinetic,  &e.rotational, &e.damped,  &e.external, &e.broken,
                                 &e.friction, &e.walls,      &e.heat};
  for (int k = 0; k < count; ++k) *values[k] = sums[k].value(unit);
  e.walls += forces.walls().kinetic();
  // Steppers book all that viscous forces take out.
  e.damped -= e.friction;
  e.brokenBonds = brokenBonds;
  return e;
}

}  // namespace nanoweft
