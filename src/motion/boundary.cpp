#include "nanoweft/motion/boundary.hpp"

#include <strings.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// Each name with a region needs a bit of its own; the grips have the bits above.
constexpr std::size_t mostRegions = leftGripBit - firstReservedGroupBit;

/// Component c of the motion that it prescribes: a velocity for c < 3, else an angular velocity.
/// Two that prescribe the same have the same numbers.
std::array<double, 10> motionOf(const Boundary& b, std::size_t c) {
  const double velocity[3] = {b.velocity.x, b.velocity.y, b.velocity.z};
  const double along = c < 3 ? velocity[c] : 0.0, spin = b.spin.value_or(0.0);
  if (along == 0 && spin == 0) return {};
  const Vec3d turning = spin * b.axis;
  const Vec3d centre = spin != 0 && c < 3 ? *b.centre : Vec3d{};
  return {along,    turning.x, turning.y, turning.z, centre.x,
          centre.y, centre.z,  b.ramp,    b.start,   b.program ? 1.0 : 0.0};
}

/// Checks what belongs to a spin.
void readSpin(Boundary& b, const std::optional<Vec3d>& axis) {
  const char* name = b.name.c_str();
  if (!b.spin) throw InputError(format("-%s_axis: there is no -%s_spin about it", name, name));
  if (!axis || !b.centre)
    throw InputError(format("-%s_spin: give -%s_axis and -%s_centre", name, name, name));
  const double size = norm(*axis);
  if (!(size > 0 && std::isfinite(size)))
    throw InputError(format("-%s_axis: it has no direction", name));
  b.axis = {axis->x / size, axis->y / size, axis->z / size};
  const double along[3] = {b.axis.x, b.axis.y, b.axis.z};
  for (std::size_t d = 0; d < 3; ++d)
    if (!b.fix[d] && std::abs(along[d]) != 1)
      throw InputError(format(
          "-%s_fix: only the component along -%s_axis may be free of a group that spins, not %c",
          name, name, "xyz"[d]));
}

bool holds(const Boundary& b, std::size_t c) {
  return c < 3 ? b.fix[c] : b.fixRotation;
}

/// Does `holder` hold a component in which the other one loads?
bool meets(const Boundary& load, const Boundary& holder) {
  const double force[3] = {load.force.x, load.force.y, load.force.z};
  for (std::size_t c = 0; c < 3; ++c)
    if (force[c] != 0 && holder.fix[c]) return true;
  return holder.fixRotation && norm(load.torque) > 0;
}

std::string titleOf(const Boundary& b) {
  if (b.bit == leftGripBit) return "the lower grip of the tension test";
  return b.bit == rightGripBit ? "the upper grip of the tension test" : b.name;
}

}  // namespace

