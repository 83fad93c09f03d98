#include "nanoweft/motion/strain_program.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

StrainProgram::StrainProgram(const std::vector<double>& pairs, std::optional<double> ramp,
                             const std::string& name, double least)
    : name_(name) {
  const std::string option = name + " " + canonical(pairs) + ": ";
  if (pairs.size() % 2 != 0)
    throw InputError(option + "expected pairs of strain and rate, but the number of values is odd");
  for (std::size_t k = 0; k < pairs.size(); k += 2) {
    const double target = pairs[k], speed = pairs[k + 1];
    if (!(target > least))
      throw InputError(option + format("strain %g: at -1 the grips meet", target));
    if (!(speed > 0))
      throw InputError(option +
                       format("rate %g: rates are positive, the strains say which way", speed));
    if (!legs_.empty() && target == legs_.back().target)
      throw InputError(option + format("strain %g twice in a row: that leg leads nowhere", target));
    legs_.push_back({target, speed, ramp.value_or(0.01 / speed)});
  }
}

void StrainProgram::begin(double time, double strain) {
  if (legs_.front().target == strain)
    throw InputError(
        format("%s: the test is at its first strain, %g, when it begins", name_.c_str(), strain));
  for (Leg& leg : legs_) {
    leg.start = time;
    leg.from = strain;
    const double way = std::abs(leg.target - strain);
    double speed = leg.speed;
    if (speed * leg.ramp > way) {
      const double shorter = std::sqrt(way * leg.ramp / speed);
      speed *= shorter / leg.ramp;
      leg.ramp = shorter;
    }
    leg.duration = way / speed + leg.ramp;
    leg.peak = std::copysign(speed, leg.target - strain);
    time += leg.duration;
    strain = leg.target;
  }
}

const StrainProgram::Leg& StrainProgram::at(double time) const {
  const auto next = std::ranges::upper_bound(legs_, time, {}, &Leg::start);
  return next == legs_.begin() ? *next : *(next - 1);
}

double StrainProgram::strain(double time) const {
  const Leg& leg = at(time);
  const double t = time - leg.start, left = leg.duration - t;
  if (t <= 0) return leg.from;
  if (left <= 0) return leg.target;
  if (t < leg.ramp) return leg.from + leg.peak * t * t / (2.0 * leg.ramp);
  if (left < leg.ramp) return leg.target - leg.peak * left * left / (2.0 * leg.ramp);
  return leg.from + leg.peak * (t - 0.5 * leg.ramp);
}

double StrainProgram::rate(double time) const {
  const Leg& leg = at(time);
  const double t = time - leg.start, nearest = std::min(t, leg.duration - t);
  if (nearest <= 0) return 0;
  return nearest < leg.ramp ? leg.peak * nearest / leg.ramp : leg.peak;
}

double StrainProgram::highest() const {
  return std::ranges::max(legs_, {}, &Leg::target).target;
}

double StrainProgram::lowest() const {
  return std::ranges::min(legs_, {}, &Leg::target).target;
}

std::string StrainProgram::text() const {
  std::string text;
  for (const Leg& leg : legs_) {
    text += format("%s%g at %g", text.empty() ? "" : ", then ", leg.target, leg.speed);
    if (const double peak = std::abs(leg.peak); peak > 0 && peak < (1.0 - 1e-9) * leg.speed)
      text += format(" (%.3g at most: the way is short for its ramp)", peak);
  }
  return text;
}

}  // namespace nanoweft
