#include "nanoweft/force/pair_sift.hpp"

#include <algorithm>

#include "nanoweft/force/gather.hpp"

namespace nanoweft {

PairSift::PairSift(const PairJob& job, const Switch& blend, double reach)
    : job_(job),
      from2_(blend.from * blend.from),
      to2_(blend.to * blend.to),
      reach2_(reach * reach) {}

void PairSift::sift(std::size_t first) {
  const int used = static_cast<int>(std::min<std::size_t>(laneCount, job_.count - first));
  std::int32_t i[laneCount], j[laneCount];
  for (int k = 0; k < laneCount; ++k) {
    const ListPair& pair = job_.pairs[first + static_cast<std::size_t>(std::min(k, used - 1))];
    i[k] = pair.i;
    j[k] = pair.j;
  }
  const Vec3<Lanes> d =
      (*job_.nearest)(gatherPositions(job_.pose, j) - gatherPositions(job_.pose, i));
  alignas(64) double x[laneCount], y[laneCount], z[laneCount], r2[laneCount];
  d.x.copy_to(x, stdx::vector_aligned);
  d.y.copy_to(y, stdx::vector_aligned);
  d.z.copy_to(z, stdx::vector_aligned);
  dot(d, d).copy_to(r2, stdx::vector_aligned);
  for (int k = 0; k < used; ++k) {
    // Sums of comparisons: a branch here would be mispredicted often.
    const int which = !(r2[k] < from2_) + !(r2[k] < to2_) + !(r2[k] < reach2_);
    PairBlock& b = blocks_[r2[k] < reach2_ ? which : dropped];
    const int n = b.count++;
    b.i[n] = i[k];
    b.j[n] = j[k];
    b.x[n] = x[k];
    b.y[n] = y[k];
    b.z[n] = z[k];
  }
  blocks_[dropped].count = 0;
}

const PairBlock* PairSift::handOut(int which, Class& result) {
  PairBlock& b = blocks_[which];
  for (int n = b.count; n % laneCount; ++n) {
    b.i[n] = b.i[n - 1];
    b.j[n] = b.j[n - 1];
    b.x[n] = b.x[n - 1];
    b.y[n] = b.y[n - 1];
    b.z[n] = b.z[n - 1];
  }
  given_ = which;
  result = static_cast<Class>(which);
  return &b;
}

const PairBlock* PairSift::next(Class& which) {
  blocks_[given_].count = 0;
  for (; place_ < job_.count; place_ += laneCount) {
    for (int c = near; c < dropped; ++c)
      if (blocks_[c].count > PairBlock::capacity - laneCount) return handOut(c, which);
    sift(place_);
  }
  for (int c = near; c < dropped; ++c)
    if (blocks_[c].count > 0) return handOut(c, which);
  return nullptr;
}

}  // namespace nanoweft