Boundaries::Boundaries(Options& options, const UnitSystem& units, const Kinds& kinds,
                       double restDistance) {
  booksWork_ = OptionSection(options, "Boundary conditions").as(Role::run).given("group_monitor");
  readNamed(options, units);
  giveBits();
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
  s.document(
      "NAME_spin", "none", (std::string("1/") + units.time).c_str(),
      "angular velocity about NAME_axis through NAME_centre: the group turns as a whole (fixes "
      "all components and the rotation; NAME_fix may leave that along the axis free)");
  s.document("NAME_axis", "none", "", "direction of NAME_spin");
  s.document("NAME_centre", "none, or the mean position", units.length,
             "a point on the axis of NAME_spin, which moves with NAME_velocity; the torque of "
             "-group_monitor is about it");
  s.document("NAME_force", "0,0,0", units.force, "force on each member");
  s.document("NAME_torque", "0,0,0", units.energy, "torque on each member");
  s.document("NAME_ramp", "0", units.time,
             "velocity, spin, force and torque grow linearly for this long");
  checkPrefixes("-bc", "a group", names, true);
  for (const std::string& name : names) {
    if (strncasecmp(name.c_str(), "tension", 7) == 0)
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
  if (group) b.bit = static_cast<int>(*group);
  auto vector = [&](const char* suffix) {
    const auto v = n.reals(name + suffix, 3, "", "", "");
    return v ? std::optional(Vec3d{(*v)[0], (*v)[1], (*v)[2]}) : std::nullopt;
  };
  const auto fix = n.flags3(name + "_fix", "", "");
  const auto velocity = vector("_velocity"), force = vector("_force"), torque = vector("_torque");
  const auto axis = vector("_axis");
  b.centre = vector("_centre");
  b.spin = n.maybeReal(name + "_spin", "", "", "", {});
  // A restart may leave the monitor out.
  if (b.centre && !b.spin && !booksWork_ && !options.recorded(name + "_centre"))
    throw InputError(
        format("-%s_centre: not used by this run, which has neither -%s_spin nor a "
               "-group_monitor with torques about it",
               name.c_str(), name.c_str()));
  const bool held = velocity || b.spin;
  b.fix = fix.value_or(std::array{held, held, held});
  b.fixRotation = n.flag(name + "_fix_rotation", b.spin.has_value(), "");
  if (b.spin || axis) readSpin(b, axis);
  b.velocity = velocity.value_or(Vec3d{});
  b.force = force.value_or(Vec3d{});
  b.torque = torque.value_or(Vec3d{});
  b.ramp = n.real(name + "_ramp", 0.0, "", "", nonNegative);
  const bool grows =
      norm(b.velocity) > 0 || b.spin.value_or(0.0) != 0 || norm(b.force) > 0 || norm(b.torque) > 0;
  if (b.ramp > 0 && !grows)
    throw InputError(
        format("-%s_ramp: not used by this run: the group has no velocity, spin, force "
               "or torque to grow",
               name.c_str()));
  const double moved[3] = {b.velocity.x, b.velocity.y, b.velocity.z};
  for (std::size_t d = 0; d < 3; ++d)
    if (moved[d] != 0 && !b.fix[d])
      throw InputError(
          format("-%s_velocity: its %c component is not zero but -%s_fix does not hold it",
                 name.c_str(), "xyz"[d], name.c_str()));
  const double loads[3] = {b.force.x, b.force.y, b.force.z};
  for (std::size_t d = 0; d < 3; ++d)
    if (loads[d] != 0 && b.fix[d])
      throw InputError(
          format("-%s_force: its %c component does nothing, since the group is held in it",
                 name.c_str(), "xyz"[d]));
  if (norm(b.torque) > 0 && b.fixRotation)
    throw InputError(
        format("-%s_torque: does nothing, since the group is kept from rotating", name.c_str()));
  if (!b.constrains() && !force && !torque)
    throw InputError(format(
        "-bc %s: nothing acts on it; give -%s_fix, -%s_fix_rotation, -%s_velocity, -%s_spin, "
        "-%s_force or -%s_torque",
        name.c_str(), name.c_str(), name.c_str(), name.c_str(), name.c_str(), name.c_str(),
        name.c_str()));
  boundaries_.push_back(b);
}

void Boundaries::giveBits() {
  std::vector<Boundary*> regions;
  for (Boundary& b : boundaries_)
    if (b.region) regions.push_back(&b);
  if (regions.size() > mostRegions)
    throw InputError(format(
        "-bc: %zu names have a region, at most %zu may; mark others in /state/group of a state "
        "file and name them by -NAME_group (bits 0 to %d)",
        regions.size(), mostRegions, firstReservedGroupBit - 1));
  // Where there are few names, the bit is that of the place among them.
  const bool few = boundaries_.size() <= mostRegions;
  for (std::size_t k = 0; k < regions.size(); ++k) {
    const auto place = few ? regions[k] - boundaries_.data() : static_cast<std::ptrdiff_t>(k);
    regions[k]->bit = firstReservedGroupBit + static_cast<int>(place);
  }
}

Vec3d Boundary::centreAt(double time) const {
  const double t = time - start;
  const double way = ramp > 0 && t < ramp ? t * t / (2.0 * ramp) : t - 0.5 * ramp;
  return *centre + way * velocity;
}

void Boundaries::attach(State& state, const RunRecord& record, bool restart) {
  goesOn_ = !restart && tension_ && !tension_->fresh && record.reals.contains("tension");
  if (tension_ && restart) tension_->restore(record);
  if (goesOn_) tension_->goOn(record, state.time);
  attachNamed(state, record, restart);
  if (tension_) {
    tension_->requireEnds(state.box);
    if (!restart && !goesOn_) tension_->measure(state);
    addGrips();
  }
  countMembers(state);
  refuseConflicts(state);
}

void Boundaries::attachNamed(State& state, const RunRecord& record, bool restart) {
  // Reserved bits mean what the run that set them says: only a restart or the same test keeps them.
  std::int32_t kept = (1 << firstReservedGroupBit) - 1;
  for (Boundary& b : boundaries_) {
    const double along[3] = {b.axis.x, b.axis.y, b.axis.z};
    for (std::size_t d = 0; d < 3; ++d)
      if (b.spin && state.box.periodic[d] && std::abs(along[d]) != 1)
        throw InputError(format("-%s_spin: the box is periodic along %c, across -%s_axis",
                                b.name.c_str(), "xyz"[d], b.name.c_str()));
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
    const double rate = tension_->program ? 1.0 : tension_->rate;
    const double speed = (side == 0 ? -0.5 : 0.5) * rate * tension_->gage;
    (tension_->axis == 0   ? grip.velocity.x
     : tension_->axis == 1 ? grip.velocity.y
                           : grip.velocity.z) = speed;
    grip.program = tension_->program;
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

void Boundaries::refuseConflicts(const State& state) const {
  for (auto a = boundaries_.begin(); a != boundaries_.end(); ++a)
    for (auto b = a + 1; b != boundaries_.end(); ++b)
      for (std::size_t c = 0; c < 4; ++c) {
        if (!holds(*a, c) || !holds(*b, c) || motionOf(*a, c) == motionOf(*b, c)) continue;
        const std::int32_t both = 1 << a->bit | 1 << b->bit;
        std::int64_t shared = 0;
        for (int i = 0; i < state.owned(); ++i) shared += (state.group[i] & both) == both;
        MPI_Allreduce(MPI_IN_PLACE, &shared, 1, MPI_INT64_T, MPI_SUM, state.comm());
        if (shared == 0) break;
        const std::string what = c < 3 ? std::string(1, "xyz"[c]) + " velocity" : "rotation";
        throw InputError(format(
            "-bc: %s and %s hold the %s of %lld segment%s in different ways; let each segment be "
            "held by one of them (-NAME_region, -NAME_fix, -tension_grip)",
            titleOf(*a).c_str(), titleOf(*b).c_str(), what.c_str(), static_cast<long long>(shared),
            shared > 1 ? "s" : ""));
      }
}

std::int32_t Boundaries::holders(std::size_t c) const {
  std::int32_t bits = 0;
  for (const Boundary& b : boundaries_)
    if (holds(b, c)) bits |= 1 << b.bit;
  return bits;
}

std::vector<std::string> Boundaries::lostLoads(const State& state) const {
  std::vector<std::string> lost;
  for (const Boundary& b : boundaries_)
    for (const Boundary& other : boundaries_) {
      if (!meets(b, other)) continue;
      std::int64_t counts[2] = {0, 0};
      for (int i = 0; i < state.owned(); ++i)
        if (state.group[i] >> b.bit & 1) {
          ++counts[0];
          counts[1] += state.group[i] >> other.bit & 1;
        }
      MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPI_INT64_T, MPI_SUM, state.comm());
      if (counts[1] == 0) continue;
      lost.push_back(format(
          "of the %lld segments that %s loads, %s holds %lld against the load, which does nothing "
          "there",
          static_cast<long long>(counts[0]), b.name.c_str(), titleOf(other).c_str(),
          static_cast<long long>(counts[1])));
    }
  return lost;
}

void Boundaries::save(RunRecord& record, double time) const {
  for (const Boundary& b : boundaries_)
    if (b.bit < leftGripBit)
      record.reals["boundary_" + b.name] = {static_cast<double>(b.bit), b.start};
  if (tension_) tension_->save(record, time);
}

}  // namespace nanoweft
