/// How one direction of the box follows a stress (model.md 21): it yields to the missing stress as
/// a dashpot does, whose viscosity rises when the stress passes its target.
#pragma once

#include <array>

namespace nanoweft {

class BoxServo {
 public:
  /// What all directions of a box have in common.
  struct Law {
    double modulus = 0;   ///< GPa; modulus times time is the least viscosity
    double time = 0;      ///< in which the missing stress goes where the box is as stiff as that
    double mostRate = 0;  ///< of strain
    double interval = 0;  ///< time from one measurement of the stress to the next
  };
  /// The missing stress (target less stress, GPa) when it was last measured and now, and how far
  /// the box was strained in between.
  struct Measurement {
    double before, now, strained;
  };
  /// What a checkpoint keeps of it.
  using Numbers = std::array<double, 4>;

  /// The rate of strain until the next measurement.
  double rate(const Law& law, const Measurement& measured);

  Numbers numbers() const { return {viscosity_, work_, strains_, rises_}; }
  void set(const Numbers& n) { viscosity_ = n[0], work_ = n[1], strains_ = n[2], rises_ = n[3]; }

 private:
  void learn(const Law& law, const Measurement& measured);
  void adapt(const Law& law, const Measurement& measured);

  double viscosity_ = 0;  ///< missing stress over rate of strain; GPa times a unit of time
  /// Sums over intervals, which fade: rise of the stress times strain, strain squared, rise
  /// squared. The first over the second is the stiffness by least squares.
  double work_ = 0, strains_ = 0, rises_ = 0;
};

}  // namespace nanoweft
