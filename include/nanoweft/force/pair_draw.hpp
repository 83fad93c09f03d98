/// Draws from the pair list, which has a wide skin, the pairs that the next steps resolve: all that
/// can come within reach before some segment has moved by half a margin.
#pragma once

#include <cstddef>
#include <vector>

#include "nanoweft/force/lane_pairs.hpp"
#include "nanoweft/force/pair_runs.hpp"
#include "nanoweft/force/switch.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

/// The drawn pairs. Near and far pairs cannot leave their side of the range in which fewer
/// quadrature points take over, so every step resolves them without looking at their distance; if
/// they drift out of reach, they add zero. All other pairs form the rim.
struct DrawnPairs {
  LanePairs near, far;        ///< resolved with all points, with fewer points
  std::vector<ListPair> rim;  ///< every step looks at their distance (pair_sift.hpp)
  /// Where near, far and rim pairs of one chunk of the list end. The pairs of a chunk are resolved
  /// together, while its segments are in the cache.
  struct Ends {
    LanePairs::Place near, far;
    std::size_t rim;
  };
  std::vector<Ends> ends;
};

/// Centre distances by which a drawing tells near, far and rim pairs apart.
struct DrawRanges {
  Switch blend;   ///< where fewer points take over; at infinity when they do not
  double reach;   ///< centre distance beyond which a pair has no force
  double margin;  ///< no segment moves farther than half of this until the next drawing
};

void drawPairs(const PairRuns& listed, const double* pose, const MinimumImage& nearest,
               const DrawRanges& ranges, DrawnPairs& drawn);

}  // namespace nanoweft
