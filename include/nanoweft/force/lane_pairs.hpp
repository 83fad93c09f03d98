/// Pairs in the order in which the SIMD pair kernel takes them: each lane keeps one first segment
/// and goes through its partners one after the other. The kernel then reads a first segment, and
/// writes the force on it, once for many pairs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// The first segments of the lanes, and how many partners each has. The first lane has most.
struct LaneGroup {
  std::int32_t first[laneCount], count[laneCount];

  std::int32_t depth() const { return count[0]; }
};

/// Groups and their partners. The partners of one group are `depth` rows of `laneCount` indices, a
/// column a lane. Where a lane has no partner left, its column is padded with some partner; the
/// kernel leaves out the padding.
struct LaneView {
  std::span<const LaneGroup> groups;
  const std::int32_t *partners, *end;  ///< end: the kernel prefetches partners up to here

  std::int64_t pairs() const;
};

class LanePairs {
 public:
  struct Place {
    std::size_t group, partner;
  };

  void clear();
  /// Reserves memory for so many pairs, of which only what is used becomes resident.
  void reserve(std::size_t pairs) { partners_.reserve(pairs + pairs / 8); }
  /// Stores a first segment and its partners until `arrange`.
  void add(std::int32_t first, std::span<const std::int32_t> partners);
  /// Puts the segments added since the last call into groups. Segments with about as many partners
  /// share a group, since a group takes as long as its longest lane.
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
  // Added and not arranged yet: first segments, and the partners of all of them.
  std::vector<Run> runs_;
  std::vector<std::int32_t> taken_;
};

}  // namespace nanoweft
