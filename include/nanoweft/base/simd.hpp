/// The SIMD vector that kernels run in, and the few operations that differ from plain doubles.
#pragma once

#include <experimental/simd>

namespace nanoweft {

namespace stdx = std::experimental;

// Kernels lose half their speed when one of their small functions is called instead of inlined, and
// the compiler's own estimate of a SIMD function's size is off.
#define NW_INLINE [[gnu::always_inline]] inline

/// As many doubles as the target's registers hold: 2 (SSE2), 4 (AVX2), 8 (AVX-512).
using Lanes = stdx::native_simd<double>;
inline constexpr int laneCount = static_cast<int>(Lanes::size());

/// Per-lane choice; for doubles an ordinary conditional.
NW_INLINE double select(bool condition, double a, double b) {
  return condition ? a : b;
}
template <class T, class Abi>
NW_INLINE stdx::simd<T, Abi> select(const stdx::simd_mask<T, Abi>& condition,
                                    const stdx::simd<T, Abi>& a, const stdx::simd<T, Abi>& b) {
  stdx::simd<T, Abi> result = b;
  where(condition, result) = a;
  return result;
}

NW_INLINE bool anyOf(bool condition) {
  return condition;
}
template <class T, class Abi>
NW_INLINE bool anyOf(const stdx::simd_mask<T, Abi>& condition) {
  return stdx::any_of(condition);
}

}  // namespace nanoweft
