#include "nanoweft/force/pair_draw.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "nanoweft/force/gather.hpp"

namespace nanoweft {

namespace {

/// The partners of one first segment that belong to a class, packed one after the other.
class Packed {
 public:
  void makeRoom(std::size_t count) {
    if (list_.size() < count + laneCount) list_.resize(count + laneCount);
    count_ = 0;
  }
  void put(unsigned chosen, const std::int32_t* v) {
    packLanes(chosen, v, &list_[count_]);
    count_ += static_cast<std::size_t>(std::popcount(chosen));
  }
  std::span<const std::int32_t> all() const { return {list_.data(), count_}; }

 private:
  std::vector<std::int32_t> list_;
  std::size_t count_ = 0;
};

/// Tells which pairs of a first segment the near part of a law may act on.
class NearPairs {
 public:
  NearPairs(const double* pose, const MinimumImage& nearest, const DrawRanges& ranges)
      : pose_(pose), nearest_(nearest), near_(ranges.near) {
    if (near_.cutoff <= 0) return;
    const double cutoff = near_.cutoff + ranges.margin;
    cutoff2_ = cutoff * cutoff;
    const Both<double> span = near_.span();
    candidate2_ = (cutoff + span.i + span.j) * (cutoff + span.i + span.j);
  }

  /// Pairs whose centres are farther apart than the root of this cannot be near.
  double candidate2() const { return candidate2_; }

  /// Those of the candidates that have two points within the cutoff and the margin.
  void choose(std::int32_t first, std::span<const std::int32_t> candidates, Packed& near) const {
    const double* at = pose_ + 8 * static_cast<std::size_t>(first);
    const Vec3<Lanes> x{at[0], at[1], at[2]};
    const Vec3d axis = axis1(Quatd{at[4], at[5], at[6], at[7]});
    const Vec3<Lanes> ei{axis.x, axis.y, axis.z};
    for (std::size_t n = 0; n < candidates.size(); n += laneCount) {
      const std::size_t used = std::min<std::size_t>(laneCount, candidates.size() - n);
      std::int32_t j[laneCount];
      for (std::size_t lane = 0; lane < laneCount; ++lane)
        j[lane] = candidates[n + std::min(lane, used - 1)];
      const Vec3<Lanes> separation = nearest_(gatherPositions(pose_, j) - x);
      const Lanes closest2 = closestPoints2(separation, ei, axis1(gatherOrientations(pose_, j)));
      near.put(lanesBelow(closest2, cutoff2_) & ((1u << used) - 1), j);
    }
  }

 private:
  Lanes closestPoints2(const Vec3<Lanes>& separation, const Vec3<Lanes>& ei,
                       const Vec3<Lanes>& ej) const {
    const auto [ni, nj] = near_.points;
    const Vec3<Lanes> stepI = Lanes(near_.length.i / ni) * ei,
                      stepJ = Lanes(near_.length.j / nj) * ej;
    Lanes closest2(std::numeric_limits<double>::infinity());
    for (int a = 0; a < ni; ++a)
      for (int b = 0; b < nj; ++b) {
        const Vec3<Lanes> d =
            separation + Lanes(b - 0.5 * (nj - 1)) * stepJ - Lanes(a - 0.5 * (ni - 1)) * stepI;
        closest2 = smaller(dot(d, d), closest2);
      }
    return closest2;
  }

  const double* pose_;
  const MinimumImage& nearest_;
  NearRange near_;
  double cutoff2_ = 0, candidate2_ = 0;
};

}  // namespace

void drawPairs(const PairRuns& listed, const double* pose, const MinimumImage& nearest,
               const DrawRanges& ranges, DrawnPairs& drawn) {
  // First segments in a chunk: so many that lanes get about equal numbers of partners, so few that
  // the chunk's segments stay in the cache.
  constexpr std::size_t stretch = 256;
  const double inside2 = ranges.reach * ranges.reach,
               drawn2 = (ranges.reach + ranges.margin) * (ranges.reach + ranges.margin);
  const NearPairs nearPairs(pose, nearest, ranges);
  drawn.inside.clear();
  drawn.inside.reserve(listed.pairs());
  drawn.near.clear();
  drawn.rim.clear();
  drawn.ends.clear();
  Packed inside, rim, candidates, near;
  for (std::size_t begin = 0; begin < listed.runs(); begin += stretch) {
    const std::size_t end = std::min(begin + stretch, listed.runs());
    for (std::size_t k = begin; k < end; ++k) {
      const PairRuns::Run run = listed.run(k);
      for (Packed* p : {&inside, &rim, &candidates}) p->makeRoom(run.partners.size());
      const double* x = pose + 8 * static_cast<std::size_t>(run.first);
      const Vec3<Lanes> from{x[0], x[1], x[2]};
      for (std::size_t n = 0; n < run.partners.size(); n += laneCount) {
        const std::size_t used = std::min<std::size_t>(laneCount, run.partners.size() - n);
        const std::int32_t* coming = run.partners.data() + n + 8 * laneCount;
        if (coming + laneCount <= listed.end())
          for (std::size_t lane = 0; lane < laneCount; ++lane)
            __builtin_prefetch(pose + 8 * static_cast<std::size_t>(coming[lane]));
        std::int32_t j[laneCount];
        for (std::size_t lane = 0; lane < laneCount; ++lane)
          j[lane] = run.partners[n + std::min(lane, used - 1)];
        const Vec3<Lanes> d = nearest(gatherPositions(pose, j) - from);
        const Lanes r2 = dot(d, d);
        const unsigned valid = (1u << used) - 1, isInside = lanesBelow(r2, inside2);
        inside.put(isInside & valid, j);
        rim.put(lanesBelow(r2, drawn2) & ~isInside & valid, j);
        candidates.put(lanesBelow(r2, nearPairs.candidate2()) & valid, j);
      }
      drawn.inside.add(run.first, inside.all());
      for (const std::int32_t j : rim.all()) drawn.rim.push_back({run.first, j});
      if (candidates.all().empty()) continue;
      near.makeRoom(candidates.all().size());
      nearPairs.choose(run.first, candidates.all(), near);
      drawn.near.add(run.first, near.all());
    }
    drawn.inside.arrange();
    drawn.near.arrange();
    drawn.ends.push_back({drawn.inside.end(), drawn.near.end(), drawn.rim.size()});
  }
}

}  // namespace nanoweft
