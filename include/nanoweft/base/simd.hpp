/// SIMD: the vector type `Lanes`, in which kernels compute `laneCount` bonds, pairs or segments at
/// a time, and the operations on it that the standard library lacks or compiles badly.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <experimental/simd>
#ifdef __FMA__
#include <immintrin.h>
#endif

namespace nanoweft {

namespace stdx = std::experimental;

// Kernels lose half their speed when one of their small functions is called instead of inlined, and
// the compiler's own estimate of a SIMD function's size is off.
#define NW_INLINE [[gnu::always_inline]] inline

/// As many doubles as the target's registers hold: 2 (SSE2), 4 (AVX2), 8 (AVX-512).
using Lanes = stdx::native_simd<double>;
inline constexpr int laneCount = static_cast<int>(Lanes::size());

/// The instruction set that this was compiled for, as a value of -simd.
inline constexpr const char* simdName =
#if defined(__AVX512F__)
    "avx512";
#elif defined(__AVX2__)
    "avx2";
#elif defined(__SSE2__)
    "sse2";
#elif defined(__ARM_NEON)
    "neon";
#else
    "none";
#endif

/// A constant of a formula, in the precision of V.
template <class V>
NW_INLINE V number(double x) {
  if constexpr (requires { typename V::value_type; })
    return V(static_cast<typename V::value_type>(x));
  else
    return static_cast<V>(x);
}

/// Per-lane choice; for doubles an ordinary conditional.
NW_INLINE double select(bool condition, double a, double b) {
  return condition ? a : b;
}
NW_INLINE float select(bool condition, float a, float b) {
  return condition ? a : b;
}
template <class T, class Abi>
NW_INLINE stdx::simd<T, Abi> select(const stdx::simd_mask<T, Abi>& condition,
                                    const stdx::simd<T, Abi>& a, const stdx::simd<T, Abi>& b) {
#if defined(__clang__) && defined(__AVX512F__)
  // In clang 16 an assignment through `where` of libstdc++ 12 changes nothing.
  unsigned bits = 0;
  for (std::size_t k = 0; k < condition.size(); ++k)
    bits |= static_cast<unsigned>(condition[k]) << k;
  if constexpr (sizeof(T) == sizeof(double))
    return stdx::simd<T, Abi>(_mm512_mask_blend_pd(
        static_cast<__mmask8>(bits), static_cast<__m512d>(b), static_cast<__m512d>(a)));
  else
    return stdx::simd<T, Abi>(_mm512_mask_blend_ps(static_cast<__mmask16>(bits),
                                                   static_cast<__m512>(b), static_cast<__m512>(a)));
#else
  stdx::simd<T, Abi> result = b;
  where(condition, result) = a;
  return result;
#endif
}

NW_INLINE bool anyOf(bool condition) {
  return condition;
}
template <class T, class Abi>
NW_INLINE bool anyOf(const stdx::simd_mask<T, Abi>& condition) {
  return stdx::any_of(condition);
}

/// The larger and the smaller of two numbers; the second one when either is a NaN.
NW_INLINE double larger(double a, double b) {
  return a > b ? a : b;
}
NW_INLINE double smaller(double a, double b) {
  return a < b ? a : b;
}
NW_INLINE Lanes larger(const Lanes& a, const Lanes& b) {
#ifdef __AVX512F__
  return Lanes(_mm512_max_pd(static_cast<__m512d>(a), static_cast<__m512d>(b)));
#else
  return select(a > b, a, b);
#endif
}
NW_INLINE Lanes smaller(const Lanes& a, const Lanes& b) {
#ifdef __AVX512F__
  return Lanes(_mm512_min_pd(static_cast<__m512d>(a), static_cast<__m512d>(b)));
#else
  return select(a < b, a, b);
#endif
}

/// a b + c, fused where the target can, so that all instances of a formula round alike. (In large
/// functions the compiler splits the library's own fma into scalar ones.)
NW_INLINE double multiplyAdd(double a, double b, double c) {
#ifdef __FMA__
  return __builtin_fma(a, b, c);
#else
  return a * b + c;
#endif
}
NW_INLINE Lanes multiplyAdd(const Lanes& a, const Lanes& b, const Lanes& c) {
#if defined(__AVX512F__)
  return Lanes(
      _mm512_fmadd_pd(static_cast<__m512d>(a), static_cast<__m512d>(b), static_cast<__m512d>(c)));
#elif defined(__FMA__)
  return Lanes(
      _mm256_fmadd_pd(static_cast<__m256d>(a), static_cast<__m256d>(b), static_cast<__m256d>(c)));
#else
  return a * b + c;
#endif
}

/// A 64-bit index for each lane, in memory.
struct LaneIndex {
  alignas(64) std::int64_t at[Lanes::size()];
};

/// Looks up y > 0 in a table whose parts are octaves cut into 2^bits equal parts. Returns the
/// number of y's part times `stride` (a power of two, the doubles of a row), up to a constant;
/// `begin` is set to where the part begins.
template <int bits, int stride>
NW_INLINE std::int64_t octavePart(double y, double& begin) {
  constexpr int shift = 52 - bits;
  const auto pattern = __builtin_bit_cast(std::int64_t, y);
  begin = __builtin_bit_cast(double, pattern >> shift << shift);
  return stride * (pattern >> shift);
}
template <int bits, int stride>
NW_INLINE LaneIndex octavePart(const Lanes& y, Lanes& begin) {
  constexpr int shift = 52 - bits;
  using Integers = std::int64_t __attribute__((vector_size(sizeof(Lanes))));
  const Integers floor = __builtin_bit_cast(Integers, y) & (std::int64_t{-1} << shift);
  begin = __builtin_bit_cast(Lanes, floor);
  LaneIndex index;
  const Integers counted = floor >> (shift - std::countr_zero(unsigned{stride}));
  std::memcpy(index.at, &counted, sizeof counted);
  // Keeps the indices in memory. To take them out of a register one by one, the compiler would use
  // the shuffle unit, which the loads of rows need.
  asm("" : "+m"(index));
  return index;
}

/// The double whose upper half is the lower half of x, and whose lower half is zero.
NW_INLINE double lowerHalf(double x) {
  return __builtin_bit_cast(double, __builtin_bit_cast(std::uint64_t, x) << 32);
}
NW_INLINE Lanes lowerHalf(const Lanes& x) {
#ifdef __AVX512F__
  return Lanes(
      _mm512_castsi512_pd(_mm512_slli_epi64(_mm512_castpd_si512(static_cast<__m512d>(x)), 32)));
#else
  using Integers = std::int64_t __attribute__((vector_size(sizeof(Lanes))));
  return __builtin_bit_cast(Lanes, __builtin_bit_cast(Integers, x) << 32);
#endif
}

/// The first columns of a row that begins at `place`.
template <int columns>
NW_INLINE std::array<double, columns> loadRows(const double* table, std::int64_t place) {
  std::array<double, columns> c;
  for (std::size_t k = 0; k < columns; ++k) c[k] = table[place + static_cast<std::int64_t>(k)];
  return c;
}

namespace detail {

typedef double Doubles4 __attribute__((vector_size(32)));
typedef double Doubles8 __attribute__((vector_size(64)));

template <class Vector>
NW_INLINE Vector loadVector(const double* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

/// Four doubles from one place, four from another.
NW_INLINE Doubles8 loadHalves(const double* low, const double* high) {
#ifdef __AVX512F__
  // As an insertion from memory, which leaves the shuffle unit free.
  return __builtin_bit_cast(
      Doubles8,
      _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(low)), _mm256_loadu_pd(high), 1));
#else
  return __builtin_shufflevector(loadVector<Doubles4>(low), loadVector<Doubles4>(high), 0, 1, 2, 3,
                                 4, 5, 6, 7);
#endif
}

/// Columns k .. k+3 of four groups of rows. (By value: the compiler writes arrays to memory.)
template <int columns, std::size_t k, class Combine, class Group>
NW_INLINE void transposeGroup(Group r0, Group r1, Group r2, Group r3,
                              std::array<Lanes, columns>& c) {
  const Group low01 = Combine::low(r0, r1), low23 = Combine::low(r2, r3);
  const Group high01 = Combine::high(r0, r1), high23 = Combine::high(r2, r3);
  if constexpr (k < columns) c[k] = __builtin_bit_cast(Lanes, Combine::even(low01, low23));
  if constexpr (k + 1 < columns)
    c[k + 1] = __builtin_bit_cast(Lanes, Combine::even(high01, high23));
  if constexpr (k + 2 < columns) c[k + 2] = __builtin_bit_cast(Lanes, Combine::odd(low01, low23));
  if constexpr (k + 3 < columns) c[k + 3] = __builtin_bit_cast(Lanes, Combine::odd(high01, high23));
}

struct Combine4 {
  using G = Doubles4;
  NW_INLINE static G low(G a, G b) { return __builtin_shufflevector(a, b, 0, 4, 2, 6); }
  NW_INLINE static G high(G a, G b) { return __builtin_shufflevector(a, b, 1, 5, 3, 7); }
  NW_INLINE static G even(G a, G b) { return __builtin_shufflevector(a, b, 0, 1, 4, 5); }
  NW_INLINE static G odd(G a, G b) { return __builtin_shufflevector(a, b, 2, 3, 6, 7); }
};
struct Combine8 {
  using G = Doubles8;
  NW_INLINE static G low(G a, G b) {
    return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
  }
  NW_INLINE static G high(G a, G b) {
    return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  }
  NW_INLINE static G even(G a, G b) {
    return __builtin_shufflevector(a, b, 0, 1, 4, 5, 8, 9, 12, 13);
  }
  NW_INLINE static G odd(G a, G b) {
    return __builtin_shufflevector(a, b, 2, 3, 6, 7, 10, 11, 14, 15);
  }
};

}  // namespace detail

