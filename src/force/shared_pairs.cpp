#include "nanoweft/force/shared_pairs.hpp"

#include <algorithm>
#include <cstring>

namespace nanoweft {

void SharedPairs::set(const FoundPairs& pairs, int owned) {
  segments_.clear();
  if (pairs.empty()) return;
  std::vector<std::int32_t> place(static_cast<std::size_t>(owned), -1);
  auto placeOf = [&](std::int32_t i) -> std::int32_t& {
    return place[static_cast<std::size_t>(i)];
  };
  pairs.forEach([&](const ListPair& p) { placeOf(p.i) = placeOf(p.j) = 0; });
  for (std::int32_t i = 0; i < owned; ++i)
    if (placeOf(i) == 0) {
      placeOf(i) = static_cast<std::int32_t>(segments_.size());
      segments_.push_back(i);
    }
  FoundPairs placed;
  pairs.forEach([&](const ListPair& p) { placed.add(placeOf(p.i), placeOf(p.j), true); });
  listed_.set(placed, static_cast<int>(segments_.size()));
  poses_.resize(segments_.size());
  sums_.assign(segments_.size(), {});
}

void SharedPairs::add(const PairForce& force, PairJob job, double margin, bool energies,
                      PairTally& tally) {
  if (segments_.empty()) return;
  for (std::size_t k = 0; k < segments_.size(); ++k)
    std::memcpy(poses_[k].at, job.pose + 8 * static_cast<std::size_t>(segments_[k]), sizeof(Pose));
  job.pose = poses_.data()->at;
  job.drawn = &drawn_;
  job.chunks = {};
  job.begin = 0;
  job.end = static_cast<std::int32_t>(segments_.size());
  job.sum = sums_.data();
  if (margin > 0) force.draw(listed_, job.pose, *job.nearest, margin, drawn_);
  force.add(job, energies, tally);
}

void SharedPairs::giveTo(const Share& share, ForceSum* sums) {
  for (auto at = std::ranges::lower_bound(segments_, share.begin);
       at != segments_.end() && *at < share.end; ++at) {
    ForceSum& from = sums_[static_cast<std::size_t>(at - segments_.begin())];
    for (int c = 0; c < 6; ++c) sums[*at].at[c] += from.at[c];
    // The next evaluation needs a zero record, and this one is in the cache now.
    from = {};
  }
}

void SharedPairs::clear() {
  std::ranges::fill(sums_, ForceSum{});
}

}  // namespace nanoweft
