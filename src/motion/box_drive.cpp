#include "nanoweft/motion/box_drive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr const char* names[6] = {"x", "y", "z", "xy", "xz", "yz"};
constexpr const char* topic = "Periodic box";
constexpr const char* servoName = "deform_servo";
constexpr const char* turnedOverName = "deform_turned_over";
/// A stress that misses its target by this share of the largest target has reached it.
constexpr double reached = 0.02;

}  // namespace

void BoxDrive::Axis::read(Options& options, const UnitSystem& units, const std::string& name,
                          double least) {
  OptionSection s(options, topic);
  const std::string perTime = std::string("1/") + units.time;
  const std::string chosen = s.choice(
      name, "held", {"held", "rate", "program", "stress", "free"},
      least == -1 ? "what happens to the box along this axis; free: as stress with 0"
                  : "shear: what happens to the images across the second axis, which slide "
                    "along the first");
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
    legs.emplace(*pairs, std::nullopt, "-" + name + "_program", least);
    legs->begin(0.0, 0.0);
  }
  if (until != 0 && (until > 0) != (rate > 0))
    throw InputError(
        format("-%s_until %g: the rate %g leads away from it", name.c_str(), until, rate));
  if (until <= least)
    throw InputError(format("-%s_until %g: must be above -1", name.c_str(), until));
}

double BoxDrive::Axis::nextLength(double length, double start, double time, double dt,
                                  double grown) const {
  if (mode == program) return start * (1.0 + legs->strain(time + dt));
  const double next = length + dt * (mode == BoxDrive::rate ? grown * rate : rate) * start;
  const double end = (1.0 + until) * start;
  return until != 0 && (rate > 0 ? next > end : next < end) ? end : next;
}

double BoxDrive::Axis::nextShear(double strain, double time, double dt, double grown) const {
  if (mode == program) return legs->strain(time + dt);
  const double next = strain + dt * (mode == BoxDrive::rate ? grown * rate : rate);
  return until != 0 && (rate > 0 ? next > until : next < until) ? until : next;
}

std::string BoxDrive::Axis::text(const char* time) const {
  return mode == BoxDrive::rate ? format("strained at %g 1/%s", rate, time)
         : mode == program      ? "strain " + legs->text() + " 1/" + time
                                : format("driven to %g GPa", target);
}

bool BoxDrive::Axis::strains(double strain, double time) const {
  if (mode == program) return time < legs->end();
  // The box's length is that of its strain but for round-off.
  return mode == BoxDrive::rate && (until == 0 || std::abs(strain - until) > 1e-9);
}

BoxDrive::BoxDrive(Options& options, const UnitSystem& units)
    : unit_(units.gigapascal), time_(units.time) {
  bool driven = false, rated = false;
  for (std::size_t d = 0; d < axes_.size(); ++d) {
    axes_[d].read(options, units, std::string("deform_") + names[d],
                  d < 3 ? -1.0 : -std::numeric_limits<double>::infinity());
    active_ = active_ || axes_[d].mode != held;
    driven = driven || axes_[d].mode == stress;
    rated = rated || axes_[d].mode == rate;
    if (d < 3 || axes_[d].mode == held) continue;
    if (sheared_ != none)
      throw InputError(format("-deform_%s, -deform_%s: the images slide along one pair of axes",
                              names[sheared_], names[d]));
    sheared_ = d;
  }
  const std::string perTime = std::string("1/") + units.time;
  OptionSection any(options, topic, active_, "no -deform_x, _y, _z, _xy, _xz or _yz");
  interval_ =
      any.integer("deform_interval", 20, "steps between measurements of the stress", 1, 1000000);
  OptionSection ofRates(options, topic, rated, "no direction is strained at a rate");
  ramp_ = ofRates.real("deform_ramp", 0.0, units.time,
                       "rates of strain grow linearly for this long", nonNegative);
  // A restart goes on with the thickness, whichever monitors it has.
  const bool measured =
      any.as(Role::run).given("box_monitor") || options.recorded("deform_thickness").has_value();
  OptionSection ofStress(options, topic, active_ || measured,
                         "the box is held, and there is no -box_monitor");
  thickness_ = ofStress.real("deform_thickness", 0.0, units.length,
                             "of a sheet, for stresses; 0: that of the box", nonNegative);
  OptionSection servo(options, topic, driven, "no direction is driven to a stress");
  servo_.modulus = servo.real("deform_modulus", 10.0, "GPa",
                              "the servo strains by the missing stress over this, or over the "
                              "stiffness where it overshoots",
                              positive);
  const auto relaxes = servo.maybeReal("deform_time", "2000", units.time, "in this time", positive);
  const auto most = servo.maybeReal("deform_most_rate", "1e-05", perTime.c_str(),
                                    "but no faster than this", positive);
  // The defaults are those of nanotubes in fs; thicker fibres are slower by what only users know.
  if (driven && units.name != "nano" && !(relaxes && most))
    throw InputError("-deform_time, -deform_most_rate: must be given with -units " + units.name +
                     ", where a direction is driven to a stress");
  servo_.time = relaxes.value_or(2000.0);
  servo_.mostRate = most.value_or(1e-5);
}

