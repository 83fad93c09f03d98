#include "nanoweft/motion/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr int mostNamed = 12;
static_assert(firstReservedGroupBit + mostNamed <= leftGripBit);

}  // namespace

double Tension::strain(double time) const {
  const double t = time - start;
  if (t <= 0) return before;
  return before + (t < ramp ? rate * t * t / (2.0 * ramp) : rate * (t - 0.5 * ramp));
}

Boundaries::Boundaries(Options& options, const UnitSystem& units, const Fibre& fibre,
                       double restDistance) {
  readNamed(options, units);
  readTension(options, units, fibre, restDistance);
}

void Boundaries::readNamed(Options& options, const UnitSystem& units) {
  const std::string speed = std::string(units.length) + "/" + units.time;
  OptionSection s(options, "Boundary conditions");
  const auto names =
      s.words("bc", "names of groups that something acts on, separated by commas; NAME below");
  s.document("NAME_region", "none", units.length,
             "members: x,y,z of the lower and of the upper corner");
  s.document("NAME_group", "none", "", "members: segments with this bit (0 to 15) of /state/group");
  s.document("NAME_fix", "0,0,0", "", "hold these components of the velocity at NAME_velocity");
  s.document("NAME_fix_rotation", "false", "", "keep the members from rotating");
  s.document("NAME_velocity", "0,0,0", speed.c_str(),
             "prescribed velocity (fixes all components unless NAME_fix says which)");
  s.document("NAME_force", "0,0,0", units.force, "force on each member");
  s.document("NAME_torque", "0,0,0", units.energy, "torque on each member");
  s.document("NAME_ramp", "0", units.time,
             "velocity, force and torque grow linearly for this long");
  if (names.size() > mostNamed) throw InputError(format("-bc: at most %d names", mostNamed));
  for (const std::string& name : names) {
    if (std::ranges::any_of(boundaries_, [&](const Boundary& b) { return b.name == name; }))
      throw InputError("-bc: " + name + " is named twice");
    if (name.starts_with("tension"))
      throw InputError("-bc " + name +
                       ": names that begin with tension belong to the tension test");
    readOneNamed(options, name);
  }
}

void Boundaries::readOneNamed(Options& options, const std::string& name) {
  OptionSection n = OptionSection(options, "Boundary conditions").family();
  Boundary b;
  b.name = name;
  if (auto r = n.reals(name + "_region", 6, "", "", "")) {
    b.region.emplace();
    std::ranges::copy(*r, b.region->begin());
    for (std::size_t d = 0; d < 3; ++d)
      if (!((*r)[d] <= (*r)[3 + d]))
        throw InputError(
            format("-%s_region: its lower corner must not lie above its upper one", name.c_str()));
  }
  const auto group = n.maybeInteger(name + "_group", "", "", 0, firstReservedGroupBit - 1);
  if (b.region.has_value() == group.has_value())
    throw InputError(format("-bc %s: give either -%s_region or -%s_group", name.c_str(),
                            name.c_str(), name.c_str()));
  b.bit = group ? static_cast<int>(*group)
                : firstReservedGroupBit + static_cast<int>(boundaries_.size());
  auto vector = [&](const char* suffix) {
    const auto v = n.reals(name + suffix, 3, "", "", "");
    return v ? std::optional(Vec3d{(*v)[0], (*v)[1], (*v)[2]}) : std::nullopt;
  };
  const auto fix = n.flags3(name + "_fix", "", "");
  const auto velocity = vector("_velocity"), force = vector("_force"), torque = vector("_torque");
  b.fix = fix.value_or(velocity ? std::array{true, true, true} : std::array{false, false, false});
  b.fixRotation = n.flag(name + "_fix_rotation", false, "");
  b.velocity = velocity.value_or(Vec3d{});
  b.force = force.value_or(Vec3d{});
  b.torque = torque.value_or(Vec3d{});
  b.ramp = n.real(name + "_ramp", 0.0, "", "", nonNegative);
  const double held[3] = {b.velocity.x, b.velocity.y, b.velocity.z};
  for (std::size_t d = 0; d < 3; ++d)
    if (held[d] != 0 && !b.fix[d])
      throw InputError(
          format("-%s_velocity: its %c component is not zero but -%s_fix does not hold it",
                 name.c_str(), "xyz"[d], name.c_str()));
  if (!b.constrains() && !force && !torque)
    throw InputError(format(
        "-bc %s: nothing acts on it; give -%s_fix, -%s_fix_rotation, -%s_velocity, -%s_force or "
        "-%s_torque",
        name.c_str(), name.c_str(), name.c_str(), name.c_str(), name.c_str(), name.c_str()));
  boundaries_.push_back(b);
}

