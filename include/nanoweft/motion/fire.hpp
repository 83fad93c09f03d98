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

class Fire {
 public:
  /// `longest`: bound of the step.
  Fire(const Fibre& fibre, double longest);

  /// The step to make next.
  double dt() const { return dt_; }
  double longest() const { return longest_; }
  /// Makes no step longer than this from now on.
  void limit(double dt);
  /// Steps may be as long as this from now on.
  void setLongest(double dt);

  /// To be called at the end of each step, with forces and velocities of the same time. Collective.
  void steer(State& state, const ForceField& forces, const Boundaries& boundaries,
             EnergyAccounts& accounts);

  void save(RunRecord& record) const;
  /// Goes on as recorded. Throws InputError when something is missing.
  void restore(const RunRecord& record);

 private:
  SumUnit powerUnit_, speedUnit_, forceUnit_;
  double dt_, longest_, mixing_;
  std::int64_t downhill_ = 0;  ///< steps since the motion last went uphill
};

}  // namespace nanoweft
