/// The minimiser FIRE (Bitzek et al., Phys. Rev. Lett. 97, 170201, 2006) on top of Verlet.
///
/// After each step the velocities are turned towards the forces; as long as the motion goes
/// downhill the step grows, and as soon as it goes uphill all stop. Translation and rotation are
/// one: in the coordinates sqrt(m) x, sqrt(I) phi the velocity is (sqrt(m) v, sqrt(I) w), its
/// square twice the kinetic energy, and the force (F/sqrt(m), T/sqrt(I)). So FIRE takes kinetic
/// energy out by a known amount, which goes to the account `damped`.
///
/// Its decisions are made from exact sums over all segments, so they do not depend on ranks.
#pragma once

#include "nanoweft/motion/verlet.hpp"

namespace nanoweft {

class Fire : public Stepper {
 public:
  /// `longest`: bound of the step.
  Fire(const Fibre& fibre, double longest);

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
  /// What a step's end says of the way downhill, over all ranks.
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
