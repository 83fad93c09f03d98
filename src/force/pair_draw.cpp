#include "nanoweft/force/pair_draw.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "nanoweft/force/gather.hpp"
#include "nanoweft/force/pair_kernel.hpp"

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

/// What is drawn of the pairs of one first segment.
struct DrawnRun {
  Packed inside, rim, candidates, near;

  void makeRoom(std::size_t count) {
    for (Packed* p : {&inside, &rim, &candidates, &near}) p->makeRoom(count);
  }
};

/// Squared distances of centres up to which pairs are inside, or at least in the rim.
struct Bounds {
  double inside2, drawn2;

  void sort(const Lanes& r2, unsigned valid, const std::int32_t* j, DrawnRun& run) const {
    const unsigned isInside = lanesBelow(r2, inside2);
    run.inside.put(isInside & valid, j);
    run.rim.put(lanesBelow(r2, drawn2) & ~isInside & valid, j);
  }
};

/// Tells which pairs of a first segment the near part of a law may act on.
class NearPairs {
 public:
  NearPairs(const double* pose, const MinimumImage& nearest, const DrawRanges& ranges,
            const Bounds& bounds)
      : pose_(pose), nearest_(nearest), near_(ranges.near), bounds_(bounds) {
    if (near_.cutoff <= 0) return;
    const double cutoff = near_.cutoff + ranges.margin;
    // Round-off of a distance must not leave out a pair at the limit.
    cutoff2_ = (1.0 + 1e-9) * cutoff * cutoff;
    const Both<double> span = near_.span();
    candidate2_ = (cutoff + span.i + span.j) * (cutoff + span.i + span.j);
    const auto [ni, nj] = near_.points;
    for (int a = 0; a < ni; ++a) placesI_.push_back(pointPlace(a, ni, near_.length.i));
    for (int b = nj / 2; b < nj; ++b) placesJ_.push_back(pointPlace(b, nj, near_.length.j));
  }

  /// Pairs whose centres are farther apart than the root of this cannot be near.
  double candidate2() const { return candidate2_; }

  bool alone() const { return near_.alone; }

  /// Near are those of the candidates that have two points within the cutoff and the margin. The
  /// others are sorted here if near pairs are drawn alone.
  void choose(std::int32_t first, DrawnRun& run) const {
    const std::span<const std::int32_t> candidates = run.candidates.all();
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
      const auto shape = shapeOf(separation, ei, axis1(gatherOrientations(pose_, j)));
      const unsigned valid = (1u << used) - 1, isNear = lanesBelow(closestPoints2(shape), cutoff2_);
      run.near.put(isNear & valid, j);
      if (near_.alone) bounds_.sort(shape.center2, ~isNear & valid, j, run);
    }
  }

 private:
  /// Squared distance of the closest points, which lie on either side of the centre of j alike.
  Lanes closestPoints2(const PairShape<Lanes>& shape) const {
    Lanes closest2(std::numeric_limits<double>::infinity());
    for (const double place : placesI_) {
      const Lanes sa(place), part = shape.alongJ - sa * shape.cosine,
                             along = 2.0 * larger(part, Lanes(-part)),
                             from2 = shape.center2 + sa * (sa - 2.0 * shape.alongI);
      for (const double sb : placesJ_)
        closest2 = smaller(Lanes(from2 + Lanes(sb) * (Lanes(sb) - along)), closest2);
    }
    return closest2;
  }

  const double* pose_;
  const MinimumImage& nearest_;
  NearRange near_;
  Bounds bounds_;
  double cutoff2_ = 0, candidate2_ = 0;
  std::vector<double> placesI_, placesJ_;  ///< of points along i, and beyond the centre of j
};

}  // namespace

void drawPairs(const PairRuns& listed, const double* pose, const MinimumImage& nearest,
               const DrawRanges& ranges, DrawnPairs& drawn) {
  // First segments in a chunk: so many that lanes get about equal numbers of partners, so few that
  // the chunk's segments stay in the cache.
  constexpr std::size_t stretch = 256;
  const Bounds bounds{ranges.reach * ranges.reach,
                      (ranges.reach + ranges.margin) * (ranges.reach + ranges.margin)};
  const NearPairs nearPairs(pose, nearest, ranges, bounds);
  drawn.inside.clear();
  drawn.inside.reserve(listed.pairs());
  drawn.near.clear();
  drawn.rim.clear();
  drawn.ends.clear();
  DrawnRun of;
  for (std::size_t begin = 0; begin < listed.runs(); begin += stretch) {
    const std::size_t end = std::min(begin + stretch, listed.runs());
    for (std::size_t k = begin; k < end; ++k) {
      const PairRuns::Run run = listed.run(k);
      of.makeRoom(run.partners.size());
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
        const unsigned valid = (1u << used) - 1,
                       candidates = lanesBelow(r2, nearPairs.candidate2()) & valid;
        of.candidates.put(candidates, j);
        bounds.sort(r2, nearPairs.alone() ? valid & ~candidates : valid, j, of);
      }
      nearPairs.choose(run.first, of);
      drawn.inside.add(run.first, of.inside.all());
      for (const std::int32_t j : of.rim.all()) drawn.rim.push_back({run.first, j});
      drawn.near.add(run.first, of.near.all());
    }
    drawn.inside.arrange();
    drawn.near.arrange();
    drawn.ends.push_back({drawn.inside.end(), drawn.near.end(), drawn.rim.size()});
  }
}

}  // namespace nanoweft
