#include "nanoweft/force/bond_list.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "nanoweft/base/threads.hpp"
#include "nanoweft/force/bond_geometry.hpp"

namespace nanoweft {

void BondList::build(const State& state, const Domain& domain, const std::vector<Share>& shares,
                     const Breakage& breakage) {
  breakable_ = static_cast<bool>(breakage);
  threads_.resize(shares.size());
  onShares(shares.size(), [&](std::size_t t) {
    ThreadBonds& bonds = threads_[t];
    for (auto& part : bonds.parts) part.clear();
    bonds.next = 0;
    auto mine = [&](std::int32_t i) { return i >= shares[t].begin && i < shares[t].end; };
    for (std::int32_t m = shares[t].begin; m < shares[t].end; ++m) {
      // The loop meets a bond of two own segments twice; it is listed at the higher index.
      auto push = [&](std::int32_t i, std::int32_t j) {
        const std::int32_t other = i == m ? j : i;
        if (mine(other) && other > m) return;
        const double critical =
            breakable_ ? breakage.criticalStrain(state.kind(i), state.fibre[i], state.chain[2 * i],
                                                 state.chain[2 * i + 1])
                       : 0.0;
        bonds.parts[mine(other)             ? own
                    : other < state.owned() ? shared
                                            : outer]
            .push_back({i, j, critical});
      };
      for (const Tie& tie : state.ties(m)) {
        if (tie.broken) continue;
        const std::int32_t other = domain.partner(state, m, tie);
        tie.first ? push(m, other) : push(other, m);
      }
    }
  });
}

namespace {

/// Adds the forces and torques of bonds to a thread's segments. The second segment of a bond is
/// mostly the first of the next bond: then its two contributions are summed in a register and
/// written once. A segment has two bonds at most and a + b = b + a, so their order does not matter.
class BondScatter {
 public:
  BondScatter(State& state, Share share) : s_(state), share_(share) {}
  ~BondScatter() { flush(); }

  /// Rows: force, torque, two unused.
  NW_INLINE void add(std::int32_t i, std::int32_t j, const Reals& onI, const Reals& onJ) {
    if (i == last_) {
      // In memory a sum starts from 0, which turns a -0 into 0; the added zero does so here.
      if (mine(i)) put(i, (kept_ + onI) + 0.0);
    } else {
      flush();
      if (mine(i)) addTo(i, onI);
    }
    last_ = j;
    kept_ = onJ;
  }

 private:
  bool mine(std::int32_t i) const { return i >= share_.begin && i < share_.end; }
  void flush() {
    if (last_ >= 0 && mine(last_)) addTo(last_, kept_);
  }
  // Rows are split in registers: through memory, loads of the parts would wait for the whole store.
  typedef double Couple __attribute__((vector_size(16)));
  template <int k>
  NW_INLINE static Couple couple(const Reals& row) {
    return __builtin_shufflevector(row, row, 2 * k, 2 * k + 1);
  }
  NW_INLINE void put(std::int32_t i, const Reals& row) {
    store(i, couple<0>(row), couple<1>(row), couple<2>(row));
  }
  NW_INLINE void addTo(std::int32_t i, const Reals& row) {
    const double *const force = s_.force + 3 * i, *const torque = s_.torque + 3 * i;
    store(i, Couple{force[0], force[1]} + couple<0>(row),
          Couple{force[2], torque[0]} + couple<1>(row),
          Couple{torque[1], torque[2]} + couple<2>(row));
  }
  NW_INLINE void store(std::int32_t i, Couple first, Couple second, Couple third) {
    double *const force = s_.force + 3 * i, *const torque = s_.torque + 3 * i;
    std::memcpy(force, &first, sizeof first);
    force[2] = second[0];
    torque[0] = second[1];
    std::memcpy(torque + 1, &third, sizeof third);
  }

  State& s_;
  Share share_;
  std::int32_t last_ = -1;
  Reals kept_{};
};

/// The bonds' laws where there is one kind of fibre.
struct OneLaw {
  const Kinds& kinds;

  const EvmBond& of(const State&, const std::int32_t*) const { return kinds[0].bond; }
  const EvmBond& of(const State&, std::int32_t) const { return kinds[0].bond; }
};

/// The bonds' laws where segments have kinds, or rest lengths of their own: in each lane that of
/// its first segment.
struct LawByKind {
  const Kinds& kinds;

