#include "nanoweft/motion/box_drive.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr const char* names[3] = {"x", "y", "z"};
constexpr const char* topic = "Periodic box";

}  // namespace

void BoxDrive::Axis::read(Options& options, const UnitSystem& units, const std::string& name) {
  OptionSection s(options, topic);
  const std::string perTime = std::string("1/") + units.time;
  const std::string chosen =
      s.choice(name, "held", {"held", "rate", "program", "stress", "free"},
               "what happens to the box along this axis; free: as stress with 0");
  mode = chosen == "held"      ? held
         : chosen == "rate"    ? BoxDrive::rate
         : chosen == "program" ? program
                               : stress;
  auto of = [&](const char* which) {
    return OptionSection(options, topic, chosen == which, "-" + name + " is " + chosen);
  };
  OptionSection ofRate = of("rate"), ofProgram = of("program");
  rate = ofRate.real(name + "_rate", 0.0, perTime.c_str(), "its rate of strain");
  until = ofRate.real(name + "_until", 0.0, "", "strain at which it stops; 0: it does not");
  target = of("stress").real(name + "_stress", 0.0, "GPa", "the stress to which it is driven");
  const auto pairs = ofProgram.reals(name + "_program", 0, "none", (", " + perTime).c_str(),
                                     "strain, rate, strain, rate, ...: legs one after the other");
  if (mode == BoxDrive::rate && rate == 0)
    throw InputError("-" + name + " rate: give -" + name + "_rate");
  if (mode == program && !pairs)
    throw InputError("-" + name + " program: give -" + name + "_program");
  if (pairs) {
    legs.emplace(*pairs, std::nullopt, "-" + name + "_program");
    legs->begin(0.0, 0.0);
  }
  if (until != 0 && (until > 0) != (rate > 0))
    throw InputError(
        format("-%s_until %g: the rate %g leads away from it", name.c_str(), until, rate));
  if (until <= -1) throw InputError(format("-%s_until %g: must be above -1", name.c_str(), until));
}

double BoxDrive::Axis::nextLength(double length, double start, double time, double dt,
                                  double grown) const {
  if (mode == program) return start * (1.0 + legs->strain(time + dt));
  const double next = length + dt * (mode == BoxDrive::rate ? grown * rate : rate) * start;
  const double end = (1.0 + until) * start;
  return until != 0 && (rate > 0 ? next > end : next < end) ? end : next;
}

BoxDrive::BoxDrive(Options& options, const UnitSystem& units)
    : unit_(units.gigapascal), time_(units.time) {
  bool driven = false, rated = false;
  for (std::size_t d = 0; d < 3; ++d) {
    axes_[d].read(options, units, std::string("deform_") + names[d]);
    active_ = active_ || axes_[d].mode != held;
    driven = driven || axes_[d].mode == stress;
    rated = rated || axes_[d].mode == rate;
  }
  const std::string perTime = std::string("1/") + units.time;
  OptionSection any(options, topic, active_, "no -deform_x, _y or _z");
  interval_ =
      any.integer("deform_interval", 20, "steps between measurements of the stress", 1, 1000000);
  OptionSection ofRates(options, topic, rated, "no direction is strained at a rate");
  ramp_ = ofRates.real("deform_ramp", 0.0, units.time,
                       "rates of strain grow linearly for this long", nonNegative);
  thickness_ = any.real("deform_thickness", 0.0, units.length,
                        "of a sheet, for stresses; 0: that of the box", nonNegative);
  OptionSection servo(options, topic, driven, "no direction is driven to a stress");
  modulus_ = servo.real("deform_modulus", 10.0, "GPa",
                        "the servo strains by the missing stress over this", positive);
  relaxes_ = servo.real("deform_time", 2000.0, units.time, "in this time", positive);
  most_ =
      servo.real("deform_most_rate", 1e-5, perTime.c_str(), "but no faster than this", positive);
}

std::string BoxDrive::text() const {
  std::string text;
  for (std::size_t d = 0; d < 3; ++d) {
    const Axis& axis = axes_[d];
    if (axis.mode == held) continue;
    text += (text.empty() ? "" : "; ") + std::string("along ") + names[d] + " ";
    text += axis.mode == rate      ? format("strained at %g 1/%s", axis.rate, time_)
            : axis.mode == program ? "strain " + axis.legs->text() + " 1/" + time_
                                   : format("driven to %g GPa", axis.target);
  }
  return text;
}

