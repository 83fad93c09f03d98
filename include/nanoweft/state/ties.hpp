/// The ties of a segment: its bonds, broken or not, to other segments.
#pragma once

#include <array>
#include <cstdint>

namespace nanoweft {

/// A bond by construction, broken or not, as one of its two segments sees it.
struct Tie {
  std::int64_t row = -1;   ///< of the other segment
  std::int32_t index = 0;  ///< of the other segment along its fibre
  bool first = false;      ///< the bond runs from this segment to the other one, and counts for it
  bool broken = false;
};

/// The ties of one segment, two at most.
class Ties {
 public:
  void add(const Tie& tie) { ties_[count_++] = tie; }
  const Tie* begin() const { return ties_.data(); }
  const Tie* end() const { return ties_.data() + count_; }

 private:
  std::array<Tie, 2> ties_;
  std::size_t count_ = 0;
};

}  // namespace nanoweft
