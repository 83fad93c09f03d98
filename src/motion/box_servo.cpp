#include "nanoweft/motion/box_servo.hpp"

#include <algorithm>
#include <cmath>

namespace nanoweft {

namespace {

/// What is left of the sums after another interval.
constexpr double kept = 7.0 / 8.0;
/// By which the viscosity falls at each measurement while the stress stays on one side.
constexpr double eased = 15.0 / 16.0;
/// Share of the squared rises of the stress that the strain must explain.
constexpr double explained = 0.85;
/// Strains below this part of the largest tell nothing of the stiffness.
constexpr double tiny = 0.01;

}  // namespace

double BoxServo::rate(const Law& law, const Measurement& measured) {
  learn(law, measured);
  adapt(law, measured);
  return std::clamp(measured.now / viscosity_, -law.mostRate, law.mostRate);
}

void BoxServo::learn(const Law& law, const Measurement& m) {
  if (std::abs(m.strained) <= tiny * law.mostRate * law.interval) return;
  const double rise = m.before - m.now;
  work_ = kept * work_ + rise * m.strained;
  strains_ = kept * strains_ + m.strained * m.strained;
  rises_ = kept * rises_ + rise * rise;
}

void BoxServo::adapt(const Law& law, const Measurement& m) {
  const bool passed = m.before * m.now <= 0;
  viscosity_ = std::max(law.modulus * law.time, passed ? viscosity_ : eased * viscosity_);
  // Where stress changes by itself, a box that merely follows it is not to blame.
  if (!passed || work_ <= 0 || work_ * work_ < explained * strains_ * rises_) return;
  const double stiffness = work_ / strains_;
  if (stiffness * law.interval > viscosity_)
    viscosity_ = stiffness * std::max(law.time, 2.0 * law.interval);
}

}  // namespace nanoweft