  EvmBondOf<Lanes> of(const State& state, const std::int32_t* i) const {
    double numbers[5][laneCount];
    for (int k = 0; k < laneCount; ++k) {
      const EvmBond& law = of(state, i[k]);
      numbers[0][k] = state.extension ? law.length + state.extension[i[k]] : law.length;
      numbers[1][k] = law.stretch;
      numbers[2][k] = law.shear;
      numbers[3][k] = law.bending;
      numbers[4][k] = law.torsion;
    }
    auto lanes = [&](int n) { return Lanes(numbers[n], stdx::element_aligned); };
    return {lanes(0), lanes(1), lanes(2), lanes(3), lanes(4)};
  }
  const EvmBond& of(const State& state, std::int32_t i) const { return kinds[state.kind(i)].bond; }
};

/// Bonds that are straight at rest.
struct StraightRest {
  NW_INLINE static void turn(const State&, const std::int32_t*, BondGeometry<Lanes>&) {}
};

/// Bonds with rest rotations.
struct CurvedRest {
  const Kinds& kinds;

  void turn(const State& state, const std::int32_t* i, BondGeometry<Lanes>& bonds) const {
    double half[4][laneCount];
    for (int k = 0; k < laneCount; ++k) {
      const Quatd h = restHalfOf(state, kinds, i[k]);
      half[0][k] = h.w, half[1][k] = h.x, half[2][k] = h.y, half[3][k] = h.z;
    }
    auto lanes = [&](int n) { return Lanes(half[n], stdx::element_aligned); };
    turnToRest(Quat<Lanes>{lanes(0), lanes(1), lanes(2), lanes(3)}, bonds);
  }
};

/// Bonds that do not kink.
struct NoKink {
  template <class Result>
  NW_INLINE static void add(const State&, const std::int32_t*, const BondGeometry<Lanes>&,
                            Result&) {}
};

struct KinkByKind {
  const Kinds& kinds;

