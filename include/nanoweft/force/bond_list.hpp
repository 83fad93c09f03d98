/// The intact bonds of this rank's segments, by thread, and their forces.
#pragma once

#include <optional>
#include <vector>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/fibre/breakage_law.hpp"
#include "nanoweft/force/pair_list.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

struct BondTally {
  ExactSum stretch, shear, bending, torsion;
  ExactSum released;  ///< energy of the bonds that broke
  SumUnit energyUnit;
  std::vector<std::int64_t> broken;  ///< rows of the first segments of bonds that broke just now
  bool someBroke = false;            ///< of the thread's list, also those counted elsewhere
};

class BondList {
 public:
  /// Which of a thread's bonds: those among its own segments, those with other threads' segments,
  /// those with ghosts.
  enum Part { own, shared, outer };

  /// What evaluating bonds takes.
  struct Terms {
    const EvmBond& law;
    const MinimumImage& nearest;
    bool energies, mayBreak;  ///< mayBreak: bonds beyond their critical strain break
  };

  void build(const State& state, const Domain& domain, const std::vector<Share>& shares,
             const std::optional<BreakageLaw>& law);

  /// Adds to force and torque of a thread's segments those of their bonds.
  void add(State& state, const Terms& terms, int thread, Share share, Part part, BondTally& tally);

  /// The thread's own bonds one stretch after the other, for somebody who goes through its
  /// segments: adds those of segments below `end` that have not been added since `rewind`; few are
  /// left for the next time, none when `end` is that of the share.
  void rewind(int thread) { threads_[static_cast<std::size_t>(thread)].next = 0; }
  void addUpTo(State& state, const Terms& terms, int thread, Share share, std::int32_t end,
               BondTally& tally);

  std::int64_t size() const;

 private:
  struct Entry {
    std::int32_t i, j;  ///< j follows i along the fibre
    double critical;
  };
  struct ThreadBonds {
    std::vector<Entry> parts[3];  ///< of the own ones, the higher index rises
    std::size_t next = 0;         ///< of the own ones
  };
  static void dropBroken(std::vector<Entry>& bonds, BondTally& tally);
  void add(State& state, const Terms& terms, Share share, std::vector<Entry>& bonds,
           std::size_t first, std::size_t last, BondTally& tally);

  std::vector<ThreadBonds> threads_;
  bool breakable_ = false;
};

}  // namespace nanoweft
