/// The fields of a segment (pose, velocity, force, ...) in one table, which says for each whether
/// state files keep it and whether ghosts carry it. To add a field takes a pointer in
/// `SegmentFields` and a line in `fields`.
#pragma once

#include <petscdmswarm.h>

#include <array>
#include <cstdint>
#include <variant>

namespace nanoweft {

/// Contacts with friction that a segment may have at a time.
inline constexpr int contactSlots = 32;

/// Fields that only some scenes need.
struct ExtraFields {
  bool gap = false;        ///< which neighbours along a fibre have parted (breakage)
  bool viscous = false;    ///< viscous force and torque
  bool rest = false;       ///< bonds with rest rotations of their own
  bool ends = false;       ///< ends without a bond (contacts)
  bool friction = false;   ///< springs of contacts
  bool extension = false;  ///< bonds with rest lengths of their own
};

/// Arrays of all segments of a rank, one value or a few (in brackets) for each. Null: not needed.
struct SegmentFields {
  double* pose = nullptr;         ///< [8]: position, kind, quaternion w x y z
  double* velocity = nullptr;     ///< [3], space axes
  double* angular = nullptr;      ///< [3], angular velocity, space axes
  double* force = nullptr;        ///< [3], all forces but damping and constraints
  double* torque = nullptr;       ///< [3], about the centre, space axes
  std::int64_t* row = nullptr;    ///< place in the order of (fibre, index): a unique global id
  std::int64_t* fibre = nullptr;  ///< the fibre's id
  std::int32_t* chain = nullptr;  ///< [2]: index along the fibre, number of segments of the fibre
  std::int32_t* bond = nullptr;   ///< BondBits
  std::int32_t* group = nullptr;  ///< bit mask
  std::int32_t* image = nullptr;  ///< [3], periodic wraps, see Box::unwrapped
  /// [4], with breakage only. Bit b of the first two: a bond between this segment and the one b
  /// places on (back) is broken; of the last two: that pair has been apart since, so it interacts.
  std::int64_t* gap = nullptr;
  /// [6], with viscous damping only: viscous force and torque. They depend on the velocities half a
  /// step back, so a restart cannot recompute them.
  double* viscous = nullptr;
  /// With contacts only: State::freeEnds. A restart cannot tell them from the bonds, since a bond
  /// that broke in the last evaluation leaves free ends from the next one on.
  std::int32_t* ends = nullptr;
  // With friction only, for each of `contactSlots` contacts:
  std::int64_t* contact = nullptr;  ///< row of the other segment, plus one; 0: none
  double* spring = nullptr;         ///< [3]: the tangential spring
  // With rest rotations of single bonds only, of the bond to the successor:
  double* rest = nullptr;      ///< [3]: rotation vector, body axes
  double* restHalf = nullptr;  ///< [4]: half of that rotation as a quaternion
  /// With plastic flow only: by how much the bond to the successor is longer at rest than its kind.
  double* extension = nullptr;
};

/// How a state file keeps a field.
enum class Stored {
  no,          ///< the order of the rows tells it
  composed,    ///< in datasets that the reader and the writer know one by one
  always,      ///< in a dataset of its name
  withForces,  ///< the same, where forces are asked for; never read
  extra,       ///< the same, where the scene has the field
};

/// When ghosts get a field from their owner.
enum class Ghosts {
  never,
  whenBuilt,
  everyStep,
  whenAsked,
  alongFibres,  ///< when asked, and only the neighbours of owned segments along their fibres
};

struct Field {
  std::variant<double * SegmentFields::*, std::int64_t * SegmentFields::*,
               std::int32_t * SegmentFields::*>
      member;
  const char* name;  ///< in the DMSwarm, and of its dataset
  int components;
  Stored stored;
  Ghosts ghosts = Ghosts::never;
  bool ExtraFields::*extra = nullptr;  ///< null: every scene has it
  std::array<double, 8> fresh{};       ///< of a new segment; zero beyond

  double freshAt(std::size_t component) const {
    return component < fresh.size() ? fresh[component] : 0.0;
  }
  bool whole() const { return member.index() > 0; }  ///< holds integers
  constexpr std::size_t bytes() const {              ///< of a segment
    return static_cast<std::size_t>(components) * (member.index() == 2 ? 4 : 8);
  }
  bool in(const ExtraFields& extras) const { return !extra || extras.*extra; }
  /// Calls visit(pointer) with the typed array of this field.
  template <class Fields, class Visit>
  decltype(auto) visit(Fields& of, const Visit& visit) const {
    return std::visit([&](auto m) -> decltype(auto) { return visit(of.*m); }, member);
  }
  /// The same array as bytes.
  char* data(const SegmentFields& of) const {
    return visit(of, [](auto* values) { return reinterpret_cast<char*>(values); });
  }
};

/// A fresh quaternion.
inline constexpr std::array<double, 8> unit{1};
/// Pose of a fresh segment: the unit quaternion.
inline constexpr std::array<double, 8> upright{0, 0, 0, 0, 1};

/// Every DMSwarm has DMSwarm_pid, the id of a point: it holds the row.
inline constexpr Field fields[] = {
    {&SegmentFields::row, DMSwarmField_pid, 1, Stored::no, Ghosts::whenBuilt},
    {&SegmentFields::pose, "pose", 8, Stored::composed, Ghosts::everyStep, nullptr, upright},
    {&SegmentFields::image, "image", 3, Stored::composed},
    {&SegmentFields::fibre, "fibre", 1, Stored::composed, Ghosts::whenBuilt},
    {&SegmentFields::chain, "chain", 2, Stored::composed, Ghosts::whenBuilt},
    {&SegmentFields::velocity, "velocity", 3, Stored::always, Ghosts::whenAsked},
    {&SegmentFields::angular, "angular_velocity", 3, Stored::always, Ghosts::whenAsked},
    {&SegmentFields::group, "group", 1, Stored::always},
    {&SegmentFields::bond, "bond", 1, Stored::composed, Ghosts::whenBuilt},
    {&SegmentFields::force, "force", 3, Stored::withForces},
    {&SegmentFields::torque, "torque", 3, Stored::withForces},
    {&SegmentFields::gap, "gap", 4, Stored::extra, Ghosts::never, &ExtraFields::gap},
    {&SegmentFields::viscous, "viscous", 6, Stored::extra, Ghosts::never, &ExtraFields::viscous},
    {&SegmentFields::ends, "free_ends", 1, Stored::extra, Ghosts::never, &ExtraFields::ends},
    {&SegmentFields::contact, "contact", contactSlots, Stored::extra, Ghosts::alongFibres,
     &ExtraFields::friction},
    {&SegmentFields::spring, "contact_spring", 3 * contactSlots, Stored::extra, Ghosts::alongFibres,
     &ExtraFields::friction},
    {&SegmentFields::rest, "rest_rotation", 3, Stored::extra, Ghosts::whenBuilt,
     &ExtraFields::rest},
    {&SegmentFields::restHalf, "rest_half", 4, Stored::no, Ghosts::whenBuilt, &ExtraFields::rest,
     unit},
    {&SegmentFields::extension, "rest_extension", 1, Stored::extra, Ghosts::whenBuilt,
     &ExtraFields::extension},
};

}  // namespace nanoweft
