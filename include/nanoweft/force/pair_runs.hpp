/// Pairs of segments, those with the same first segment in a row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace nanoweft {

/// Two local indices; the first has the lower row, so both sides of a rank boundary compute alike.
struct ListPair {
  std::int32_t i, j;
};

class PairRuns {
 public:
  struct Run {
    std::int32_t first;
    std::span<const std::int32_t> partners;
  };

  /// Makes runs of pairs of segments below `segments`; the order of partners stays.
  void set(std::span<const ListPair> pairs, int segments);

  std::size_t runs() const { return first_.size(); }
  Run run(std::size_t k) const {
    const std::size_t begin = k > 0 ? end_[k - 1] : 0;
    return {first_[k], {partners_.data() + begin, end_[k] - begin}};
  }
  std::size_t pairs() const { return partners_.size(); }
  /// The end of all partners: what may be looked at ahead.
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
