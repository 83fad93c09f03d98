/// When bonds break: at a critical strain that is a function of (seed, fibre, index) alone.
///
/// Strength belongs to a length, not to a bond. F is the distribution of a length of 2 rf; a bond
/// of length T has that of the weakest of T/(2 rf) such draws,
///
///     P = 1 - (1 - F)^(T/2rf),
///
/// so that a fibre is as strong however finely it is cut. F is normal, or Weibull's,
///
///     P = 1 - exp(-(L/L0) (strain/strain0)^m),   L: length of the bond or of the fibre.
///
/// With one draw per fibre, a small normal scatter along the fibre lets its weakest place go first.
#pragma once

#include <cstdint>
#include <optional>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"

namespace nanoweft {

struct BreakageLaw {
  bool weibull = false;
  double mean = 0.3, deviation = 0.05;               ///< of a length of 2 rf; normal law
  double shape = 7, strain0 = 0.3, length0 = 13.56;  ///< m, strain0, L0 of Weibull's law
  double bondLength = 13.56;                         ///< T
  double diameters = 1;                              ///< T/(2 rf)
  bool perFibre = false;                             ///< one draw per fibre instead of one per bond
  double scatter = 0;  ///< along a fibre with one draw: standard deviation over the draw
  std::uint64_t seed = 1;

  /// Critical strain of the bond from segment `index` of `fibre`, which has `segments` segments, to
  /// its successor.
  double criticalStrain(std::int64_t fibre, std::int32_t index, std::int32_t segments) const;
  /// The share of the draws (of bonds, or of fibres) that are below zero: these bonds break at
  /// once.
  double shareWithoutStrength() const;

 private:
  double normal(std::int64_t fibre, std::uint32_t counter, double draws) const;
};

/// x with P(X > x) = exp(logTail) for a standard normal X, to round-off; logTail < 0.
double normalQuantileOfTail(double logTail);

/// Breakage is on when any of its options is given.
std::optional<BreakageLaw> readBreakage(Options& options, const UnitSystem& units,
                                        const Fibre& fibre, std::uint64_t seed);

}  // namespace nanoweft
