/// Draws from the pair list, which has a wide skin, the pairs that the next steps resolve: all that
/// can come within reach before some segment has moved by half a margin.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "nanoweft/base/both.hpp"
#include "nanoweft/force/lane_pairs.hpp"
#include "nanoweft/force/pair_runs.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

/// Chunks begin <= k < end of the drawn pairs, as far as there are so many.
struct Chunks {
  std::size_t begin = 0, end = std::numeric_limits<std::size_t>::max();
};

/// The drawn pairs. Every step resolves those inside without looking at their distance; if they
/// drift out of reach, they add zero. Those that may be on either side form the rim. Pairs that the
/// near part of a split law may act on are drawn besides, or instead (NearRange::alone).
struct DrawnPairs {
  LanePairs inside;
  std::vector<ListPair> rim;  ///< every step looks at their distance (pair_sift.hpp)
  LanePairs near;
  /// Where the pairs of one chunk of the list end. They are resolved together, while the chunk's
  /// segments are in the cache.
  struct Ends {
    LanePairs::Place inside, near;
    std::size_t rim;
  };
  std::vector<Ends> ends;

  Ends begin(std::size_t chunk) const { return chunk > 0 ? ends[chunk - 1] : Ends{}; }
  /// Those of the chunks that there are.
  Chunks existing(Chunks chunks) const { return {chunks.begin, std::min(chunks.end, ends.size())}; }
};

/// Places of the outermost points of two segments, from the centres.
inline Both<double> outermost(Both<int> points, Both<double> length) {
  return {0.5 * length.i * (points.i - 1) / points.i, 0.5 * length.j * (points.j - 1) / points.j};
}

/// The near part of a law that is split: it acts between points, up to a distance.
struct NearRange {
  double cutoff = 0;  ///< 0: the law is not split
  Both<int> points = 0;
  Both<double> length = 0;  ///< of the segments
  bool alone = false;       ///< are near pairs neither inside nor in the rim?

  Both<double> span() const { return outermost(points, length); }
};

struct DrawRanges {
  double reach;   ///< centre distance beyond which a pair has no force
  double margin;  ///< no point of a segment moves farther than half of this until the next drawing
  NearRange near;
};

void drawPairs(const PairRuns& listed, const double* pose, const MinimumImage& nearest,
               const DrawRanges& ranges, DrawnPairs& drawn);

}  // namespace nanoweft
