#include "nanoweft/force/bond_list.hpp"

#include <algorithm>

#include "nanoweft/base/random.hpp"
#include "nanoweft/force/gather.hpp"

namespace nanoweft {

double BreakageLaw::criticalStrain(std::int64_t fibre, std::int32_t index) const {
  // Index 0xffffffff is no segment's: the fibre's own draw.
  const auto counter = perFibre ? 0xffffffffu : static_cast<std::uint32_t>(index);
  return mean + deviation * normalDraw(seed, Purpose::breakage, fibre, counter);
}

void BondList::build(const State& state, const Domain& domain, const std::vector<Share>& shares,
                     const std::optional<BreakageLaw>& law) {
  breakable_ = law.has_value();
  threads_.resize(shares.size());
#pragma omp parallel for schedule(static, 1)
  for (std::size_t t = 0; t < shares.size(); ++t) {
    auto& bonds = threads_[t];
    bonds.inner.clear();
    bonds.outer.clear();
    auto push = [&](std::int32_t i, std::int32_t j) {
      const double critical = law ? law->criticalStrain(state.fibre[i], state.chain[2 * i]) : 0.0;
      (i < state.owned() && j < state.owned() ? bonds.inner : bonds.outer)
          .push_back({i, j, critical});
    };
    for (std::int32_t i = shares[t].begin; i < shares[t].end; ++i) {
      if (const auto next = state.successor(i); next >= 0 && !(state.bond[i] & nextBroken))
        push(i, domain.localIndex(next));
      if (const auto before = state.predecessor(i);
          before >= 0 && !(state.bond[i] & previousBroken)) {
        const std::int32_t j = domain.localIndex(before);
        if (j < shares[t].begin || j >= shares[t].end) push(j, i);
      }
    }
  }
}

void BondList::add(State& state, const BondParameters& parameters, const MinimumImage& nearest,
                   int thread, Share share, bool ghosts, bool energies, bool mayBreak,
                   BondTally& tally) {
  if (!ghosts)
    for (std::size_t k = 3 * static_cast<std::size_t>(share.begin);
         k < 3 * static_cast<std::size_t>(share.end); ++k)
      state.force[k] = state.torque[k] = 0.0;
  auto& threadBonds = threads_[static_cast<std::size_t>(thread)];
  auto& bonds = ghosts ? threadBonds.outer : threadBonds.inner;
  auto mine = [&](std::int32_t i) { return i >= share.begin && i < share.end; };
  bool someBroke = false;
  for (std::size_t first = 0; first < bonds.size(); first += laneCount) {
    const int used = static_cast<int>(std::min<std::size_t>(laneCount, bonds.size() - first));
    std::int32_t i[laneCount], j[laneCount];
    for (int k = 0; k < laneCount; ++k) {
      const Entry& e = bonds[first + static_cast<std::size_t>(std::min(k, used - 1))];
      i[k] = e.i;
      j[k] = e.j;
    }
    const Quat<Lanes> qi = gatherOrientations(state.pose, i),
                      qj = gatherOrientations(state.pose, j);
    const Vec3<Lanes> separation =
        nearest(gatherPositions(state.pose, j) - gatherPositions(state.pose, i));
    const BondForce<Lanes> bond = bondForce(parameters, separation, qi, qj);
    alignas(64) double value[9][laneCount];
    auto store = [&](int row, const Vec3<Lanes>& v) {
      v.x.copy_to(value[row], stdx::element_aligned);
      v.y.copy_to(value[row + 1], stdx::element_aligned);
      v.z.copy_to(value[row + 2], stdx::element_aligned);
    };
    store(0, bond.force);
    store(3, bond.torqueI);
    store(6, bond.torqueJ);
    BondEnergy<Lanes> energy;
    if (energies) energy = bondEnergy(parameters, separation, qi, qj);
    for (int k = 0; k < used; ++k) {
      const auto lane = static_cast<std::size_t>(k);
      Entry& entry = bonds[first + lane];
      if (breakable_ && mayBreak) {
        const double strain = (bond.length[lane] - parameters.length) / parameters.length;
        if (strain > entry.critical) {
          someBroke = true;
          if (mine(i[k])) {
            const auto u =
                bondEnergy(parameters, nearest(state.position(j[k]) - state.position(i[k])),
                           state.orientation(i[k]), state.orientation(j[k]));
            tally.released.add(u.stretch + u.shear + u.bending + u.torsion, tally.energyUnit);
            tally.broken.push_back(state.row[i[k]]);
            state.bond[i[k]] |= nextBroken;
          }
          if (mine(j[k])) state.bond[j[k]] |= previousBroken;
          entry.i = -1;
          continue;
        }
      }
      // A segment has two bonds at most, and a + b = b + a: the order of the bonds does not matter.
      if (mine(i[k]))
        for (int c = 0; c < 3; ++c) {
          state.force[3 * i[k] + c] += value[c][k];
          state.torque[3 * i[k] + c] += value[3 + c][k];
        }
      if (mine(j[k]))
        for (int c = 0; c < 3; ++c) {
          state.force[3 * j[k] + c] -= value[c][k];
          state.torque[3 * j[k] + c] += value[6 + c][k];
        }
      if (energies && mine(i[k])) {
        tally.stretch.add(energy.stretch[lane], tally.energyUnit);
        tally.shear.add(energy.shear[lane], tally.energyUnit);
        tally.bending.add(energy.bending[lane], tally.energyUnit);
        tally.torsion.add(energy.torsion[lane], tally.energyUnit);
      }
    }
  }
  if (someBroke) std::erase_if(bonds, [](const Entry& e) { return e.i < 0; });
}

std::int64_t BondList::size() const {
  std::int64_t n = 0;
  for (const auto& t : threads_) n += static_cast<std::int64_t>(t.inner.size() + t.outer.size());
  return n;
}

}  // namespace nanoweft
