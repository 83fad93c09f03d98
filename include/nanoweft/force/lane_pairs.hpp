/// Pairs in the order in which the kernel takes them: a SIMD lane has a first segment and meets its
/// partners one after the other, so that a first segment is read, and its sum written, once for
/// many pairs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// First segments, and how many partners each has; the first lane has most.
struct LaneGroup {
  std::int32_t first[laneCount], count[laneCount];

  std::int32_t depth() const { return count[0]; }
};

/// Groups, and their partners: for one group after the other `depth` rows, a lane each. Lanes that
/// have no partner left repeat some pair, which does not count.
struct LaneView {
  std::span<const LaneGroup> groups;
  const std::int32_t *partners, *end;  ///< end: of what may be looked at ahead

  std::int64_t pairs() const;
};

class LanePairs {
 public:
  struct Place {
    std::size_t group, partner;
  };

  void clear();
  /// Takes in a segment with its partners.
  void add(std::int32_t first, std::span<const std::int32_t> partners);
  /// Puts those taken in since the last time into groups. Segments with as many partners go
  /// together, since lanes wait for the longest.
  void arrange();

  Place end() const { return {groups_.size(), partners_.size()}; }
  LaneView between(const Place& begin, const Place& end) const;

 private:
  struct Run {
    std::int32_t first;
    std::size_t begin, count;
  };

  std::vector<LaneGroup> groups_;
  std::vector<std::int32_t> partners_;
  // Not arranged yet:
  std::vector<Run> runs_;
  std::vector<std::int32_t> taken_;
};

}  // namespace nanoweft