bool BoxDrive::carries(int axis) const {
  return axes_[static_cast<std::size_t>(axis)].mode != held ||
         (sheared_ != none && Tilt::ofPair(static_cast<int>(sheared_) - 3, 0.0).along == axis);
}

const char* BoxDrive::shears() const {
  return sheared_ == none ? nullptr : names[sheared_];
}

std::string BoxDrive::text() const {
  std::string text;
  for (std::size_t d = 0; d < axes_.size(); ++d) {
    if (axes_[d].mode == held) continue;
    text += (text.empty() ? "" : "; ") + std::string(d < 3 ? "along " : "shear ") + names[d] + " ";
    text += axes_[d].text(time_);
  }
  return text;
}

void BoxDrive::attach(const Box& box, const RunRecord& record, bool restart) {
  for (std::size_t d = 0; d < 3; ++d) start_[d] = box.length(static_cast<int>(d));
  int open = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    if (!box.periodic[d]) ++open;
    if (!box.periodic[d] && axes_[d].mode != held)
      throw InputError(
          format("-deform_%s: the box is open along %s (-domain_periodic)", names[d], names[d]));
  }
  if (thickness_ > 0 && open != 1)
    throw InputError(
        "-deform_thickness: it is that of a sheet, whose box is open in one direction");
  if (!active_) return;
  if (sheared_ != none) attachShear(box, record, restart);
  if (!restart) return;
  const auto& numbers = record.needReals("deform", 12);
  for (std::size_t d = 0; d < 3; ++d) {
    start_[d] = numbers[d];
    stress_[d] = numbers[3 + d];
    since_[d] = numbers[6 + d];
    if (axes_[d].mode == stress) axes_[d].rate = numbers[9 + d];
  }
  // Checkpoints of earlier programs lack it.
  if (record.reals.contains(turnedOverName)) turnedOver_ = record.needReals(turnedOverName, 1)[0];
  attachServos(record);
}

bool BoxDrive::servoed() const {
  return std::ranges::any_of(axes_, [](const Axis& axis) { return axis.mode == stress; });
}

void BoxDrive::attachServos(const RunRecord& record) {
  if (!servoed()) return;
  const std::size_t each = BoxServo::Numbers{}.size();
  const auto& numbers = record.needReals(servoName, axes_.size() * each);
  for (std::size_t d = 0; d < axes_.size(); ++d) {
    BoxServo::Numbers own;
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(d * each), each, own.begin());
    axes_[d].servo.set(own);
  }
}

void BoxDrive::saveServos(RunRecord& record) const {
  if (!servoed()) return;
  auto& numbers = record.reals[servoName];
  for (const Axis& axis : axes_)
    for (const double number : axis.servo.numbers()) numbers.push_back(number);
}

void BoxDrive::attachShear(const Box& box, const RunRecord& record, bool restart) {
  const Tilt pair = Tilt::ofPair(static_cast<int>(sheared_) - 3, 0.0);
  for (const int d : {pair.along, pair.across})
    if (!box.periodic[static_cast<std::size_t>(d)])
      throw InputError(format("-deform_%s: the box is open along %s (-domain_periodic)",
                              names[sheared_], names[d]));
  if (box.tilt && box.tilt.place() != pair.place())
    throw InputError(format("-deform_%s: the box is tilted along %s already", names[sheared_],
                            names[3 + box.tilt.place()]));
  shear_ = shearStart_ = box.tilt.way / box.length(pair.across);
  if (!restart) return;
  const auto& numbers = record.needReals("deform_shear", 5);
  shear_ = numbers[0];
  shearStart_ = numbers[1];
  shearStress_ = numbers[2];
  shearSince_ = numbers[3];
  if (axes_[sheared_].mode == stress) axes_[sheared_].rate = numbers[4];
}

