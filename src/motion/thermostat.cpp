#include "nanoweft/motion/thermostat.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/normal_lanes.hpp"

namespace nanoweft {

namespace {

/// Which of the six components of velocity and spin a boundary holds, as bits.
unsigned heldOf(const Boundaries& boundaries, std::int32_t group) {
  unsigned held = 0;
  for (const Boundary& b : boundaries.list()) {
    if (!(group >> b.bit & 1)) continue;
    for (unsigned c = 0; c < 3; ++c) held |= static_cast<unsigned>(b.fix[c]) << c;
    if (b.fixRotation) held |= 070;
  }
  return held;
}

/// The segments of a SIMD group; where there are fewer, the last one stands in for those that are
/// missing.
struct Group {
  std::int32_t at[laneCount], index[laneCount];
  std::int64_t fibre[laneCount];
  int count;

  Group(const State& state, std::int32_t begin, std::int32_t end) : count(end - begin) {
    for (int k = 0; k < laneCount; ++k) {
      const std::int32_t i = begin + std::min(k, count - 1);
      at[k] = i;
      fibre[k] = state.fibre[i];
      index[k] = state.chain[2 * i];
    }
  }

  template <class Of>
  NW_INLINE Lanes lanes(const Of& of) const {
    return Lanes([&](auto k) { return of(static_cast<int>(k)); });
  }
};

/// keep v + size xi in a component that is not held; returns what the square of v gains.
NW_INLINE Lanes exchange(const Group& group, double* v, double keep, const Lanes& part,
                         const unsigned* held, unsigned bit) {
  const Lanes before = group.lanes([&](int k) { return v[3 * group.at[k]]; });
  Lanes after = multiplyAdd(Lanes(keep), before, part);
  if (held) {
    const Lanes free = group.lanes([&](int k) { return held[k] & bit ? 0.0 : 1.0; });
    after = select(free > Lanes(0.5), after, before);
  }
  for (int k = 0; k < group.count; ++k) v[3 * group.at[k]] = after[static_cast<std::size_t>(k)];
  return (after - before) * (after + before);
}

}  // namespace

std::optional<Thermostat> readThermostat(Options& options, const UnitSystem& units,
                                         std::uint64_t seed, const std::string& refusal) {
  OptionSection s(options, "Temperature", refusal.empty(), refusal);
  const std::string rate = std::string("1/") + units.time;
  const auto kelvin = s.maybeReal("temperature", "none", "K",
                                  "Langevin thermostat of this temperature", nonNegative);
  OptionSection bath(options, "Temperature", refusal.empty() && kelvin,
                     refusal.empty() ? "-temperature is not set" : refusal);
  const auto damping = bath.maybeReal(
      "temperature_damping", "none, must be given", rate.c_str(),
      "gamma of the thermostat: a free segment forgets its velocity as exp(-gamma t)", positive);
  const bool drawsStart = bath.flag("temperature_start", false,
                                    "draw the velocities of the start from this temperature");
  if (!kelvin || options.helpWanted()) return std::nullopt;
  if (!damping)
    throw InputError(
        format("-temperature %g: give -temperature_damping, too, the rate (%s) at which velocities "
               "follow the thermostat; %g lets the motion of stiff fibres be what it is",
               *kelvin, rate.c_str(), 1e12 * units.secondsPerTime));
  const double perKelvin = codata::boltzmann / codata::electronvolt * units.electronvolt;
  return Thermostat{*kelvin, perKelvin * *kelvin, *damping, drawsStart, seed};
}

HeatBath::HeatBath(State& state, const Kinds& kinds, const Boundaries& boundaries,
                   const Stroke& stroke)
    : state_(state), boundaries_(boundaries), keep_(stroke.keep), unit_(stroke.unit) {
  const double part = stroke.thermostat.thermal * (1.0 - keep_ * keep_);
  for (const Fibre& f : kinds)
    scales_.push_back(
        {0.5 * f.mass, 0.5 * f.inertia, std::sqrt(part / f.mass), std::sqrt(part / f.inertia)});
  // A key for each half step leaves the whole counter to fibre and index.
  const auto bits = randomBits(stroke.thermostat.seed, Purpose::heatKey, state.step, stroke.half);
  key_ = static_cast<std::uint64_t>(bits[1]) << 32 | bits[0];
}

void HeatBath::operator()(std::int32_t begin, std::int32_t end) {
  const Group group(state_, begin, end);
  unsigned heldBits[laneCount];
  const unsigned* held = nullptr;
  for (int k = 0; k < laneCount; ++k) {
    const std::int32_t bits = state_.group[group.at[k]];
    heldBits[k] = bits & boundaries_.mask() ? heldOf(boundaries_, bits) : 0;
    if (heldBits[k]) held = heldBits;
  }
  const Vec3<Lanes> velocity = normalTriples(key_, Purpose::heatVelocity, group.fibre, group.index);
  const Vec3<Lanes> spin = normalTriples(key_, Purpose::heatSpin, group.fibre, group.index);
  auto scale = [&](double Scale::*what) {
    return group.lanes([&](int k) { return scaleOf(group.at[k]).*what; });
  };
  const Lanes perVelocity = scale(&Scale::velocity), perSpin = scale(&Scale::spin);
  const Lanes v[3] = {velocity.x, velocity.y, velocity.z}, w[3] = {spin.x, spin.y, spin.z};
  Lanes gainV(0.0), gainW(0.0);
  for (int c = 0; c < 3; ++c) {
    gainV += exchange(group, state_.velocity + c, keep_, perVelocity * v[c], held, 1u << c);
    gainW += exchange(group, state_.angular + c, keep_, perSpin * w[c], held, 010u << c);
  }
  const Lanes heat = scale(&Scale::halfMass) * gainV + scale(&Scale::halfInertia) * gainW;
  const Lanes there = group.lanes([&](int k) { return static_cast<double>(k); });
  heat_.add(select(there < Lanes(group.count), heat, Lanes(0.0)), unit_);
}

void drawVelocities(State& state, const Kinds& kinds, const Boundaries& boundaries,
                    const Thermostat& thermostat) {
  HeatBath bath(state, kinds, boundaries, {thermostat, 0.0, HeatBath::start, SumUnit()});
  for (std::int32_t i = 0; i < state.owned(); i += laneCount)
    bath(i, std::min(i + laneCount, state.owned()));
}

}  // namespace nanoweft