void BoxDrive::attach(const Box& box, const RunRecord& record, bool restart) {
  if (!active_) return;
  int open = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    if (!box.periodic[d]) ++open;
    if (!box.periodic[d] && axes_[d].mode != held)
      throw InputError(
          format("-deform_%s: the box is open along %s (-domain_periodic)", names[d], names[d]));
    start_[d] = box.length(static_cast<int>(d));
  }
  if (thickness_ > 0 && open != 1)
    throw InputError(
        "-deform_thickness: it is that of a sheet, whose box is open in one direction");
  if (!restart) return;
  const auto& numbers = record.needReals("deform", 12);
  for (std::size_t d = 0; d < 3; ++d) {
    start_[d] = numbers[d];
    stress_[d] = numbers[3 + d];
    since_[d] = numbers[6 + d];
    if (axes_[d].mode == stress) axes_[d].rate = numbers[9 + d];
  }
}

void BoxDrive::save(RunRecord& record) const {
  if (!active_) return;
  auto& numbers = record.reals["deform"];
  for (const auto* part : {&start_, &stress_, &since_})
    numbers.insert(numbers.end(), part->begin(), part->end());
  for (const Axis& axis : axes_) numbers.push_back(axis.mode == stress ? axis.rate : 0.0);
}

std::array<double, 3> BoxDrive::strains(const Box& box) const {
  std::array<double, 3> strains;
  for (std::size_t d = 0; d < 3; ++d)
    strains[d] = box.length(static_cast<int>(d)) / start_[d] - 1.0;
  return strains;
}

double BoxDrive::volume(const Box& box) const {
  double volume = 1;
  for (int d = 0; d < 3; ++d)
    volume *=
        thickness_ > 0 && !box.periodic[static_cast<std::size_t>(d)] ? thickness_ : box.length(d);
  return volume;
}

void BoxDrive::strain(State& state, ForceField& forces, double time, double dt,
                      ExactSum& external) {
  if (!active_) return;
  const double grown = ramp_ > 0 && time < ramp_ ? time / ramp_ : 1.0, before = volume(state.box);
  std::array<double, 3> factor{1, 1, 1};
  double work = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    const Axis& axis = axes_[d];
    if (axis.mode == held) continue;
    const double length = state.box.length(static_cast<int>(d)),
                 next = axis.nextLength(length, start_[d], time, dt, grown);
    if (next == length) continue;
    factor[d] = next / length;
    const double middle = 0.5 * (state.box.lower[d] + state.box.upper[d]);
    state.box.lower[d] = middle - 0.5 * next;
    state.box.upper[d] = middle + 0.5 * next;
    work += before * unit_ * stress_[d] * std::log(factor[d]);
    since_[d] += std::log(factor[d]);
    for (int i = 0; i < state.owned(); ++i) {
      double& x = state.pose[8 * static_cast<std::size_t>(i) + d];
      x = middle + factor[d] * (x - middle);
      state.velocity[3 * static_cast<std::size_t>(i) + d] /= factor[d];
    }
  }
  if (factor == std::array<double, 3>{1, 1, 1}) return;
  for (int i = 0; i < state.owned(); ++i) state.box.wrap(state.pose + 8 * i, state.image + 3 * i);
  forces.stretch(state.box, factor);
  if (state.rank() == 0) external.add(work, forces.energyUnit());
}

void BoxDrive::note(const State& state, const ForceField& forces,
                    const std::array<double, 6>& stress, ExactSum& external) {
  // Steps have booked the stress at the last measurement; the mean of both is right to second
  // order.
  double work = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    work += 0.5 * volume(state.box) * unit_ * (stress[d] - stress_[d]) * since_[d];
    stress_[d] = stress[d];
    since_[d] = 0;
    if (Axis& axis = axes_[d]; axis.mode == BoxDrive::stress)
      axis.rate = std::clamp((axis.target - stress[d]) / (modulus_ * relaxes_), -most_, most_);
  }
  if (state.rank() == 0) external.add(work, forces.energyUnit());
}

}  // namespace nanoweft
