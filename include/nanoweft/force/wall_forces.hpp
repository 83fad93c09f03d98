/// The forces of walls on segments, and of segments on walls.
///
/// A segment touches a wall with points along its axis, each of which stands for a piece of the
/// fibre: the energy of a piece of length l that overlaps by d is (pi/8) E* d^2 l.
#pragma once

#include <vector>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/force/contact_history.hpp"
#include "nanoweft/force/wall.hpp"
#include "nanoweft/state/state.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// What a thread finds at the walls.
struct WallTally {
  ExactSum energy;
  ExactSum friction, external;  ///< work that friction took out, that moving walls put in
  ExactSum dragged;             ///< work of walls by friction
  ExactSum ahead;               ///< work of prescribed walls in the half step to come
  struct Felt {
    ExactSum force[3], torque[3];  ///< on the wall, the torque about `Wall::at`
    ExactSum friction[3];          ///< the part of the force that is friction
  };
  std::vector<Felt> felt;  ///< a wall
};

class WallForces {
 public:
  WallForces(Walls walls, const Kinds& kinds);

  explicit operator bool() const { return !walls_.empty(); }
  const Walls& list() const { return walls_; }
  bool rub() const;
  bool driven() const;

  /// A step's part of an evaluation: `time` is that of the poses. Springs advance by the time step
  /// `dt`. A moving wall works for half of it, and for half of the next step `ahead`. Without
  /// `viscous`, friction is left as it is.
  struct Terms {
    const MinimumImage& nearest;
    double time, dt, ahead;
    bool viscous;
  };
  /// Adds to the force, torque and viscous parts of the segments of a share.
  void add(State& state, ContactHistory* history, const Terms& terms, Share share,
           WallTally& tally) const;
  /// Takes what the threads of this rank found.
  void note(const std::vector<WallTally>& tallies);
  void noteAhead(const std::vector<WallTally>& tallies);

  /// Where walls book what is put into them and what they lose by friction.
  struct Accounts {
    ExactSum &external, &damped;
  };
  /// Moves the walls from `time` by `dt`; driven ones as velocity Verlet does, whose first half
  /// this is. Collective when some wall is driven.
  void move(MPI_Comm comm, double time, double dt, const Accounts& accounts);
  /// The second half, after the evaluation at `time`.
  void finish(MPI_Comm comm, double time, double dt, const Accounts& accounts);
  /// Force and torque that the walls feel, and the force of friction alone, [9] a wall. Collective.
  std::vector<double> felt(MPI_Comm comm) const;
  /// How deep a segment's surface is inside a wall at most, over its radius.
  struct Depth {
    double radii;  ///< 0 or less: none touches
    std::int64_t row, fibre;
    std::int32_t index, wall;
  };
  /// By the points where segments touch walls. Of equally deep segments that with the lowest row.
  /// Collective.
  Depth deepest(const State& state, const MinimumImage& nearest) const;
  /// The largest stiffness of the contacts of a driven wall over its mass. Collective.
  double stiffest(const State& state, const MinimumImage& nearest) const;
  /// Distance of the points by which a segment touches walls.
  static double pointSpacing(const Fibre& fibre);
  /// Do the fibres bear what drives each driven wall, but for this share of it? Not while it is on
  /// its way to them. Collective.
  bool borne(MPI_Comm comm, double share) const;
  /// Energy of motion of the driven walls.
  double kinetic() const;

  /// What a restart needs: for each wall its way and speed, and the sums of what it feels.
  /// Collective.
  void save(RunRecord& record, MPI_Comm comm) const;
  /// Throws InputError for what is missing.
  void restore(const RunRecord& record, int rank);
  /// Puts walls that move as prescribed where they are at a time.
  void place(double time);

 private:
  /// Of the points of a segment.
  double leastGap(const State& state, const MinimumImage& nearest, int i, const Wall& wall) const;
  struct Place {
    int segment;
    std::size_t wall;
    Vec3d x, axis;
    const Fibre& fibre;
  };
  /// Of one point of a segment: force over overlap.
  double stiffnessOf(const Wall& wall, int kind) const;
  void touch(State& state, ContactHistory* history, const Terms& terms, const Place& place,
             WallTally& tally) const;
  /// Speeds driven walls up for the time h.
  void kick(MPI_Comm comm, double time, double h, const Accounts& accounts);
  void rubAt(State& state, ContactHistory& history, const Terms& terms, const Place& place,
             const ContactPatch& patch, WallTally& tally) const;

  Walls walls_;
  const Kinds& kinds_;
  SumUnit energyUnit_, forceUnit_;
  std::vector<WallTally::Felt> felt_;
  ExactSum ahead_;  ///< as WallTally::ahead, of the last evaluation
};

}  // namespace nanoweft
