#include "nanoweft/force/pair_runs.hpp"

namespace nanoweft {

void PairRuns::set(const FoundPairs& pairs, int segments) {
  std::vector<std::size_t> place(static_cast<std::size_t>(segments), 0);
  pairs.forEach([&](const ListPair& p) { ++place[static_cast<std::size_t>(p.i)]; });
  first_.clear();
  end_.clear();
  std::size_t end = 0;
  for (int i = 0; i < segments; ++i) {
    std::size_t& count = place[static_cast<std::size_t>(i)];
    if (count == 0) continue;
    const std::size_t begin = end;
    end += count;
    count = begin;
    first_.push_back(i);
    end_.push_back(end);
  }
  // A vector that grows would hold its old pairs as well.
  if (end > partners_.capacity()) partners_ = {};
  partners_.resize(end);
  pairs.forEach(
      [&](const ListPair& p) { partners_[place[static_cast<std::size_t>(p.i)]++] = p.j; });
}

}  // namespace nanoweft