void Boundaries::readTension(Options& options, const UnitSystem& units, const Fibre& fibre,
                             double restDistance) {
  OptionSection ask(options, "Tension test");
  const bool wanted =
      ask.given("tension_rate") || ask.given("tension_axis") || ask.given("tension_grip");
  OptionSection s(options, "Tension test", wanted,
                  "there is no tension test without -tension_rate");
  const std::string perTime = std::string("1/") + units.time;
  Tension t;
  const std::string axis =
      s.choice("tension_axis", "x", {"x", "y", "z"}, "direction in which the grips part");
  t.axis = axis[0] - 'x';
  if (s.given("tension_axis")) asked_.axis = t.axis;
  t.rate = s.maybeReal("tension_rate", "2e8 1/s", perTime.c_str(),
                       "engineering strain rate; turns the test on", positive)
               .value_or(2e8 * units.secondsPerTime);
  t.ramp = s.maybeReal("tension_ramp", "0.01 strain at full rate", units.time,
                       "time of constant acceleration at the start", nonNegative)
               .value_or(0.01 / t.rate);
  asked_.grip = s.maybeReal("tension_grip", "10 rf", units.length,
                            "length of each grip, from the ends of the piece inwards", positive);
  t.grip = asked_.grip.value_or(10.0 * fibre.radius);
  if (const auto ends = s.reals("tension_ends", 2, "its outermost segments", units.length,
                                "where the piece ends; what lies beyond is held by the grips")) {
    asked_.ends = {(*ends)[0], (*ends)[1]};
    if (!((*ends)[0] < (*ends)[1]))
      throw InputError(
          format("-tension_ends %g,%g: the lower end comes first", (*ends)[0], (*ends)[1]));
  }
  t.ends = asked_.ends;
  t.maxStrain =
      s.as(Role::run).real("tension_max_strain", 0.5, "", "strain at which the run ends", positive);
  asked_.width = s.maybeReal("tension_width", "measured at the start", units.length,
                             "width of the fabric, for the stress", positive);
  t.width = asked_.width.value_or(0.0);
  asked_.thickness =
      s.maybeReal("tension_thickness", "17.1 A for cnt_10_10, else the rest distance", units.length,
                  "thickness of the fabric, for the stress", positive);
  t.thickness = asked_.thickness.value_or(fibre.sheet > 0 ? fibre.sheet : restDistance);
  t.fresh =
      s.flag("tension_new", false,
             "a test of its own, even when the state that the run starts from has been pulled "
             "before");
  if (!wanted) return;
  tension_ = t;
}

void Boundaries::attach(State& state, const RunRecord& record, bool restart) {
  goesOn_ = !restart && tension_ && !tension_->fresh && record.reals.contains("tension");
  if (tension_ && restart) restoreTension(record);
  if (goesOn_) goOnWithTension(record, state.time);
  attachNamed(state, record, restart);
  if (tension_) {
    if (!restart && !goesOn_) attachTension(state);
    addGrips();
  }
  countMembers(state);
}