/// The first columns of a row for each lane; `place(lane)`: where its row begins. Rows are loaded
/// as vectors and transposed by shuffles, since loading element by element is far slower.
template <int columns, class Place>
NW_INLINE std::array<Lanes, columns> loadRows(const double* table, Place place) {
  using namespace detail;
  std::array<Lanes, columns> c;
  if constexpr (laneCount == 8) {
    // Lanes l and l + 2 share a register, so that the transpose moves whole quarters of registers.
    auto rows = [&](std::size_t l, int first) {
      return loadHalves(table + place(l) + first, table + place(l + 2) + first);
    };
    transposeGroup<columns, 0, Combine8>(rows(0, 0), rows(1, 0), rows(4, 0), rows(5, 0), c);
    if constexpr (columns > 4)
      transposeGroup<columns, 4, Combine8>(rows(0, 4), rows(1, 4), rows(4, 4), rows(5, 4), c);
  } else if constexpr (laneCount == 4) {
    auto row = [&](std::size_t l, int first) {
      return loadVector<Doubles4>(table + place(l) + first);
    };
    transposeGroup<columns, 0, Combine4>(row(0, 0), row(1, 0), row(2, 0), row(3, 0), c);
    if constexpr (columns > 4)
      transposeGroup<columns, 4, Combine4>(row(0, 4), row(1, 4), row(2, 4), row(3, 4), c);
  } else {
    for (std::size_t k = 0; k < columns; ++k)
      c[k] = Lanes([&](auto lane) { return table[place(lane) + static_cast<std::int64_t>(k)]; });
  }
  return c;
}

