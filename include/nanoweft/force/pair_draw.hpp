/// Pairs drawn from a list, for the steps until some segment has moved by half a margin.
#pragma once

#include <cstddef>
#include <vector>

#include "nanoweft/force/lane_pairs.hpp"
#include "nanoweft/force/pair_runs.hpp"
#include "nanoweft/force/switch.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

/// Of the pairs in reach when drawn, those that stay at one side of the range where fewer points
/// take over are resolved without looking at their distance: out of reach they would do no harm.
struct DrawnPairs {
  LanePairs near, far;        ///< with all points, with fewer
  std::vector<ListPair> rim;  ///< the others that may be in reach: to be sifted by their distance
  /// Where all end for one stretch of the list after the other: what belongs to a stretch is
  /// resolved together, since its segments are in the cache.
  struct Ends {
    LanePairs::Place near, far;
    std::size_t rim;
  };
  std::vector<Ends> ends;
};

/// Distances of centres that a drawing goes by.
struct DrawRanges {
  Switch blend;   ///< where fewer points take over; at infinity when they do not
  double reach;   ///< of the forces
  double margin;  ///< no segment moves farther than half of this until the next drawing
};

void drawPairs(const PairRuns& listed, const double* pose, const MinimumImage& nearest,
               const DrawRanges& ranges, DrawnPairs& drawn);

}  // namespace nanoweft