void Boundaries::attachNamed(State& state, const RunRecord& record, bool restart) {
  // Reserved bits mean what the run that set them says: only a restart or the same test keeps them.
  std::int32_t kept = (1 << firstReservedGroupBit) - 1;
  for (Boundary& b : boundaries_) {
    b.start = state.time;
    if (!restart) continue;
    b.start = record.needReals("boundary_" + b.name, 2)[1];
    kept |= 1 << b.bit;
  }
  if (tension_ && (restart || goesOn_)) kept |= 1 << leftGripBit | 1 << rightGripBit;
  for (int i = 0; i < state.owned(); ++i) {
    state.group[i] &= kept;
    for (const Boundary& b : boundaries_) {
      if (!b.region || restart) continue;
      bool inside = true;
      for (int d = 0; d < 3; ++d) {
        const double x = state.pose[8 * i + d];
        inside = inside && x >= (*b.region)[static_cast<std::size_t>(d)] &&
                 x <= (*b.region)[static_cast<std::size_t>(3 + d)];
      }
      if (inside) state.group[i] |= 1 << b.bit;
    }
  }
}

void Boundaries::addGrips() {
  for (int side = 0; side < 2; ++side) {
    Boundary grip;
    grip.name = side == 0 ? "tension_left" : "tension_right";
    grip.bit = side == 0 ? leftGripBit : rightGripBit;
    grip.fix = {true, true, true};
    grip.fixRotation = true;
    const double speed = (side == 0 ? -0.5 : 0.5) * tension_->rate * tension_->gage;
    (tension_->axis == 0   ? grip.velocity.x
     : tension_->axis == 1 ? grip.velocity.y
                           : grip.velocity.z) = speed;
    grip.ramp = tension_->ramp;
    grip.start = tension_->start;
    boundaries_.push_back(grip);
  }
}

void Boundaries::countMembers(const State& state) {
  for (const Boundary& b : boundaries_) {
    std::int64_t members = 0;
    for (int i = 0; i < state.owned(); ++i) members += state.group[i] >> b.bit & 1;
    MPI_Allreduce(MPI_IN_PLACE, &members, 1, MPI_INT64_T, MPI_SUM, state.comm());
    mask_ |= 1 << b.bit;
    if (members > 0) continue;
    if (b.bit < leftGripBit)
      throw InputError(format("-bc %s: no segment lies in its %s", b.name.c_str(),
                              b.region ? "region" : "group"));
    const char* side = b.bit == leftGripBit ? "lower" : "upper";
    if (!asked_.ends)
      throw InputError(
          format("tension test: no segment is marked as held by the %s grip (bit %d "
                 "of /state/group)",
                 side, b.bit));
    throw InputError(format("-tension_ends %g,%g: no segment lies in the %s grip",
                            (*asked_.ends)[0], (*asked_.ends)[1], side));
  }
}

void Boundaries::restoreTension(const RunRecord& record) {
  Tension& t = *tension_;
  const auto& piece = record.needReals("tension", 3);
  t.start = piece[0];
  t.gage = piece[1];
  t.width = piece[2];
  t.before = record.needReals("tension_strain", 2)[0];
  t.axis =
      static_cast<int>(std::clamp<std::int64_t>(record.needIntegers("tension_axis", 1)[0], 0, 2));
  t.grip = record.needReals("tension_grip", 1)[0];
  t.thickness = record.needReals("tension_thickness", 1)[0];
  const auto& ends = record.needReals("tension_ends", 2);
  t.ends = {ends[0], ends[1]};
}

void Boundaries::goOnWithTension(const RunRecord& record, double time) {
  restoreTension(record);
  Tension& t = *tension_;
  t.start = time;
  t.before = record.needReals("tension_strain", 2)[1];
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
  if (asked_.axis && *asked_.axis != t.axis)
    contradicted("tension_axis", std::string(1, "xyz"[*asked_.axis]),
                 std::string(1, "xyz"[t.axis]));
  compare("tension_grip", asked_.grip, t.grip);
  compare("tension_width", asked_.width, t.width);
  compare("tension_thickness", asked_.thickness, t.thickness);
  if (asked_.ends)
    for (std::size_t k = 0; k < 2; ++k)
      if (std::abs((*asked_.ends)[k] - (*t.ends)[k]) > 1e-9 * (t.gage + 2.0 * t.grip))
        contradicted("tension_ends", canonical(std::vector{(*asked_.ends)[0], (*asked_.ends)[1]}),
                     canonical(std::vector{(*t.ends)[0], (*t.ends)[1]}));
}

