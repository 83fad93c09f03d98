/// The minimiser FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201, 2006) on top of Verlet.
///
/// After each step the velocities are turned towards the forces. As long as the motion goes
/// downhill in energy the step grows; as soon as it goes uphill all velocities are set to zero.
///
/// FIRE sees translation and rotation as one motion with the coordinates sqrt(m) x, sqrt(I) phi.
/// The velocity is then (sqrt(m) v, sqrt(I) w), its square twice the kinetic energy, and the force
/// is (F/sqrt(m), T/sqrt(I)). So the kinetic energy that a turn takes out is known; it goes to the
/// account `damped`.
///
/// No point of a segment moves farther than a given length in a step. If one would, all velocities
/// are scaled down alike, which keeps their direction and lets fibres move as bodies, and the step
/// is shortened if the forces alone would move it so far.
///
/// All decisions follow from exact sums and maxima over all segments, so they do not depend on
/// ranks.
#pragma once

#include <optional>
#include <vector>

#include "nanoweft/motion/verlet.hpp"

namespace nanoweft {

class Fire : public Stepper {
 public:
  /// `longest`: bound of the step; `farthest`: of how far a point moves in one, by default a tenth
  /// of the least diameter or segment.
  Fire(const Kinds& kinds, double longest, std::optional<double> farthest);

  double dt() const override { return verlet_.dt(); }
  double longest() const override { return longest_; }
  DriftReport move(System& system) override;
  void finish(System& system, bool seen) override;

  bool adapts() const override { return true; }
  void limit(double dt) override;
  void setLongest(double dt) override;

  void save(RunRecord& record) const override;
  void restore(const RunRecord& record) override;

 private:
  /// Sums over all segments at a step's end: force times velocity, and the squares of both; the
  /// fastest that a point moves, and its largest acceleration from rest.
  struct Slope {
    double power, speed2, force2;
    double fastest, hardest;
  };
  Slope slope(const System& system) const;
  /// Sets the velocities to keep x velocity + push x force, and books what they lose.
  void turn(System& system, double keep, double push) const;
  /// Shortens the step and what velocities keep and get, so that no point moves too far in it.
  void brake(const Slope& slope, double& keep, double& push, double& dt) const;

  SumUnit powerUnit_, speedUnit_, forceUnit_;
  Verlet verlet_;
  double longest_, farthest_, mixing_;
  std::vector<double> halves_;  ///< of the segments' lengths, or radii if larger, of each kind
  bool started_ = false;
  std::int64_t downhill_ = 0;  ///< steps since the motion last went uphill
};

}  // namespace nanoweft
