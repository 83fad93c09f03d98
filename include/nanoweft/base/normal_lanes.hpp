/// Random numbers of the counter-based generator (base/random.hpp), for a SIMD group at a time.
#pragma once

#include "nanoweft/base/random.hpp"
#include "nanoweft/base/simd.hpp"

namespace nanoweft {

/// A word of 32 bits for each lane; what stands above them is of no account.
typedef std::uint64_t LaneWords __attribute__((vector_size(sizeof(Lanes))));

namespace detail {

/// The 64-bit products of 32-bit words.
NW_INLINE LaneWords product(const LaneWords& a, std::uint32_t b) {
#if defined(__AVX512F__)
  return __builtin_bit_cast(LaneWords,
                            _mm512_mul_epu32(__builtin_bit_cast(__m512i, a), _mm512_set1_epi64(b)));
#elif defined(__AVX2__)
  return __builtin_bit_cast(
      LaneWords, _mm256_mul_epu32(__builtin_bit_cast(__m256i, a), _mm256_set1_epi64x(b)));
#else
  return (a & 0xffffffffu) * static_cast<std::uint64_t>(b);
#endif
}

}  // namespace detail

/// What philox gives for each lane's counter.
NW_INLINE std::array<LaneWords, 4> philox(std::array<LaneWords, 4> counter,
                                          std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const LaneWords p0 = detail::product(counter[0], 0xD2511F53u);
    const LaneWords p1 = detail::product(counter[2], 0xCD9E8D57u);
    counter = {(p1 >> 32) ^ counter[1] ^ key[0], p1, (p0 >> 32) ^ counter[3] ^ key[1], p0};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

namespace detail {

/// 1, x, x^2 ... with coefficients from the last to the first.
template <std::size_t n>
NW_INLINE Lanes polynomial(const Lanes& x, const double (&last)[n]) {
  Lanes sum(last[0]);
  for (std::size_t k = 1; k < n; ++k) sum = multiplyAdd(sum, x, Lanes(last[k]));
  return sum;
}

/// Natural logarithm of normal numbers above zero, to 1e-11 of it.
NW_INLINE Lanes logarithm(const Lanes& x) {
  // x = 2^e m with m from sqrt(1/2) to sqrt(2); ln m = 2 artanh((m - 1)/(m + 1)).
  constexpr std::int64_t root = 0x3FE6A09E667F3BCD;
  const auto pattern = __builtin_bit_cast(LaneIntegers, x);
  const LaneIntegers e = (pattern - root) >> 52;
  const Lanes m = __builtin_bit_cast(Lanes, pattern - (e << 52));
  const Lanes s = (m - 1.0) / (m + 1.0);
  const Lanes series =
      polynomial(s * s, {2.0 / 13, 2.0 / 11, 2.0 / 9, 2.0 / 7, 2.0 / 5, 2.0 / 3, 2.0});
  return multiplyAdd(toLanes(__builtin_convertvector(e, LaneNumbers)), Lanes(0.69314718055994531),
                     s * series);
}

/// Two standard normal numbers from two words, by Box and Muller.
NW_INLINE std::array<Lanes, 2> boxMuller(const LaneWords& radius, const LaneWords& angle) {
  const auto r = __builtin_convertvector(radius, LaneNumbers);
  const auto turn = __builtin_convertvector(angle, LaneNumbers);
  // The middle of one of 2^32 parts of (0, 1).
  const Lanes u = (toLanes(r) + (0x1p31 + 0.5)) * 0x1p-32;
  const Lanes size = sqrt(-2.0 * logarithm(u));
  // 30 bits are an angle of at most pi/4, two choose the quarter of the circle.
  constexpr double perCount = 1.5707963267948966 * 0x1p-32;
  const Lanes x = (toLanes(turn << 2) + 2.0) * perCount;
  const Lanes xx = x * x;
  const Lanes sine =
      x * polynomial(xx, {-1.0 / 39916800, 1.0 / 362880, -1.0 / 5040, 1.0 / 120, -1.0 / 6, 1.0});
  const Lanes cosine = polynomial(
      xx, {1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320, -1.0 / 720, 1.0 / 24, -0.5, 1.0});
  const auto across = toLanes(turn << 1) < Lanes(0.0);
  const Lanes signedSize = select(toLanes(turn) < Lanes(0.0), Lanes(-size), size);
  return {signedSize * select(across, Lanes(-sine), cosine),
          signedSize * select(across, cosine, sine)};
}

}  // namespace detail

/// Standard normal numbers, three for each lane, that belong to (seed, purpose, fibre, index); none
/// is larger than 6.8.
NW_INLINE Vec3<Lanes> normalTriples(std::uint64_t seed, Purpose purpose, const std::int64_t* fibre,
                                    const std::int32_t* index) {
  LaneWords f;
  std::memcpy(&f, fibre, sizeof f);
  const auto i = __builtin_convertvector(loadNumbers(index), LaneWords);
  const auto bits =
      philox({f, f >> 32, i, LaneWords{} + static_cast<std::uint32_t>(purpose)},
             {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  const auto [x, y] = detail::boxMuller(bits[0], bits[1]);
  return {x, y, detail::boxMuller(bits[2], bits[3])[0]};
}

}  // namespace nanoweft
