/// Forces between segments of different fibres: a law u(r), summed over n points on each axis
/// (physics.md 4):
///
///     U_ij = (1/n^2) sum_a sum_b u(|p_jb - p_ia|),   p_ia = x_i + (a - (n-1)/2) T/n e1_i
///
/// Pairs far apart may use fewer points; pair_sift.hpp says how one sum gives way to the other.
/// Laws are chosen by name; a new one is a header like hertz.hpp and an entry in pair_force.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/pair_draw.hpp"
#include "nanoweft/force/sums.hpp"
#include "nanoweft/force/switch.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

/// Viscous damping of interacting pairs (physics.md 5): -g (v_i - v_j), -g_w (w_i - w_j).
struct ViscousDamping {
  double linear = 0, angular = 0;
  explicit operator bool() const { return linear > 0 || angular > 0; }
};

/// A thread's share of the pair sum. Sums go to the segments begin <= k < end alone, as integer
/// multiples of the force's units, so their order does not matter.
struct PairJob {
  const double* pose;              ///< [8] a segment
  const DrawnPairs* drawn;         ///< those within reach are resolved
  std::int32_t begin, end, spare;  ///< spare: a record of `sum` for what goes to other segments
  ForceSum* sum;
  const MinimumImage* nearest;
  // With viscous damping only:
  const double* velocity = nullptr;
  const double* angular = nullptr;
  std::int64_t* viscousSum = nullptr;
  ViscousDamping viscous;

  bool mine(std::int32_t segment) const { return segment >= begin && segment < end; }
};

struct PairTally {
  ExactSum energy;  ///< unit: energyUnit of the force field
  SumUnit energyUnit;
  std::int64_t resolved = 0;    ///< pairs in reach
  std::int64_t pointPairs = 0;  ///< of those pairs
};

/// Energy of a pair and the force on its first segment.
struct PairAction {
  double energy = 0;
  Vec3d force;
};

/// How many points a segment has, for pairs near and far.
struct PointChoice {
  int near = 3, far = 3;
  Switch blend;  ///< centre distances where `far` takes over; at infinity when it never does
};

class PairForce {
 public:
  virtual ~PairForce() = default;

  /// Draws from a list what `add` goes through until a segment has moved by half the margin.
  void draw(const PairRuns& listed, const double* pose, const MinimumImage& nearest, double margin,
            DrawnPairs& drawn) const {
    drawPairs(listed, pose, nearest, {points_.blend, reach_, margin}, drawn);
  }
  /// Adds the pairs' forces; `tally.energy` too when `energies`.
  virtual void add(const PairJob& job, bool energies, PairTally& tally) const = 0;
  /// One pair on its own, `separation` = x_j - x_i: for what looks at the pairs now and then.
  virtual PairAction resolve(const Vec3d& separation, const Quatd& qi, const Quatd& qj) const = 0;
  /// Smallest distance of two points of the pair.
  virtual double closest(const Vec3d& separation, const Quatd& qi, const Quatd& qj) const = 0;

  const std::string& name() const { return name_; }
  const PointChoice& points() const { return points_; }
  int exclude() const { return exclude_; }
  double cutoff() const { return cutoff_; }
  /// Centre distance beyond which no two points of a pair are within the cutoff.
  double reach() const { return reach_; }
  double closestSensible() const { return closestSensible_; }
  double contactStiffness() const { return contactStiffness_; }
  double forceUnit() const { return forceUnit_; }
  double torqueUnit() const { return torqueUnit_; }

 protected:
  std::string name_;
  PointChoice points_;
  int exclude_ = 0;
  double length_ = 0, cutoff_ = 0, reach_ = 0, closestSensible_ = 0, contactStiffness_ = 0;
  double forceUnit_ = 1, torqueUnit_ = 1;
};

/// Reads -pair and the options of the laws; empty for `none`.
std::unique_ptr<PairForce> readPairForce(Options& options, const UnitSystem& units,
                                         const Fibre& fibre);

}  // namespace nanoweft
