#include "nanoweft/force/lane_pairs.hpp"

#include <algorithm>

namespace nanoweft {

std::int64_t LaneView::pairs() const {
  std::int64_t sum = 0;
  for (const LaneGroup& g : groups)
    for (const std::int32_t n : g.count) sum += n;
  return sum;
}

void LanePairs::clear() {
  groups_.clear();
  partners_.clear();
}

void LanePairs::add(std::int32_t first, std::span<const std::int32_t> partners) {
  if (partners.empty()) return;
  runs_.push_back({first, taken_.size(), partners.size()});
  taken_.insert(taken_.end(), partners.begin(), partners.end());
}

void LanePairs::arrange() {
  // Counting sort by falling number of partners.
  std::size_t most = 0;
  for (const Run& r : runs_) most = std::max(most, r.count);
  std::vector<std::size_t> place(most + 1, 0);
  for (const Run& r : runs_) ++place[most - r.count];
  for (std::size_t k = 0, before = 0; k <= most; ++k) before += std::exchange(place[k], before);
  std::vector<Run> sorted(runs_.size());
  for (const Run& r : runs_) sorted[place[most - r.count]++] = r;

  for (std::size_t k = 0; k < sorted.size(); k += laneCount) {
    const std::size_t depth = sorted[k].count, begin = partners_.size();
    partners_.resize(begin + depth * laneCount);
    LaneGroup group;
    for (std::size_t lane = 0; lane < laneCount; ++lane) {
      const Run& run = sorted[std::min(k + lane, sorted.size() - 1)];
      const std::size_t count = k + lane < sorted.size() ? run.count : 0;
      group.first[lane] = run.first;
      group.count[lane] = static_cast<std::int32_t>(count);
      const std::int32_t* from = &taken_[run.begin];
      std::int32_t* to = &partners_[begin + lane];
      // Neighbouring lanes have partners in common. Lanes that add to the same partner in one row
      // would wait for each other, so each lane begins at another of its partners.
      const std::size_t turn = lane * count / laneCount;
      for (std::size_t n = 0; n < depth; ++n, to += laneCount)
        *to = n >= count ? from[0] : from[n + turn < count ? n + turn : n + turn - count];
    }
    groups_.push_back(group);
  }
  runs_.clear();
  taken_.clear();
}

LaneView LanePairs::between(const Place& begin, const Place& end) const {
  return {{groups_.data() + begin.group, end.group - begin.group},
          partners_.data() + begin.partner,
          partners_.data() + partners_.size()};
}

}  // namespace nanoweft
