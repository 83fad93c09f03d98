/// The interface of pair forces between segments of different fibres. A pair law w(r), an energy
/// per length squared, is summed over n quadrature points on each axis:
///
///     U_ij = (Ti Tj/(ni nj)) sum_a sum_b w(|p_jb - p_ia|),   p_ia = x_i + (a - (ni-1)/2) Ti/ni
///     e1_i
///
/// Therefore the force between two fibres does not depend on T beyond the quadrature error. The
/// code of a law computes u = Ti Tj w. The two segments may be of different kinds; then i is the
/// one of the kind that PairForces::Class names first. A law that reaches far may be split
/// (PointChoice). Laws are chosen by name. A new law
/// of the gap between surfaces is a file like hamaker.cpp (see surface_law.hpp). Another one is a
/// header like hertz.hpp and an entry in pair_forces_read.cpp; one that is no table also needs a
/// makePairForce in pair_force.cpp, which instantiates the kernels and takes long to compile.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "nanoweft/base/both.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/force/pair_draw.hpp"
#include "nanoweft/force/sums.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

class PairTable;
class Hertz;
class ContactHistory;
class State;

/// What contacts with friction need besides; their forces go to viscousSum.
struct FrictionJob {
  State& state;
  ContactHistory& history;
  double advance;  ///< time since the last evaluation with friction
};

class PairForce;

/// Viscous damping of interacting pairs (model.md 5): -g (v_i - v_j), -g_w (w_i - w_j).
struct ViscousDamping {
  double linear = 0, angular = 0;
  explicit operator bool() const { return linear > 0 || angular > 0; }
  /// From that of two lengths of 2 rf to that of two segments: it is a rate per length squared.
  ViscousDamping between(const PairForce& force) const;
};

/// Units of integer sums of forces and torques: powers of two.
struct ForceUnits {
  double force = 1, torque = 1;
  /// Those whose sums hold eight forces of size `largest` on segments up to `length` long.
  static ForceUnits holding(double largest, double length);
};

/// One thread's share of the pair sum. The thread adds forces to its segments begin <= k < end
/// alone, or to others in records apart (`both`). The sums are integer multiples of the force's
/// units, so their order does not matter.
struct PairJob {
  const double* pose;       ///< [8] a segment
  const DrawnPairs* drawn;  ///< the pairs that the thread resolves,
  Chunks chunks;            ///< those in these chunks
  std::int32_t begin, end;
  std::int32_t spare;  ///< record of `sum` that takes forces on others
  bool both = false;   ///< are pairs with another's resolved for both? Then it is spare + its index
  ForceSum* sum;
  const MinimumImage* nearest;
  // With viscous damping only:
  const double* velocity = nullptr;
  const double* angular = nullptr;
  std::int64_t* viscousSum = nullptr;
  ForceUnits viscousUnits;
  ViscousDamping viscous;

  // With friction only:
  FrictionJob* friction = nullptr;

  bool messages = false;  ///< is MPI to go on between chunks of pairs? In the main thread alone.

  bool breakage = false;  ///< is the energy to be booked that contacts change by as ends get free?

  bool mine(std::int32_t segment) const { return segment >= begin && segment < end; }
};

struct PairTally {
  ExactSum friction;  ///< work that friction has taken out
  ExactSum energy;    ///< unit: energyUnit of the force field
  SumUnit energyUnit;
  std::int64_t resolved = 0;    ///< pairs that the kernel has resolved
  std::int64_t pointPairs = 0;  ///< point pairs in those
  ExactSum released;            ///< energy that contacts lost as ends got free
  bool beyondSums = false;      ///< damping or friction was too large for the integer sums
};

/// Energy of a pair and the force on its first segment.
struct PairAction {
  double energy = 0;
  Vec3d force;
};

/// How many quadrature points the segments of a pair have. A law u with fewer far points is split
/// into two, each summed over its own points:
///
///     far part   f(max(r, from)),           f(r) = u'(r)/r
///     near part  f(r) - f(from) for r < from, zero beyond
///
/// The far part varies so slowly that few points give its sum over a fibre to the last digits that
/// matter; the near part concerns few pairs.
struct PointChoice {
  Both<int> near = 3, far = 3;
  double from = std::numeric_limits<double>::infinity();  ///< distance of points

  bool split() const { return far != near; }
};

inline constexpr int mostPairPoints = 99;
/// Up to this number, equal for both segments, a kernel is compiled for each.
inline constexpr int mostCompiledPoints = 9;
/// Is there a kernel for this number of points? All others are counted in a loop, and in doubles.
inline bool compiled(Both<int> points, Both<double> length) {
  return points.same() && points.i <= mostCompiledPoints && length.same();
}