void BoxDrive::save(RunRecord& record) const {
  if (!active_) return;
  auto& numbers = record.reals["deform"];
  for (const auto* part : {&start_, &stress_, &since_})
    numbers.insert(numbers.end(), part->begin(), part->end());
  for (std::size_t d = 0; d < 3; ++d)
    numbers.push_back(axes_[d].mode == stress ? axes_[d].rate : 0.0);
  record.reals[turnedOverName] = {turnedOver_};
  saveServos(record);
  if (sheared_ == none) return;
  const Axis& axis = axes_[sheared_];
  record.reals["deform_shear"] = {shear_, shearStart_, shearStress_, shearSince_,
                                  axis.mode == stress ? axis.rate : 0.0};
}

std::array<double, 3> BoxDrive::strains(const Box& box) const {
  std::array<double, 3> strains;
  for (std::size_t d = 0; d < 3; ++d)
    strains[d] = box.length(static_cast<int>(d)) / start_[d] - 1.0;
  return strains;
}

bool BoxDrive::underWay(const Box& box, double time) const {
  const auto strain = strains(box);
  double largest = 0, missing = 0;
  auto strained = [&](const Axis& axis, double own, double now) {
    if (axis.mode == stress) {
      largest = std::max(largest, std::abs(axis.target));
      missing = std::max(missing, std::abs(axis.target - now));
    }
    return axis.strains(own, time);
  };
  for (std::size_t d = 0; d < 3; ++d)
    if (strained(axes_[d], strain[d], stress_[d])) return true;
  if (sheared_ != none && strained(axes_[sheared_], shear(), shearStress_)) return true;
  // Without a target but zero nothing says which stress is large; the elastic energy does.
  return largest > 0 && missing > reached * largest;
}

const char* BoxDrive::endless() const {
  for (std::size_t d = 0; d < axes_.size(); ++d)
    if (axes_[d].mode == rate && axes_[d].until == 0) return names[d];
  return nullptr;
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
  const double grown = ramp_ > 0 && time < ramp_ ? time / ramp_ : 1.0;
  double work = stretch(state, forces, time, dt, grown);
  if (sheared_ != none) work += slide(state, forces, time, dt, grown);
  if (state.rank() == 0) external.add(work, forces.energyUnit());
}

double BoxDrive::measuredVolume(const Box& box) const {
  return volume(box) * std::exp(-(since_[0] + since_[1] + since_[2]));
}

double BoxDrive::stretch(State& state, ForceField& forces, double time, double dt, double grown) {
  const double then = measuredVolume(state.box);
  factor_ = {1, 1, 1};
  double work = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    const Axis& axis = axes_[d];
    if (axis.mode == held) continue;
    const double length = state.box.length(static_cast<int>(d)),
                 next = axis.nextLength(length, start_[d], time, dt, grown);
    if (next == length) continue;
    factor_[d] = next / length;
    const double middle = 0.5 * (state.box.lower[d] + state.box.upper[d]);
    state.box.lower[d] = middle - 0.5 * next;
    state.box.upper[d] = middle + 0.5 * next;
    work += then * unit_ * stress_[d] * std::log(factor_[d]);
    since_[d] += std::log(factor_[d]);
    for (int i = 0; i < state.owned(); ++i) {
      double& x = state.pose[8 * static_cast<std::size_t>(i) + d];
      x = middle + factor_[d] * (x - middle);
    }
  }
  if (factor_ == std::array<double, 3>{1, 1, 1}) return work;
  state.box.tilt.way *= factor_[static_cast<std::size_t>(state.box.tilt.along)];
  if (sheared_ != none) {
    const Tilt pair = Tilt::ofPair(static_cast<int>(sheared_) - 3, 0.0);
    const double stretched = factor_[static_cast<std::size_t>(pair.along)] /
                             factor_[static_cast<std::size_t>(pair.across)];
    // The slide of the start is stretched likewise, which is no shear.
    shear_ *= stretched, shearStart_ *= stretched;
  }
  for (int i = 0; i < state.owned(); ++i) state.box.wrap(state.pose + 8 * i, state.image + 3 * i);
  forces.stretch(state.box, factor_);
  return work;
}