template <int columns>
NW_INLINE std::array<Lanes, columns> loadRows(const double* table, const LaneIndex& index) {
  return loadRows<columns>(table, [&](std::size_t lane) { return index.at[lane]; });
}

typedef std::int64_t LaneIntegers __attribute__((vector_size(sizeof(Lanes))));
/// A 32-bit index for each lane.
typedef std::int32_t LaneNumbers __attribute__((vector_size(sizeof(Lanes) / 2)));
NW_INLINE LaneNumbers loadNumbers(const std::int32_t* from) {
  LaneNumbers v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
NW_INLINE Lanes toLanes(const LaneNumbers& v) {
  typedef double Doubles __attribute__((vector_size(sizeof(Lanes))));
  return __builtin_bit_cast(Lanes, __builtin_convertvector(v, Doubles));
}
/// Are the numbers of all lanes zero?
NW_INLINE bool none(const LaneNumbers& v) {
  std::int64_t words[sizeof v / 8], all = 0;
  std::memcpy(words, &v, sizeof v);
  for (const std::int64_t w : words) all |= w;
  return all == 0;
}
/// Eight 64-bit values of one lane: a row.
typedef std::int64_t Row __attribute__((vector_size(64)));
typedef double Reals __attribute__((vector_size(64)));

/// The inverse of loadRows: makes a row for each lane from up to eight columns, missing ones zero.
/// (`Integers` is LaneIntegers: as a parameter, so that only the target's branch is compiled.)
template <int columns, class Integers>
NW_INLINE void toRows(const Integers* column, Row* row) {
  if constexpr (laneCount == 8) {
    // First two columns are interleaved, even and odd lanes apart. Then quarters of registers, two
    // columns of a lane each, are moved to the rows of their lanes.
    auto at = [column](int k) { return k < columns ? column[k] : Row{}; };
    auto even = [&](int k) {
      return __builtin_shufflevector(at(k), at(k + 1), 0, 8, 2, 10, 4, 12, 6, 14);
    };
    auto odd = [&](int k) {
      return __builtin_shufflevector(at(k), at(k + 1), 1, 9, 3, 11, 5, 13, 7, 15);
    };
    auto lowHalves = [](Row x, Row y) {
      return __builtin_shufflevector(x, y, 0, 1, 2, 3, 8, 9, 10, 11);
    };
    auto highHalves = [](Row x, Row y) {
      return __builtin_shufflevector(x, y, 4, 5, 6, 7, 12, 13, 14, 15);
    };
    auto evenQuarters = [](Row x, Row y) {
      return __builtin_shufflevector(x, y, 0, 1, 4, 5, 8, 9, 12, 13);
    };
    auto oddQuarters = [](Row x, Row y) {
      return __builtin_shufflevector(x, y, 2, 3, 6, 7, 10, 11, 14, 15);
    };
    auto spread = [&](int first, Row a, Row b, Row c, Row d) {
      const Row ab = lowHalves(a, b), cd = lowHalves(c, d);
      row[first] = evenQuarters(ab, cd);
      row[first + 2] = oddQuarters(ab, cd);
      const Row highAb = highHalves(a, b), highCd = highHalves(c, d);
      row[first + 4] = evenQuarters(highAb, highCd);
      row[first + 6] = oddQuarters(highAb, highCd);
    };
    spread(0, even(0), even(2), even(4), even(6));
    spread(1, odd(0), odd(2), odd(4), odd(6));
  } else {
    for (int k = 0; k < laneCount; ++k) {
      Row r{};
      for (int c = 0; c < columns; ++c) r[c] = column[c][k];
      row[k] = r;
    }
  }
}

/// The lower and the upper halves of `laneCount` 64-bit words.
NW_INLINE void splitWords(const void* words, std::int32_t* lower, std::int32_t* upper) {
  static_assert(std::endian::native == std::endian::little);
  LaneIntegers all;
  std::memcpy(&all, words, sizeof all);
  const LaneNumbers low = __builtin_convertvector(all, LaneNumbers),
                    high = __builtin_convertvector(all >> 32, LaneNumbers);
  std::memcpy(lower, &low, sizeof low);
  std::memcpy(upper, &high, sizeof high);
}

/// Nearest integers of numbers below 2^62.
NW_INLINE LaneIntegers nearestIntegers(const Lanes& x) {
#ifdef __AVX512DQ__
  return __builtin_bit_cast(LaneIntegers, _mm512_cvtpd_epi64(static_cast<__m512d>(x)));
#else
  // Adding 1.5 * 2^52 leaves the nearest integer in the low bits of the sum. This is done for the
  // upper 32 bits first, then for the rest.
  const Lanes magic(0x1.8p52);
  const auto bits = [](const Lanes& v) { return __builtin_bit_cast(LaneIntegers, v); };
  const Lanes high = x * 0x1p-32 + magic;
  const Lanes low = x - (high - magic) * 0x1p32 + magic;
  return ((bits(high) - bits(magic)) << 32) + (bits(low) - bits(magic));
#endif
}

/// Makes the compiler read parts of `x` from memory, which costs nothing as the operand of another
/// instruction. Otherwise it would build them anew from values in registers at every use.
template <class T>
NW_INLINE void keepInMemory(T& x) {
  asm("" : "+m"(x));
}

/// Which lanes are below a limit, as bits.
NW_INLINE unsigned lanesBelow(const Lanes& v, double limit) {
#ifdef __AVX512F__
  return _mm512_cmp_pd_mask(static_cast<__m512d>(v), _mm512_set1_pd(limit), _CMP_LT_OQ);
#else
  unsigned bits = 0;
  for (std::size_t k = 0; k < laneCount; ++k) bits |= static_cast<unsigned>(v[k] < limit) << k;
  return bits;
#endif
}

/// Writes the chosen lanes one after the other; up to a whole vector of `out` is overwritten.
NW_INLINE void packLanes(unsigned chosen, const Lanes& v, double* out) {
#ifdef __AVX512F__
  _mm512_storeu_pd(
      out, _mm512_maskz_compress_pd(static_cast<__mmask8>(chosen), static_cast<__m512d>(v)));
#else
  for (std::size_t k = 0; k < laneCount; ++k) {
    *out = v[k];
    out += chosen >> k & 1;
  }
#endif
}
NW_INLINE void packLanes(unsigned chosen, const std::int32_t* v, std::int32_t* out) {
#if defined(__AVX512F__) && defined(__AVX512VL__)
  const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(v));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                      _mm256_maskz_compress_epi32(static_cast<__mmask8>(chosen), all));
#else
  for (std::size_t k = 0; k < laneCount; ++k) {
    *out = v[k];
    out += chosen >> k & 1;
  }
#endif
}

}  // namespace nanoweft