void Boundaries::attachTension(State& state) {
  Tension& t = *tension_;
  const int across = t.axis == 0 ? 1 : 0;
  // lower and negated upper ends, along and across.
  double extent[4];
  std::fill_n(extent, 4, std::numeric_limits<double>::infinity());
  for (int i = 0; i < state.owned(); ++i) {
    const double along = state.pose[8 * i + t.axis], other = state.pose[8 * i + across];
    extent[0] = std::min(extent[0], along);
    extent[1] = std::min(extent[1], -along);
    extent[2] = std::min(extent[2], other);
    extent[3] = std::min(extent[3], -other);
  }
  MPI_Allreduce(MPI_IN_PLACE, extent, 4, MPI_DOUBLE, MPI_MIN, state.comm());
  const auto [lower, upper] = t.ends.value_or(std::array{extent[0], -extent[1]});
  t.ends = {lower, upper};
  t.start = state.time;
  t.gage = upper - lower - 2.0 * t.grip;
  if (state.box.periodic[static_cast<std::size_t>(t.axis)])
    throw InputError(format(
        "-tension_axis %c: the box is periodic in this direction, so there are no ends to grip",
        "xyz"[t.axis]));
  if (!(t.gage > 0))
    throw InputError(format("-tension_grip %g: two grips leave nothing of the piece's length of %g",
                            t.grip, upper - lower));
  if (t.width == 0) {
    t.width = state.box.periodic[static_cast<std::size_t>(across)] ? state.box.length(across)
                                                                   : -extent[3] - extent[2];
    if (!(t.width > 0))
      throw InputError("-tension_width: the piece has no width of its own; give one");
  }
  for (int i = 0; i < state.owned(); ++i) {
    const double x = state.pose[8 * i + t.axis];
    if (x <= lower + t.grip) state.group[i] |= 1 << leftGripBit;
    if (x >= upper - t.grip) state.group[i] |= 1 << rightGripBit;
  }
}

void Boundaries::save(RunRecord& record, double time) const {
  for (const Boundary& b : boundaries_)
    if (b.bit < leftGripBit)
      record.reals["boundary_" + b.name] = {static_cast<double>(b.bit), b.start};
  if (!tension_) return;
  const Tension& t = *tension_;
  record.reals["tension"] = {t.start, t.gage, t.width};
  record.reals["tension_strain"] = {t.before, t.strain(time)};
  record.integers["tension_axis"] = {t.axis};
  record.reals["tension_grip"] = {t.grip};
  record.reals["tension_thickness"] = {t.thickness};
  record.reals["tension_ends"] = {(*t.ends)[0], (*t.ends)[1]};
}

std::array<double, 2> Boundaries::gripStress(const State& state, const ForceField& forces,
                                             const UnitSystem& units) const {
  const Tension& t = *tension_;
  const SumUnit unit(forces.fibre().bond.stretch * forces.fibre().length);
  ExactSum sums[2];
  for (int i = 0; i < state.owned(); ++i)
    for (int side = 0; side < 2; ++side)
      if (state.group[i] >> (side == 0 ? leftGripBit : rightGripBit) & 1)
        sums[side].add(state.force[3 * i + t.axis], unit);
  ExactSum::reduce(sums, 2, state.comm());
  // The piece pulls the left grip forwards and the right grip back.
  const double area = t.width * t.thickness * units.gigapascal;
  return {sums[0].value(unit) / area, -sums[1].value(unit) / area};
}

}  // namespace nanoweft
