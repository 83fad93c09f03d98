/// A compact list of segment pairs: pairs with the same first segment are stored as one run, the
/// first segment followed by its partners. The pair list is stored in this form.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace nanoweft {

/// Local indices of two segments, that with the lower row first, or in a pair of two kinds that of
/// the first kind: whoever resolves a pair does it in the same order and gets the same bits.
struct ListPair {
  std::int32_t i, j;
};

/// Pairs while they are being found, segment after segment: four bytes a pair, in blocks that are
/// never moved, since a vector that grows needs up to three times the memory of its pairs.
class FoundPairs {
 public:
  FoundPairs() = default;
  explicit FoundPairs(std::span<const ListPair> pairs) {
    for (const ListPair& p : pairs) add(p.i, p.j, true);
  }

  /// A pair of the segments `i` and `j`; `inOrder`: i comes first.
  void add(std::int32_t i, std::int32_t j, bool inOrder) {
    if (finders_.empty() || finders_.back().i != i) finders_.push_back({i, count_});
    if (count_ % blockSize == 0)
      blocks_.push_back(std::make_unique_for_overwrite<std::int32_t[]>(blockSize));
    blocks_.back()[count_++ % blockSize] = inOrder ? j : ~j;
  }

  bool empty() const { return count_ == 0; }

  template <class Visit>
  void forEach(const Visit& visit) const {
    for (std::size_t f = 0; f < finders_.size(); ++f) {
      const std::int32_t i = finders_[f].i;
      const std::size_t end = f + 1 < finders_.size() ? finders_[f + 1].begin : count_;
      for (std::size_t k = finders_[f].begin; k < end; ++k) {
        const std::int32_t j = blocks_[k / blockSize][k % blockSize];
        visit(j >= 0 ? ListPair{i, j} : ListPair{~j, i});
      }
    }
  }

 private:
  /// A segment, and which of the pairs is its first.
  struct Finder {
    std::int32_t i;
    std::size_t begin;
  };

  static constexpr std::size_t blockSize = 1 << 15;
  std::vector<std::unique_ptr<std::int32_t[]>> blocks_;
  std::vector<Finder> finders_;
  std::size_t count_ = 0;
};

class PairRuns {
 public:
  struct Run {
    std::int32_t first;
    std::span<const std::int32_t> partners;
  };

  /// Makes runs of pairs whose indices are below `segments`, partners in the order of `pairs`.
  void set(const FoundPairs& pairs, int segments);

  std::size_t runs() const { return first_.size(); }
  Run run(std::size_t k) const {
    const std::size_t begin = k > 0 ? end_[k - 1] : 0;
    return {first_[k], {partners_.data() + begin, end_[k] - begin}};
  }
  std::size_t pairs() const { return partners_.size(); }
  /// The end of all partners: code that prefetches must not read beyond it.
  const std::int32_t* end() const { return partners_.data() + partners_.size(); }

  template <class Visit>
  void forEach(const Visit& visit) const {
    for (std::size_t k = 0; k < runs(); ++k)
      for (const Run r = run(k); const std::int32_t j : r.partners) visit(ListPair{r.first, j});
  }

 private:
  std::vector<std::int32_t> first_, partners_;
  std::vector<std::size_t> end_;
};

}  // namespace nanoweft
