#include "nanoweft/motion/tension.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/gather.hpp"

namespace nanoweft {

double Tension::strain(double time) const {
  if (program) return program->strain(time);
  const double t = time - start;
  if (t <= 0) return before;
  return before + (t < ramp ? rate * t * t / (2.0 * ramp) : rate * (t - 0.5 * ramp));
}

bool Tension::over(double time) const {
  if (program) return time >= program->end();
  return rate > 0 ? strain(time) >= maxStrain : strain(time) <= maxStrain;
}

double Tension::timeLeft(double time) const {
  return program ? program->end() - time : (maxStrain - strain(time)) / rate;
}

double Tension::peakRate() const {
  const double share = 2.0 * (maxStrain - before) / (rate * ramp);
  return share < 1.0 ? std::sqrt(share) * rate : rate;
}

bool Tension::presses() const {
  const double lowest = program ? program->lowest() : maxStrain,
               highest = program ? program->highest() : maxStrain;
  return std::max(highest, before) <= 0 && std::min(lowest, before) < 0;
}

namespace {

/// Which grips hold a segment of a fibre: 1 left, 2 right, 3 both. Collective; known to rank 0
/// alone unless `everywhere`.
std::map<std::int64_t, int> gripsOfFibres(const State& state, bool everywhere) {
  std::map<std::int64_t, int> grips;
  for (int i = 0; i < state.owned(); ++i)
    if (const int held = state.group[i] >> leftGripBit & 3; held) grips[state.fibre[i]] |= held;
  const std::vector<std::pair<std::int64_t, int>> mine(grips.begin(), grips.end());
  for (const auto& [fibre, held] : ofAllRanks(mine, state.comm(), everywhere)) grips[fibre] |= held;
  return grips;
}

/// Distance of the innermost segments that the grips hold, of the kind where it is largest; fibres
/// that both hold count, if there are any. 0: a grip holds none.
double distanceOfGrips(const State& state, int axis) {
  const auto grips = gripsOfFibres(state, true);
  const bool across = std::ranges::any_of(grips, [](const auto& f) { return f.second == 3; });
  // Of each kind, by the left and by the right grip, whose place is negated.
  std::vector<std::array<double, 2>> inner(
      std::max<std::size_t>(state.kinds.size(), 1),
      {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()});
  for (int i = 0; i < state.owned(); ++i)
    for (const std::size_t side : {0u, 1u}) {
      if (!(state.group[i] & 1 << (side == 0 ? leftGripBit : rightGripBit))) continue;
      if (across && grips.at(state.fibre[i]) != 3) continue;
      const double x = state.pose[8 * i + axis];
      double& place = inner[static_cast<std::size_t>(state.kind(i))][side];
      place = std::max(place, side == 0 ? x : -x);
    }
  MPI_Allreduce(MPI_IN_PLACE, inner.data(), 2 * static_cast<int>(inner.size()), MPI_DOUBLE, MPI_MAX,
                state.comm());
  double largest = 0;
  for (const auto& [left, right] : inner)
    if (const double apart = -right - left; std::isfinite(apart))
      largest = std::max(largest, apart);
  return largest;
}

constexpr const char* noTest = "there is no tension test without -tension_rate or -tension_program";

/// What differs between a test with one rate and one with a program.
void readCourse(Options& options, const OptionSection& section, bool wanted,
                const UnitSystem& units, Tension& t) {
  OptionSection s = section;
  const std::string perTime = std::string("1/") + units.time;
  const auto legs = s.reals("tension_program", 0, "none", perTime.c_str(),
                            "strain,rate,strain,rate,...: goes to each strain at its rate, one "
                            "after the other; instead of -tension_rate");
  OptionSection one(options, "Tension test", wanted && !legs,
                    legs ? "-tension_program says the rates and where the test ends" : noTest);
  const auto rate =
      one.maybeReal("tension_rate", "none", perTime.c_str(),
                    "engineering strain rate, below zero to press; turns the test on");
  if (rate && *rate == 0) throw InputError("-tension_rate 0: nothing would be pulled");
  t.rate = rate.value_or(2e8 * units.secondsPerTime);
  const auto ramp =
      s.maybeReal("tension_ramp", "0.01 strain at full rate", units.time,
                  "time of constant acceleration at the start, or at both ends of each leg of a "
                  "program",
                  nonNegative);
  t.ramp = ramp.value_or(0.01 / std::abs(t.rate));
  const auto most = one.as(Role::run).maybeReal("tension_max_strain", "0.5, or -0.5", "",
                                                "strain at which the run ends",
                                                Bounds{.lower = -1.0, .openLower = true});
  t.maxStrain = most.value_or(std::copysign(0.5, t.rate));
  if (legs) t.program.emplace(*legs, ramp);
}

}  // namespace

std::optional<Tension> readTension(Options& options, const UnitSystem& units, const Kinds& kinds,
                                   double restDistance) {
  OptionSection ask(options, "Tension test");
  const bool wanted = ask.given("tension_rate") || ask.given("tension_program");
  OptionSection s(options, "Tension test", wanted, noTest);
  Tension t;
  t.unit = units.length;
  const std::string axis =
      s.choice("tension_axis", "x", {"x", "y", "z"}, "direction in which the grips part");
  t.axis = axis[0] - 'x';
  if (s.given("tension_axis")) t.asked.axis = t.axis;
  readCourse(options, s, wanted, units, t);
  t.asked.grip = s.maybeReal("tension_grip", "10 rf", units.length,
                             "length of each grip, from the ends of the piece inwards", positive);
  t.grip = t.asked.grip.value_or(10.0 * kinds.thickest());
  if (const auto ends = s.reals("tension_ends", 2, "its outermost segments", units.length,
                                "where the piece ends; what lies beyond is held by the grips")) {
    t.asked.ends = {(*ends)[0], (*ends)[1]};
    if (!((*ends)[0] < (*ends)[1]))
      throw InputError(
          format("-tension_ends %g,%g: the lower end comes first", (*ends)[0], (*ends)[1]));
  }
  t.ends = t.asked.ends;
  t.asked.width = s.maybeReal("tension_width", "measured at the start", units.length,
                              "width of the fabric, for the stress; what is measured reaches from "
                              "axis to axis of the outermost fibres",
                              positive);
  t.width = t.asked.width.value_or(0.0);
  t.asked.thickness = s.maybeReal(
      "tension_thickness",
      "2 rf + 3.54 A for carbon tubes by name (17.1 A for cnt_10_10), else the rest distance",
      units.length, "thickness of the fabric, for the stress", positive);
  const double sheet = kinds[0].sheet;
  const double usual = kinds.several() ? 0.0 : sheet > 0 ? sheet : restDistance;
  t.thickness = t.asked.thickness.value_or(usual);
  t.fresh =
      s.flag("tension_new", false,
             "a test of its own, even when the state that the run starts from has been pulled "
             "before");
  t.lateral = s.flag("tension_lateral", false,
                     "the lateral strain, in a column of -stress_monitor's table");
  return wanted ? std::optional(t) : std::nullopt;
}

void Tension::restore(const RunRecord& record) {
  takeUp(record);
  if (program) program->begin(start, before);
}

void Tension::takeUp(const RunRecord& record) {
  const auto& piece = record.needReals("tension", 3);
  start = piece[0];
  gage = piece[1];
  width = piece[2];
  before = record.needReals("tension_strain", 2)[0];
  axis =
      static_cast<int>(std::clamp<std::int64_t>(record.needIntegers("tension_axis", 1)[0], 0, 2));
  grip = record.needReals("tension_grip", 1)[0];
  thickness = record.needReals("tension_thickness", 1)[0];
  const auto& both = record.needReals("tension_ends", 2);
  ends = {both[0], both[1]};
  if (lateral && !record.reals.contains("tension_lateral"))
    throw InputError("-tension_lateral: the tension test that " + record.source +
                     " carries has been made without it; start a test of its own with "
                     "-tension_new");
  if (lateral) spread = record.needReals("tension_lateral", 1)[0];
}

void Tension::goOn(const RunRecord& record, double time) {
  takeUp(record);
  start = time;
  before = record.needReals("tension_strain", 2)[1];
  if (program) program->begin(start, before);
  auto contradicted = [&](const char* option, const std::string& own, const std::string& old) {
    throw InputError(format(
        "-%s %s: %s carries a tension test with %s, which goes on; leave the option out, or start "
        "a test of its own with -tension_new",
        option, own.c_str(), record.source.c_str(), old.c_str()));
  };
  // Options are given in decimal, what the earlier stage measured may differ in the last bit.
  auto compare = [&](const char* option, const std::optional<double>& own, double old) {
    if (own && std::abs(*own - old) > 1e-9 * std::abs(old))
      contradicted(option, canonical(*own), canonical(old));
  };
  if (asked.axis && *asked.axis != axis)
    contradicted("tension_axis", std::string(1, "xyz"[*asked.axis]), std::string(1, "xyz"[axis]));
  compare("tension_grip", asked.grip, grip);
  compare("tension_width", asked.width, width);
  compare("tension_thickness", asked.thickness, thickness);
  if (asked.ends)
    for (std::size_t k = 0; k < 2; ++k)
      if (std::abs((*asked.ends)[k] - (*ends)[k]) > 1e-9 * (gage + 2.0 * grip))
        contradicted("tension_ends", canonical(std::vector{(*asked.ends)[0], (*asked.ends)[1]}),
                     canonical(std::vector{(*ends)[0], (*ends)[1]}));
}

void Tension::requireEnds(const Box& box) const {
  if (box.periodic[static_cast<std::size_t>(axis)])
    throw InputError(format(
        "-tension_axis %c: the box is periodic in this direction, so there are no ends to grip",
        "xyz"[axis]));
  if (lateral && box.periodic[static_cast<std::size_t>(across())])
    throw InputError(
        format("-tension_lateral: the box is periodic along %c, so the width does not change",
               "xyz"[across()]));
}

void Tension::measure(State& state) {
  if (thickness == 0)
    throw InputError("-tension_thickness: with several kinds of fibre it has no default");
  const int through = 3 - axis - across();
  // Lower and negated upper ends: along, across, through the piece.
  double extent[6];
  std::fill_n(extent, 6, std::numeric_limits<double>::infinity());
  for (int i = 0; i < state.owned(); ++i) {
    const double along = state.pose[8 * i + axis], other = state.pose[8 * i + across()];
    extent[0] = std::min(extent[0], along);
    extent[1] = std::min(extent[1], -along);
    extent[2] = std::min(extent[2], other);
    extent[3] = std::min(extent[3], -other);
    extent[4] = std::min(extent[4], state.pose[8 * i + through]);
    extent[5] = std::min(extent[5], -state.pose[8 * i + through]);
  }
  MPI_Allreduce(MPI_IN_PLACE, extent, 6, MPI_DOUBLE, MPI_MIN, state.comm());
  const auto [lower, upper] = ends.value_or(std::array{extent[0], -extent[1]});
  ends = {lower, upper};
  start = state.time;
  gage = upper - lower - 2.0 * grip;
  if (!(gage > 0))
    throw InputError(format("-tension_grip %g: two grips leave nothing of the piece's %g %s", grip,
                            upper - lower, unit));
  if (width == 0) {
    width = state.box.periodic[static_cast<std::size_t>(across())] ? state.box.length(across())
                                                                   : -extent[3] - extent[2];
    if (!(width > 0))
      throw InputError("-tension_width: the piece has no width of its own; give one");
  }
  // Sheets lie across z, so that in a test along it the default can hardly be meant.
  if (const double thick = -extent[5] - extent[4];
      axis == 2 && !asked.thickness && thick > 3.0 * thickness)
    throw InputError(
        format("-tension_axis z: the piece is %.6g %s thick along %c, not %.4g; give "
               "-tension_thickness",
               thick, unit, "xyz"[through], thickness));
  // Grips are often some segments long: round-off must not decide on the last one.
  const double rim = 1e-6 * grip;
  for (int i = 0; i < state.owned(); ++i) {
    const double x = state.pose[8 * i + axis];
    if (x <= lower + grip + rim) state.group[i] |= 1 << leftGripBit;
    if (x >= upper - grip - rim) state.group[i] |= 1 << rightGripBit;
  }
  between = distanceOfGrips(state, axis);
  if (program) program->begin(start, before);
  if (lateral) measureSpread(state);
}

void Tension::measureSpread(const State& state) {
  spread = spreadAcross(state, *this);
  if (!(spread > 0))
    throw InputError(format("-tension_lateral: what lies between the grips has no width along %c",
                            "xyz"[across()]));
}

double spreadAcross(const State& state, const Tension& tension) {
  const auto d = static_cast<std::size_t>(tension.across());
  const double size =
      std::max({std::abs(state.box.lower[d]), std::abs(state.box.upper[d]), tension.grip});
  const SumUnit unit(size), unit2(size * size);
  auto mean = [&](const SumUnit& grid, auto term) {
    ExactSum sum;
    std::int64_t count = 0;
    for (int i = 0; i < state.owned(); ++i) {
      if (state.group[i] & (1 << leftGripBit | 1 << rightGripBit)) continue;
      sum.add(term(state.pose[8 * i + tension.across()]), grid);
      ++count;
    }
    ExactSum::reduce(&sum, 1, state.comm());
    MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT64_T, MPI_SUM, state.comm());
    return count > 0 ? sum.value(grid) / static_cast<double>(count) : 0.0;
  };
  const double middle = mean(unit, [](double x) { return x; });
  return std::sqrt(mean(unit2, [&](double x) { return (x - middle) * (x - middle); }));
}

HeldFibres heldFibres(const State& state) {
  HeldFibres count;
  for (const auto& [fibre, held] : gripsOfFibres(state, false))
    ++(held == 3 ? count.both : held == 2 ? count.right : count.left);
  return count;
}

void Tension::save(RunRecord& record, double time) const {
  record.reals["tension"] = {start, gage, width};
  record.reals["tension_strain"] = {before, strain(time)};
  record.integers["tension_axis"] = {axis};
  record.reals["tension_grip"] = {grip};
  record.reals["tension_thickness"] = {thickness};
  record.reals["tension_ends"] = {(*ends)[0], (*ends)[1]};
  if (lateral) record.reals["tension_lateral"] = {spread};
}

}  // namespace nanoweft
