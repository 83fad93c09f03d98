/// The particles: one DMSwarm point per segment, owned points first, ghosts (copies of other ranks'
/// segments) after them in the same arrays.
///
/// Ghosts carry only what forces need of them: `fields` tells. They must be dropped before points
/// migrate or are counted (petsc: both see every local point).
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "nanoweft/base/vec.hpp"
#include "nanoweft/state/box.hpp"
#include "nanoweft/state/fields.hpp"
#include "nanoweft/state/links.hpp"
#include "nanoweft/state/ties.hpp"

namespace nanoweft {

/// Bits of State::bond.
enum BondBits : std::int32_t {
  fibreClosed = 1,     ///< the fibre's last segment is bonded to its first
  nextBroken = 2,      ///< the bond to the successor is broken
  previousBroken = 4,  ///< the bond to the predecessor is broken
};

/// Bits of State::freeEnds.
enum FreeEnd { freePrevious = 1, freeNext = 2 };
/// The fourth number of a pose is the kind, a quarter of these bits, and a sixteenth of those that
/// held in the step before.
inline int freeEndBits(double fourth) {
  return static_cast<int>(4.0 * (fourth - static_cast<int>(fourth)));
}
inline int formerEndBits(double fourth) {
  return static_cast<int>(16.0 * (fourth - static_cast<int>(fourth))) & 3;
}

/// Bits of State::group from here up belong to the solver; lower ones are the user's.
inline constexpr int firstReservedGroupBit = 16;

/// The pointers of its fields change whenever segments come, go, or change places.
class State : public SegmentFields {
 public:
  State(MPI_Comm comm, const Box& box, ExtraFields extras);
  ~State();
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  MPI_Comm comm() const { return comm_; }
  int rank() const { return rank_; }
  int ranks() const { return ranks_; }
  DM swarm() const { return swarm_; }
  const ExtraFields& extras() const { return extras_; }

  int owned() const { return owned_; }
  int ghosts() const { return ghosts_; }
  int local() const { return owned_ + ghosts_; }
  std::int64_t total() const { return total_; }
  /// Bytes that a segment takes at least (requireMemory), with the fields that this scene needs.
  double memoryOfSegment() const;

  /// Appends `n` owned points with the fields of a fresh segment. There must be no ghosts.
  void addOwned(int n);
  void addGhosts(int n);
  void dropGhosts();

  /// Counts the owned points of all ranks: the number that every later migration must preserve.
  void countTotal();

  /// Sends every owned point to `destination[i]` and drops what left. The order of the points
  /// afterwards is unspecified. A change of the global count throws RunError. No ghosts. No rank
  /// sends another more than `mostBytes` at a time. Collective.
  void migrate(const std::vector<int>& destination,
               std::int64_t mostBytes = std::numeric_limits<std::int32_t>::max());

  /// Reorders the owned points: new point k is old point order[k]. No ghosts.
  void permute(const std::vector<int>& order);

  Vec3d position(int i) const { return {pose[8 * i], pose[8 * i + 1], pose[8 * i + 2]}; }
  Quatd orientation(int i) const {
    return {pose[8 * i + 4], pose[8 * i + 5], pose[8 * i + 6], pose[8 * i + 7]};
  }
  void setOrientation(int i, const Quatd& q) {
    pose[8 * i + 4] = q.w, pose[8 * i + 5] = q.x, pose[8 * i + 6] = q.y, pose[8 * i + 7] = q.z;
  }
  /// A component of the viscous force (0 to 2) or torque (3 to 5) on a segment.
  double viscousOn(int i, int c) const { return viscous ? viscous[6 * i + c] : 0.0; }
  /// Which of the kinds of segments it is.
  int kind(int i) const { return static_cast<int>(pose[8 * i + 3]); }
  void setKind(int i, int kind) { pose[8 * i + 3] = kind; }
  /// Which of its ends contacts take for free, that is without a bond: FreeEnd bits. They travel
  /// with the pose, so that ghosts have them at every step.
  int freeEnds(int i) const { return freeEndBits(pose[8 * i + 3]); }
  /// Notes which ends of the owned segments are free now. A bond that breaks in an evaluation is
  /// noted before the next one, so that all ranks see its ends alike.
  void noteFreeEnds();
  /// Takes them from SegmentFields::ends, as those of the step before too.
  void recallFreeEnds();
  /// What a segment (or a ghost) is bonded to: the one before it along the fibre, the one after it.
  Ties ties(int i) const {
    const std::int32_t index = chain[2 * i], last = chain[2 * i + 1] - 1;
    const bool closed = bond[i] & fibreClosed;
    Ties ties;
    auto add = [&](std::int32_t other, bool first, int broken) {
      ties.add({row[i] - index + other, other, first, (bond[i] & broken) != 0});
    };
    if (index > 0 || closed) add(index > 0 ? index - 1 : last, false, previousBroken);
    if (index < last || closed) add(index < last ? index + 1 : 0, true, nextBroken);
    return ties;
  }

  /// Whether something still acts across a tie: until its bond has broken and contacts, if there
  /// are any, know of it (freeEnds). Only then do the halo and the lists need its other segment,
  /// which may be anywhere after a break.
  bool holds(int i, const Tie& tie) const {
    return !tie.broken || (extras_.ends && !(freeEnds(i) & (tie.first ? freeNext : freePrevious)));
  }

  Box box;
  std::vector<std::string> kinds{""};  ///< names of the kinds of segments; one empty name: one kind
  std::int64_t step = 0;
  double time = 0;
  bool linked = false;  ///< some rank has links
  Links links;
  std::vector<std::string> linkKinds{""};  ///< names of the kinds of links, as `kinds`

 private:
  void acquire();
  void release();
  /// Bytes of a point as it is sent.
  std::int64_t bytesOfSegment() const;
  /// Sends at most so many points from this rank to each other one; `goal`: where they shall be at
  /// last, then that of the points that are here now. Returns how many wait.
  std::int64_t moveSome(std::vector<int>& goal, std::int64_t most);
  /// Room besides `n` owned points for ghosts and for points that arrive: it spares a reallocation
  /// of every field at each migration.
  int bufferFor(int n) const;

  MPI_Comm comm_;
  int rank_, ranks_;
  ExtraFields extras_;
  DM swarm_ = nullptr;
  int owned_ = 0, ghosts_ = 0;
  std::int64_t total_ = 0;
  bool acquired_ = false;
  const double* advised_ = nullptr;  ///< the poses that large pages have been asked for
};

}  // namespace nanoweft
