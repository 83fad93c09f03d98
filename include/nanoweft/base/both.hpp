/// A value for each of two segments, or one for both.
#pragma once

namespace nanoweft {

template <class T>
struct Both {
  T i{}, j{};

  Both() = default;
  constexpr Both(T both) : i(both), j(both) {}
  constexpr Both(T first, T second) : i(first), j(second) {}

  constexpr bool same() const { return i == j; }
  friend constexpr bool operator==(const Both&, const Both&) = default;
};

}  // namespace nanoweft