/// How wide the forces of a law are, which decides the number of points (quadrature.hpp).
struct LawWidth {
  double gap = 0;      ///< over which the law acts between two surfaces
  double spacing = 0;  ///< largest spacing of points over sqrt(2 d gap), d the distance at rest
};

/// Properties of a law that other code asks for.
struct PairTraits {
  std::string description;      ///< name and parameters with units
  double cutoff = 0;            ///< distance of points beyond which there is no force
  double restDistance = 0;      ///< of two fibres that touch
  double closestSensible = 0;   ///< below it fibres have passed through each other
  Both<double> radius;          ///< of the fibres
  double contactStiffness = 0;  ///< bound of u'' in repulsive contact
  double largestForce = 0;      ///< bound of |u'|
  LawWidth width;
  bool keepsApart = true;  ///< does it repel fibres that touch?
  /// Squared frequency of pressed fibres whose segments stick to each other over that of what
  /// presses them, or 1 where that is more.
  double sticking = 1;
};

/// Settings of the sum that are the same for all laws.
struct PairChoice {
  PointChoice points;
  int exclude = 20;     ///< segments of one fibre interact from this many places apart
  Both<double> length;  ///< T of the segments
  bool single = false;
};

class PairForce {
 public:
  virtual ~PairForce() = default;

  /// Draws from a list the pairs that `add` resolves until a segment has moved by half the margin.
  void draw(const PairRuns& listed, const double* pose, const MinimumImage& nearest, double margin,
            DrawnPairs& drawn) const {
    drawPairs(listed, pose, nearest, {reach_, margin, nearRange()}, drawn);
  }
  /// Of a law that is split.
  NearRange nearRange() const {
    if (!points_.split()) return {};
    return {points_.from, points_.near, length_, farBetweenCentres()};
  }
  /// Adds the forces of the drawn pairs to job.sum and, when `energies`, their energy to the tally.
  virtual void add(const PairJob& job, bool energies, PairTally& tally) const = 0;
  /// Resolves one pair by itself, for observers and estimates; `separation` = x_j - x_i.
  /// `freeEnds`: State::freeEnds of both, which contacts ask for.
  virtual PairAction resolve(const Vec3d& separation, const Quatd& qi, const Quatd& qj,
                             Both<int> freeEnds = 0) const = 0;
  /// The same with `n` points on the segments, however far they are; ei, ej: axes.
  virtual PairAction average(Both<int> n, const Vec3d& separation, const Vec3d& ei,
                             const Vec3d& ej) const = 0;
  /// Smallest distance of two points of the pair.
  virtual double closest(const Vec3d& separation, const Quatd& qi, const Quatd& qj) const = 0;

  const std::string& description() const { return traits_.description; }
  const PointChoice& points() const { return points_; }
  int exclude() const { return exclude_; }
  double cutoff() const { return cutoff_; }
  /// Centre distance beyond which no two points of a pair are within the cutoff.
  double reach() const { return reach_; }
  double restDistance() const { return traits_.restDistance; }
  double closestSensible() const { return traits_.closestSensible; }
  double contactStiffness() const { return traits_.contactStiffness; }
  double sticking() const { return traits_.sticking; }
  /// Does it act where axes come closest, and not between points?
  virtual bool touches() const { return false; }
  /// Has it friction, or damping that its contacts bring along?
  virtual bool rubs() const { return false; }
  /// Has it such damping (a restitution below 1)?
  virtual bool damps() const { return false; }
  const LawWidth& width() const { return traits_.width; }
  bool keepsApart() const { return traits_.keepsApart; }
  /// Places of the outermost points of near pairs, from the centres.
  virtual Both<double> pointSpan() const;
  Both<double> radius() const { return traits_.radius; }
  Both<double> length() const { return length_; }
  double largestForce() const { return traits_.largestForce; }
  double forceUnit() const { return forceUnit_; }
  double torqueUnit() const { return torqueUnit_; }
  /// Sets the units of the integer sums, which all pair forces on a segment must share: for forces
  /// up to `largest` and segments up to `length`.
  void setUnits(double largest, double length);

 protected:
  /// Is the law split, with one far point? Then the pass over near pairs adds their far part, too.
  bool farBetweenCentres() const { return points_.split() && points_.far == 1; }

  PairTraits traits_;
  PointChoice points_;
  int exclude_ = 0;
  Both<double> length_;
  double cutoff_ = 0, reach_ = 0;
  double forceUnit_ = 1, torqueUnit_ = 1;
};

std::unique_ptr<PairForce> makePairForce(const PairTable& law, const PairTraits& traits,
                                         const PairChoice& choice);
std::unique_ptr<PairForce> makePairForce(const Hertz& law, const PairTraits& traits,
                                         const PairChoice& choice);
/// Is -pair_precision single faster than double in this build?
bool singlePrecisionPays();

}  // namespace nanoweft
