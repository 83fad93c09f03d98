/// Counter-based random numbers: a draw is a function of its key and counter alone, so it does not
/// depend on ranks, threads or history.
///
/// Philox4x32-10 of Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3"
/// (SC'11); checked against the authors' known answers in tests/unit.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace nanoweft {

inline std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                           std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = 0xD2511F53ull * counter[0];
    const std::uint64_t p1 = 0xCD9E8D57ull * counter[2];
    counter = {
        static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(p1),
        static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

/// What a draw is for, so that draws for different purposes never share a counter.
enum class Purpose : std::uint32_t {
  breakage = 1,
  perturbation = 2,
  stepEstimate = 3,
  errorEstimate = 4,
  links = 5,  ///< of the first kind of link
  heatKey = 6,
  heatVelocity = 7,
  heatSpin = 8,
  sceneKind = 9,
  scenePlace = 10,
  sceneShape = 11
};

/// For the links of a kind.
constexpr Purpose linksOfKind(int kind) {
  constexpr std::uint32_t apart = 256;
  return static_cast<Purpose>(static_cast<std::uint32_t>(Purpose::links) +
                              apart * static_cast<std::uint32_t>(kind));
}

/// 128 random bits that belong to (seed, purpose, fibre, index).
inline std::array<std::uint32_t, 4> randomBits(std::uint64_t seed, Purpose purpose,
                                               std::int64_t fibre, std::uint32_t index) {
  const auto f = static_cast<std::uint64_t>(fibre);
  return philox({static_cast<std::uint32_t>(f), static_cast<std::uint32_t>(f >> 32), index,
                 static_cast<std::uint32_t>(purpose)},
                {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
}

/// Two uniform numbers in (0, 1) that belong to (seed, purpose, fibre, index).
inline std::array<double, 2> uniformPair(std::uint64_t seed, Purpose purpose, std::int64_t fibre,
                                         std::uint32_t index) {
  const auto bits = randomBits(seed, purpose, fibre, index);
  auto unit = [](std::uint32_t high, std::uint32_t low) {
    const std::uint64_t mantissa = (static_cast<std::uint64_t>(high) << 32 | low) >> 12;
    return (static_cast<double>(mantissa) + 0.5) * 0x1p-52;
  };
  return {unit(bits[0], bits[1]), unit(bits[2], bits[3])};
}

/// Standard normal number that belongs to (seed, purpose, fibre, index), by Box and Muller.
inline double normalDraw(std::uint64_t seed, Purpose purpose, std::int64_t fibre,
                         std::uint32_t index) {
  constexpr double twoPi = 6.283185307179586476925287;
  const auto u = uniformPair(seed, purpose, fibre, index);
  return std::sqrt(-2.0 * std::log(u[0])) * std::cos(twoPi * u[1]);
}

}  // namespace nanoweft
