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
/// All decisions follow from exact sums over all segments, so they do not depend on ranks.
#pragma once

#include "nanoweft/motion/verlet.hpp"

namespace nanoweft {

class Fire : public Stepper {
 public:
  /// `longest`: bound of the step.
  Fire(const Kinds& kinds, double longest);

  double dt() const override { return verlet_.dt(); }
  double longest() const override { return longest_; }
  DriftReport move(System& system) override { return verlet_.move(system); }
  void finish(System& system, bool seen) override;

  bool adapts() const override { return true; }
  void limit(double dt) override;
  void setLongest(double dt) override;

  void save(RunRecord& record) const override;
  void restore(const RunRecord& record) override;

 private:
  /// Sums over all segments at a step's end: force times velocity, and the squares of both.
  struct Slope {
    double power, speed2, force2;
  };
  Slope slope(const System& system) const;
  /// Sets the velocities to keep x velocity + push x force, and books what they lose.
  void turn(System& system, double keep, double push) const;

  SumUnit powerUnit_, speedUnit_, forceUnit_;
  Verlet verlet_;
  double longest_, mixing_;
  std::int64_t downhill_ = 0;  ///< steps since the motion last went uphill
};

}  // namespace nanoweft
