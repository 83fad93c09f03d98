/// Temperature by Langevin's equation (model.md 17): every half step each component of velocity and
/// spin keeps a share c = exp(-gamma dt/2) of itself and gets a random part, so that a segment has
/// kT/2 in each, whatever the step and the forces are.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/motion/system.hpp"

namespace nanoweft {

struct Thermostat {
  double kelvin = 0;
  double thermal = 0;  ///< kT
  double damping = 0;  ///< gamma: a velocity alone decays as exp(-gamma t)
  bool drawsStart = false;
  std::uint64_t seed = 0;
};

/// -temperature and what belongs to it; empty: none. `refusal`: why the run can have none, or
/// empty. Throws InputError.
std::optional<Thermostat> readThermostat(Options& options, const UnitSystem& units,
                                         std::uint64_t seed, const std::string& refusal);

/// Exchanges heat with the segments of one thread. What a segment gets depends on (seed, its fibre
/// and index, step, half) alone. Held components get none.
class HeatBath {
 public:
  /// Draws at one step that are independent of each other.
  enum Half : std::uint32_t { first, second, start };
  struct Stroke {
    Thermostat thermostat;
    double keep;  ///< share of a velocity that stays
    Half half;
    SumUnit unit;
  };

  /// At State::step.
  HeatBath(State& state, const Kinds& kinds, const Boundaries& boundaries, const Stroke& stroke);

  /// Segments begin <= i < end, at most `laneCount`.
  void operator()(std::int32_t begin, std::int32_t end);
  void close(EnergyAccounts& accounts) const { accounts.heat.merge(heat_); }

 private:
  /// Of a kind: half its mass or inertia, and the standard deviation of what is added.
  struct Scale {
    double halfMass, halfInertia, velocity, spin;
  };

  const Scale& scaleOf(std::int32_t i) const {
    return scales_[scales_.size() > 1 ? static_cast<std::size_t>(state_.kind(i)) : 0];
  }

  State& state_;
  const Boundaries& boundaries_;
  std::vector<Scale> scales_;
  double keep_;
  std::uint64_t key_;
  SumUnit unit_;
  ExactLanes heat_;
};

/// Replaces all velocities and spins that nothing holds by draws of Maxwell's distribution.
void drawVelocities(State& state, const Kinds& kinds, const Boundaries& boundaries,
                    const Thermostat& thermostat);

}  // namespace nanoweft
