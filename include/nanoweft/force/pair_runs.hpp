/// A compact list of segment pairs: pairs with the same first segment are stored as one run, the
/// first segment followed by its partners. The pair list is stored in this form.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace nanoweft {

/// Local indices of two segments, that with the lower row first, or in a pair of two kinds that of
/// the first kind: so two ranks that both resolve a pair do it in the same order and get the same
/// bits.
struct ListPair {
  std::int32_t i, j;
};

class PairRuns {
 public:
  struct Run {
    std::int32_t first;
    std::span<const std::int32_t> partners;
  };

  /// Makes runs of pairs whose indices are below `segments`, partners in the order of `pairs`.
  void set(std::span<const ListPair> pairs, int segments);

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
