/// The intact bonds of this rank's segments, by thread, and their forces.
#pragma once

#include <optional>
#include <vector>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/force/pair_list.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// When bonds break (physics.md 7): at a strain drawn from a normal distribution by (seed, fibre,
/// index).
struct BreakageLaw {
  double mean = 0.3, deviation = 0.05;
  std::uint64_t seed = 1;
  bool perFibre = false;  ///< one draw per fibre instead of one per bond

  /// Critical strain of the bond from segment `index` of `fibre` to its successor.
  double criticalStrain(std::int64_t fibre, std::int32_t index) const;
};

struct BondTally {
  ExactSum stretch, shear, bending, torsion;
  ExactSum released;  ///< energy of the bonds that broke
  SumUnit energyUnit;
  std::vector<std::int64_t> broken;  ///< rows of the first segments of bonds that broke just now
};

class BondList {
 public:
  void build(const State& state, const Domain& domain, const std::vector<Share>& shares,
             const std::optional<BreakageLaw>& law);

  /// Thread t sets force and torque of its segments to those of their bonds, or with `ghosts` adds
  /// those of the bonds to ghosts. Bonds beyond their critical strain break when `mayBreak`.
  void add(State& state, const BondParameters& bond, const MinimumImage& nearest, int thread,
           Share share, bool ghosts, bool energies, bool mayBreak, BondTally& tally);

  std::int64_t size() const;

 private:
  struct Entry {
    std::int32_t i, j;  ///< j follows i along the fibre
    double critical;
  };
  struct ThreadBonds {
    std::vector<Entry> inner, outer;
  };
  std::vector<ThreadBonds> threads_;
  bool breakable_ = false;
};

}  // namespace nanoweft
