/// Single precision: twice as many lanes, and the operations of simd.hpp for them.
#pragma once

#include <cstdint>

#include "nanoweft/base/simd.hpp"

namespace nanoweft {

using Floats = stdx::native_simd<float>;
inline constexpr int floatCount = static_cast<int>(Floats::size());
static_assert(floatCount == 2 * laneCount);
/// Are kernels in single precision faster here? Only AVX-512 looks their tables up in registers.
inline constexpr bool singlePays = laneCount == 8;

/// As for doubles.
NW_INLINE float smaller(float a, float b) {
  return a < b ? a : b;
}
NW_INLINE Floats smaller(const Floats& a, const Floats& b) {
#ifdef __AVX512F__
  return Floats(_mm512_min_ps(static_cast<__m512>(a), static_cast<__m512>(b)));
#else
  return select(a < b, a, b);
#endif
}

NW_INLINE float multiplyAdd(float a, float b, float c) {
#ifdef __FMA__
  return __builtin_fmaf(a, b, c);
#else
  return a * b + c;
#endif
}
NW_INLINE Floats multiplyAdd(const Floats& a, const Floats& b, const Floats& c) {
#if defined(__AVX512F__)
  return Floats(
      _mm512_fmadd_ps(static_cast<__m512>(a), static_cast<__m512>(b), static_cast<__m512>(c)));
#elif defined(__FMA__)
  return Floats(
      _mm256_fmadd_ps(static_cast<__m256>(a), static_cast<__m256>(b), static_cast<__m256>(c)));
#else
  return a * b + c;
#endif
}

typedef std::int32_t FloatIntegers __attribute__((vector_size(sizeof(Floats))));

/// The number of the part that y > 0 lies in, up to a constant, when octaves are cut into 2^bits
/// equal parts; `place` within the part: from -1/2 to 1/2.
template <int bits>
NW_INLINE std::int32_t octavePart(float y, float& place) {
  const auto pattern = __builtin_bit_cast(std::int32_t, y);
  place = __builtin_bit_cast(float, (pattern << bits & 0x7fffff) | 0x3f800000) - 1.5f;
  return pattern >> (23 - bits);
}
template <int bits>
NW_INLINE FloatIntegers octavePart(const Floats& y, Floats& place) {
  const auto pattern = __builtin_bit_cast(FloatIntegers, y);
  place = __builtin_bit_cast(Floats, (pattern << bits & 0x7fffff) | 0x3f800000) - Floats(1.5f);
  return pattern >> (23 - bits);
}

/// 32 numbers that fit into registers: element `place` modulo 32.
struct alignas(64) ShortColumn {
  float at[32];

  NW_INLINE float operator[](std::int32_t place) const { return at[place & 31]; }
  NW_INLINE Floats operator[](const FloatIntegers& place) const {
#ifdef __AVX512F__
    return Floats(_mm512_permutex2var_ps(_mm512_load_ps(at), __builtin_bit_cast(__m512i, place),
                                         _mm512_load_ps(at + 16)));
#elif defined(__AVX2__)
    return Floats(_mm256_i32gather_ps(at, __builtin_bit_cast(__m256i, place & 31), 4));
#else
    return Floats([&](auto k) { return at[place[static_cast<int>(k)] & 31]; });
#endif
  }
};

/// Two vectors of doubles rounded to one of floats.
NW_INLINE Floats rounded(const Lanes& low, const Lanes& high) {
#ifdef __AVX512F__
  const __m256 a = _mm512_cvtpd_ps(static_cast<__m512d>(low)),
               b = _mm512_cvtpd_ps(static_cast<__m512d>(high));
  return Floats(_mm512_castpd_ps(
      _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_castps_pd(a)), _mm256_castps_pd(b), 1)));
#else
  return Floats([&](auto k) {
    return static_cast<float>(k < laneCount ? low[k % laneCount] : high[k % laneCount]);
  });
#endif
}

/// The first (0) or second (1) half as doubles.
NW_INLINE Lanes half(const Floats& v, int which) {
  alignas(64) float all[floatCount];
  v.copy_to(all, stdx::vector_aligned);
  const float* from = all + which * laneCount;
#ifdef __AVX512F__
  return Lanes(_mm512_cvtps_pd(_mm256_load_ps(from)));
#else
  return Lanes([&](auto k) { return static_cast<double>(from[k]); });
#endif
}

}  // namespace nanoweft
