#include "nanoweft/record/segment_fields.hpp"

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/threads.hpp"
#include "nanoweft/force/bond_geometry.hpp"
#include "nanoweft/record/interactions.hpp"

namespace nanoweft {

namespace {

enum Place { strain, stretch, shear, bending, torsion, pair };

std::vector<SegmentField> emptyFields(int segments) {
  std::vector<SegmentField> fields;
  for (const char* name : {"strain", "stretch_energy", "shear_energy", "bending_energy",
                           "torsion_energy", "pair_energy"})
    fields.push_back({name, std::vector<float>(static_cast<std::size_t>(segments))});
  return fields;
}

void setBondFields(const State& state, const Domain& domain, const ForceField& forces, int i,
                   std::vector<SegmentField>& fields) {
  BondEnergy<double> sum;
  auto set = [&](Place place, double value) {
    fields[place].values[static_cast<std::size_t>(i)] = static_cast<float>(value);
  };
  for (const Tie& tie : state.ties(i)) {
    if (tie.broken) continue;
    const int other = domain.partner(state, i, tie);
    const int first = tie.first ? i : other;
    const auto bond =
        bondGeometry(state, forces.kinds(), forces.nearest(), first, tie.first ? other : i);
    const auto u = bondEnergy(state, forces.kinds(), first, bond);
    sum.stretch += 0.5 * u.stretch;
    sum.shear += 0.5 * u.shear;
    sum.bending += 0.5 * u.bending;
    sum.torsion += 0.5 * u.torsion;
    if (tie.first)
      set(strain, norm(bond.separation) / bondLaw(state, forces.kinds(), i).length - 1.0);
  }
  set(stretch, sum.stretch);
  set(shear, sum.shear);
  set(bending, sum.bending);
  set(torsion, sum.torsion);
}

/// Half of a link's energies belongs to each end, as with bonds.
void addLinkFields(const State& state, const ForceField& forces,
                   std::vector<SegmentField>& fields) {
  for (std::size_t k = 0; k < state.links.size(); ++k) {
    if (state.links[k].broken) continue;
    const auto u = forces.links().resolve(state, forces.nearest(), k).energy;
    for (const int i : forces.links().ends(k)) {
      if (i >= state.owned()) continue;
      auto add = [&](Place place, double value) {
        fields[place].values[static_cast<std::size_t>(i)] += static_cast<float>(0.5 * value);
      };
      add(stretch, u.stretch);
      add(shear, u.shear);
      add(bending, u.bending);
      add(torsion, u.torsion);
    }
  }
}

}  // namespace

std::vector<SegmentField> segmentFields(const State& state, const Domain& domain,
                                        const ForceField& forces) {
  auto fields = emptyFields(state.owned());
  std::vector<ExactSum> pairEnergy(forces.pairs() ? fields[pair].values.size() : 0);
  const SumUnit& unit = forces.energyUnit();
  const auto& shares = forces.shares();
#pragma omp parallel for schedule(static, 1) num_threads(teamOf(shares.size()))
  for (std::size_t t = 0; t < shares.size(); ++t) {
    const Share share = shares[t];
    for (int i = share.begin; i < share.end; ++i) setBondFields(state, domain, forces, i, fields);
    forEachPair(state, forces, t, [&](const PairForce& force, const ListPair& p, const Vec3d& d) {
      const double half = 0.5 * resolved(state, force, p, d).energy;
      for (const int k : {p.i, p.j})
        if (k >= share.begin && k < share.end)
          pairEnergy[static_cast<std::size_t>(k)].add(half, unit);
    });
  }
  addLinkFields(state, forces, fields);
  for (std::size_t i = 0; i < pairEnergy.size(); ++i)
    fields[pair].values[i] = static_cast<float>(pairEnergy[i].value(unit));
  return fields;
}

}  // namespace nanoweft