double BoxDrive::slide(State& state, ForceField& forces, double time, double dt, double grown) {
  const double next = axes_[sheared_].nextShear(shear(), time, dt, grown);
  slid_ = next - shear();
  if (slid_ == 0) return 0;
  Box& box = state.box;
  const Tilt old = Tilt::ofPair(static_cast<int>(sheared_) - 3, box.tilt.way);
  const double middle = 0.5 * (box.lower[static_cast<std::size_t>(old.across)] +
                               box.upper[static_cast<std::size_t>(old.across)]);
  const double across = box.length(old.across), along = box.length(old.along);
  // The tilt that leads to the nearest of the images, which all are the same, is the least one.
  const double turnsThen = std::nearbyint((shear_ * across - old.way) / along);
  shear_ = shearStart_ + next;
  const double turns = std::nearbyint(shear_ * across / along);
  box.tilt = old;
  box.tilt.way = shear_ * across - turns * along;
  const auto more = static_cast<std::int32_t>(turns - turnsThen);
  for (int i = 0; i < state.owned(); ++i) {
    double* const x = state.pose + 8 * i;
    x[old.along] += slid_ * (x[old.across] - middle);
    std::int32_t* const image = state.image + 3 * i;
    image[old.along] += more * image[old.across];
    box.wrap(x, image);
  }
  forces.shear(box, slid_);
  // A stretch and then a slide equal half the stretch, this slide, and the other half.
  const double centred = slid_ * std::sqrt(factor_[static_cast<std::size_t>(old.across)] /
                                           factor_[static_cast<std::size_t>(old.along)]);
  shearSince_ += centred;
  return measuredVolume(box) * unit_ * shearStress_ * centred;
}

void BoxDrive::strainVelocities(State& state) const {
  if (sheared_ != none && slid_ != 0) {
    const Tilt pair = Tilt::ofPair(static_cast<int>(sheared_) - 3, 0.0);
    for (int i = 0; i < state.owned(); ++i)
      state.velocity[3 * i + pair.along] -= slid_ * state.velocity[3 * i + pair.across];
  }
  for (std::size_t d = 0; d < 3; ++d) {
    if (factor_[d] == 1) continue;
    for (int i = 0; i < state.owned(); ++i)
      state.velocity[3 * static_cast<std::size_t>(i) + d] /= factor_[d];
  }
}

void BoxDrive::note(const State& state, const ForceField& forces,
                    const std::array<double, 9>& stress, double dt, ExactSum& external) {
  // Steps have booked the stress at the last measurement; the mean of both is right to second
  // order.
  double work = 0;
  const double volumeNow = volume(state.box), volumeThen = measuredVolume(state.box);
  servo_.interval = static_cast<double>(interval_) * dt;
  // Rates are those of a strain that is `scale` times the one since then.
  auto see = [&](Axis& axis, double now, double& then, double& since, double scale) {
    work += 0.5 * unit_ * (volumeNow * now - volumeThen * then) * since;
    turnedOver_ +=
        0.5 * unit_ * (volumeNow * std::abs(now) + volumeThen * std::abs(then)) * std::abs(since);
    if (axis.mode == BoxDrive::stress)
      axis.rate = axis.servo.rate(servo_, {axis.target - then, axis.target - now, scale * since});
    then = now;
    since = 0;
  };
  for (std::size_t d = 0; d < 3; ++d)
    see(axes_[d], stress[d], stress_[d], since_[d],
        state.box.length(static_cast<int>(d)) / start_[d]);
  // Force along the one axis through the face across the other.
  if (sheared_ != none) see(axes_[sheared_], stress[3 + sheared_], shearStress_, shearSince_, 1.0);
  if (state.rank() == 0) external.add(work, forces.energyUnit());
}

}  // namespace nanoweft