  template <class Result>
  void add(const State& state, const std::int32_t* i, const BondGeometry<Lanes>& bonds,
           Result& result) const {
    double angle[laneCount], taken[laneCount];
    for (int k = 0; k < laneCount; ++k) {
      const Kink& kink = kinds[state.kind(i[k])].kink;
      // A kind that does not kink has a stiffness of zero to take.
      angle[k] = kink.angle > 0 ? kink.angle : 1.0;
      taken[k] = kink.taken;
    }
    KinkOf<Lanes>{Lanes(angle, stdx::element_aligned), Lanes(taken, stdx::element_aligned)}.add(
        bonds, result);
  }
};

/// What a bond list needs to know of its bonds' laws.
template <class Law, class Rest, class Kink>
struct Laws {
  Law law;
  Rest rest;
  Kink kink;
};
template <class Law, class Rest, class Kink>
Laws(Law, Rest, Kink) -> Laws<Law, Rest, Kink>;  // clang 16 derives none from an aggregate

}  // namespace

void BondList::add(State& state, const Terms& terms, int thread, Share share, Part part,
                   BondTally& tally) {
  auto& bonds = threads_[static_cast<std::size_t>(thread)].parts[part];
  add(state, terms, share, bonds, 0, bonds.size(), tally);
  dropBroken(bonds, tally);
}

void BondList::addUpTo(State& state, const Terms& terms, int thread, Share share, std::int32_t end,
                       BondTally& tally) {
  ThreadBonds& all = threads_[static_cast<std::size_t>(thread)];
  auto& bonds = all.parts[own];
  std::size_t last = all.next;
  while (last < bonds.size() && std::max(bonds[last].i, bonds[last].j) < end) ++last;
  if (end < share.end) last -= (last - all.next) % laneCount;
  add(state, terms, share, bonds, all.next, last, tally);
  all.next = last;
  if (end == share.end) dropBroken(bonds, tally);
}

void BondList::dropBroken(std::vector<Entry>& bonds, BondTally& tally) {
  if (std::exchange(tally.someBroke, false))
    std::erase_if(bonds, [](const Entry& e) { return e.i < 0; });
}

void BondList::add(State& state, const Terms& terms, Share share, std::vector<Entry>& bonds,
                   std::size_t begin, std::size_t end, BondTally& tally) {
  const Stretch some{{bonds.data() + begin, end - begin}, bonds.data() + bonds.size()};
  auto with = [&](const auto& laws) { addWith(laws, state, terms, share, some, tally); };
  const OneLaw one{terms.kinds};
  const LawByKind byKind{terms.kinds};
  const CurvedRest curved{terms.kinds};
  if (terms.kinds.kinks() || state.extension)
    with(Laws{byKind, curved, KinkByKind{terms.kinds}});
  else if (state.restHalf || terms.kinds.curved())
    terms.kinds.several() ? with(Laws{byKind, curved, NoKink{}})
                          : with(Laws{one, curved, NoKink{}});
  else
    terms.kinds.several() ? with(Laws{byKind, StraightRest{}, NoKink{}})
                          : with(Laws{one, StraightRest{}, NoKink{}});
}

void BondList::breakBond(State& state, const Terms& terms, Share share, Entry& entry,
                         BondTally& tally) {
  auto mine = [&](std::int32_t i) { return i >= share.begin && i < share.end; };
  tally.someBroke = true;
  if (mine(entry.i)) {
    const auto u = bondEnergy(state, terms.kinds, entry.i,
                              bondGeometry(state, terms.kinds, terms.nearest, entry.i, entry.j));
    tally.released.add(u.total(), tally.energyUnit);
    tally.broken.push_back(state.row[entry.i]);
    state.bond[entry.i] |= nextBroken;
  }
  if (mine(entry.j)) state.bond[entry.j] |= previousBroken;
  entry.i = -1;
}

template <class Laws>
void BondList::addWith(const Laws& laws, State& state, const Terms& terms, Share share,
                       const Stretch& stretch, BondTally& tally) {
  const auto& [kinds, nearest, energies, mayBreak] = terms;
  const std::span<Entry> bonds = stretch.bonds;
  BondScatter scatter(state, share);
  for (std::size_t first = 0; first < bonds.size(); first += laneCount) {
    const int used = static_cast<int>(std::min<std::size_t>(laneCount, bonds.size() - first));
    std::int32_t i[laneCount], j[laneCount];
    // Prefetch: segments are stored cell by cell, so those of the next bonds may lie anywhere.
    constexpr std::ptrdiff_t ahead = 32;
    const Entry* const now = bonds.data() + first;
    if (stretch.listEnd - now >= ahead + laneCount)
      for (std::ptrdiff_t k = ahead; k < ahead + laneCount; ++k) {
        const auto next = static_cast<std::size_t>(now[k].j);
        __builtin_prefetch(state.pose + 8 * next);
        __builtin_prefetch(state.force + 3 * next, 1);
        __builtin_prefetch(state.torque + 3 * next, 1);
      }
    for (int k = 0; k < laneCount; ++k) {
      const Entry& e = bonds[first + static_cast<std::size_t>(std::min(k, used - 1))];
      i[k] = e.i;
      j[k] = e.j;
    }
    BondGeometry<Lanes> geometry = bondGeometry(state, nearest, i, j);
    laws.rest.turn(state, i, geometry);
    const auto& law = laws.law.of(state, i);
    BondForce<Lanes> bond = law.force(geometry);
    laws.kink.add(state, i, geometry, bond);
    Row onI[laneCount], onJ[laneCount];
    auto rows = [](const Vec3<Lanes>& force, const Vec3<Lanes>& torque, Row* row) {
      const Lanes v[6] = {force.x, force.y, force.z, torque.x, torque.y, torque.z};
      LaneIntegers column[6];
      std::memcpy(column, v, sizeof column);
      toRows<6>(column, row);
    };
    rows(bond.force, bond.torqueI, onI);
    rows(-bond.force, bond.torqueJ, onJ);
    BondEnergy<Lanes> energy;
    if (energies) {
      energy = law.energy(geometry);
      laws.kink.add(state, i, geometry, energy);
    }
    for (int k = 0; k < used; ++k) {
      const auto lane = static_cast<std::size_t>(k);
      Entry& entry = bonds[first + lane];
      if (breakable_ && mayBreak) {
        const EvmBond& own = laws.law.of(state, i[k]);
        const double strain = (bond.length[lane] - own.length) / own.length;
        if (strain > entry.critical) {
          breakBond(state, terms, share, entry, tally);
          continue;
        }
      }
      scatter.add(i[k], j[k], __builtin_bit_cast(Reals, onI[k]), __builtin_bit_cast(Reals, onJ[k]));
      if (energies && i[k] >= share.begin && i[k] < share.end) {
        tally.stretch.add(energy.stretch[lane], tally.energyUnit);
        tally.shear.add(energy.shear[lane], tally.energyUnit);
        tally.bending.add(energy.bending[lane], tally.energyUnit);
        tally.torsion.add(energy.torsion[lane], tally.energyUnit);
      }
    }
  }
}

std::int64_t BondList::size() const {
  std::int64_t n = 0;
  for (const auto& t : threads_)
    for (const auto& part : t.parts) n += static_cast<std::int64_t>(part.size());
  return n;
}

}  // namespace nanoweft
