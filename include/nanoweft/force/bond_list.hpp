/// The bond list: the intact bonds of this rank's segments, sorted by the thread that evaluates
/// them; it adds their forces and drops the bonds that break.
#pragma once

#include <span>
#include <vector>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/pair_list.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

struct BondTally {
  ExactSum stretch, shear, bending, torsion;
  ExactSum released;  ///< energy of the bonds that broke
  SumUnit energyUnit;
  std::vector<std::int64_t> broken;  ///< rows of the first segments of bonds that broke just now
  bool someBroke = false;  ///< in the thread's list; the owner of the first segment counts a break
};

class BondList {
 public:
  /// A thread's bonds by their second owner: both segments are the thread's own, one is another
  /// thread's (shared), or one is a ghost (outer).
  enum Part { own, shared, outer };

  /// What an evaluation of bonds needs.
  struct Terms {
    const Kinds& kinds;
    const MinimumImage& nearest;
    bool energies, mayBreak;  ///< mayBreak: bonds beyond their critical strain break
  };

  void build(const State& state, const Domain& domain, const std::vector<Share>& shares,
             const Breakage& breakage);

  /// Adds the forces and torques of one part of a thread's bonds to the thread's segments.
  void add(State& state, const Terms& terms, int thread, Share share, Part part, BondTally& tally);

  /// For a caller that goes through the thread's segments in order: `addUpTo` adds the thread's own
  /// bonds between segments below `end` that have not been added since `rewind`. It evaluates full
  /// SIMD groups only, so up to laneCount - 1 bonds wait for the next call; none wait when `end` is
  /// the end of the share.
  void rewind(int thread) { threads_[static_cast<std::size_t>(thread)].next = 0; }
  void addUpTo(State& state, const Terms& terms, int thread, Share share, std::int32_t end,
               BondTally& tally);

  std::int64_t size() const;

  /// Calls visit(i, j) with the local indices of each bond of a thread's list; j follows i.
  template <class Visit>
  void forEach(int thread, const Visit& visit) const {
    for (const auto& part : threads_[static_cast<std::size_t>(thread)].parts)
      for (const Entry& e : part) visit(e.i, e.j);
  }

 private:
  struct Entry {
    std::int32_t i, j;  ///< j follows i along the fibre
    double critical;
  };
  struct ThreadBonds {
    std::vector<Entry> parts[3];  ///< by Part; the own bonds ascend by max(i, j), for addUpTo
    std::size_t next = 0;         ///< the first own bond that addUpTo has not added yet
  };
  /// Some consecutive bonds of a list.
  struct Stretch {
    std::span<Entry> bonds;
    const Entry* listEnd;  ///< the thread prefetches segments of bonds up to here
  };
  /// Marks a bond as broken and books its energy, each for the thread that owns the segment.
  static void breakBond(State& state, const Terms& terms, Share share, Entry& entry,
                        BondTally& tally);
  static void dropBroken(std::vector<Entry>& bonds, BondTally& tally);
  void add(State& state, const Terms& terms, Share share, std::vector<Entry>& bonds,
           std::size_t first, std::size_t last, BondTally& tally);
  template <class Laws>
  void addWith(const Laws& laws, State& state, const Terms& terms, Share share,
               const Stretch& stretch, BondTally& tally);

  std::vector<ThreadBonds> threads_;
  bool breakable_ = false;
};

}  // namespace nanoweft
