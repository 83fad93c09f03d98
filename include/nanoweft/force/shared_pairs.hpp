/// Pairs of two threads' segments that one of the two resolves for both. It sums their forces in
/// records of its own, which the owners of the segments add to theirs when all threads are done.
#pragma once

#include <cstdint>
#include <vector>

#include "nanoweft/force/pair_draw.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/sums.hpp"

namespace nanoweft {

/// The owned segments of one thread: begin <= i < end.
struct Share {
  std::int32_t begin = 0, end = 0;

  bool holds(std::int32_t i) const { return i >= begin && i < end; }
};

class SharedPairs {
 public:
  /// The pairs, of segments below `owned`.
  void set(const FoundPairs& pairs, int owned);
  std::size_t pairs() const { return listed_.pairs(); }

  /// Resolves the pairs for the thread of `job`, whose segments and sums are replaced by those
  /// here; draws them before unless `margin` is 0.
  void add(const PairForce& force, PairJob job, double margin, bool energies, PairTally& tally);
  /// Moves the sums on the segments of a share to `sums`, the records of all segments.
  void giveTo(const Share& share, ForceSum* sums);
  /// Forgets the sums.
  void clear();

 private:
  struct alignas(64) Pose {
    double at[8];
  };

  /// The segments of the pairs, ascending. What follows numbers them by their places here, so that
  /// it takes no more memory than they need.
  std::vector<std::int32_t> segments_;
  PairRuns listed_;
  DrawnPairs drawn_;
  std::vector<Pose> poses_;
  std::vector<ForceSum> sums_;
};

}  // namespace nanoweft
