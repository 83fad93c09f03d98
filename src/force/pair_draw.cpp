#include "nanoweft/force/pair_draw.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "nanoweft/force/gather.hpp"

namespace nanoweft {

namespace {

/// The classes of pairs by squared centre distance: near pairs lie below near2, far pairs from
/// farFrom2 to farTo2; of the others, those below drawn2 form the rim.
struct Classes {
  double near2, farFrom2, farTo2, drawn2;

  explicit Classes(const DrawRanges& r) {
    auto squared = [](double x) { return x > 0 ? x * x : 0.0; };
    near2 = squared(std::min(r.reach, r.blend.from - r.margin));
    farFrom2 = squared(r.blend.to + r.margin);
    farTo2 = squared(r.reach);
    drawn2 = squared(r.reach + r.margin);
  }
};

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

}  // namespace

void drawPairs(const PairRuns& listed, const double* pose, const MinimumImage& nearest,
               const DrawRanges& ranges, DrawnPairs& drawn) {
  // First segments in a chunk: so many that lanes get about equal numbers of partners, so few that
  // the chunk's segments stay in the cache.
  constexpr std::size_t stretch = 256;
  const Classes classes(ranges);
  drawn.near.clear();
  drawn.far.clear();
  drawn.rim.clear();
  drawn.ends.clear();
  Packed near, far, rim;
  for (std::size_t begin = 0; begin < listed.runs(); begin += stretch) {
    const std::size_t end = std::min(begin + stretch, listed.runs());
    for (std::size_t k = begin; k < end; ++k) {
      const PairRuns::Run run = listed.run(k);
      for (Packed* p : {&near, &far, &rim}) p->makeRoom(run.partners.size());
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
        const unsigned valid = (1u << used) - 1, inNear = lanesBelow(r2, classes.near2),
                       inFar = lanesBelow(r2, classes.farTo2) & ~lanesBelow(r2, classes.farFrom2) &
                               ~inNear;
        near.put(inNear & valid, j);
        far.put(inFar & valid, j);
        rim.put(lanesBelow(r2, classes.drawn2) & ~inNear & ~inFar & valid, j);
      }
      drawn.near.add(run.first, near.all());
      drawn.far.add(run.first, far.all());
      for (const std::int32_t j : rim.all()) drawn.rim.push_back({run.first, j});
    }
    drawn.near.arrange();
    drawn.far.arrange();
    drawn.ends.push_back({drawn.near.end(), drawn.far.end(), drawn.rim.size()});
  }
}

}  // namespace nanoweft
