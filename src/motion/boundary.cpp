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

Boundaries::Boundaries(Options& options, const UnitSystem& units, const Kinds& kinds,
                       double restDistance) {
  readNamed(options, units);
  tension_ = readTension(options, units, kinds, restDistance);
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

void Boundaries::attach(State& state, const RunRecord& record, bool restart) {
  goesOn_ = !restart && tension_ && !tension_->fresh && record.reals.contains("tension");
  if (tension_ && restart) tension_->restore(record);
  if (goesOn_) tension_->goOn(record, state.time);
  attachNamed(state, record, restart);
  if (tension_) {
    if (!restart && !goesOn_) tension_->measure(state);
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
    if (!tension_->asked.ends)
      throw InputError(
          format("tension test: no segment is marked as held by the %s grip (bit %d "
                 "of /state/group)",
                 side, b.bit));
    throw InputError(format("-tension_ends %g,%g: no segment lies in the %s grip",
                            (*tension_->asked.ends)[0], (*tension_->asked.ends)[1], side));
  }
}

void Boundaries::save(RunRecord& record, double time) const {
  for (const Boundary& b : boundaries_)
    if (b.bit < leftGripBit)
      record.reals["boundary_" + b.name] = {static_cast<double>(b.bit), b.start};
  if (tension_) tension_->save(record, time);
}

}  // namespace nanoweft
