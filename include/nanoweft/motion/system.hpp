/// The parts of a run that steppers and observers work on, in one struct of references.
#pragma once

#include <vector>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// Energy taken out by damping and broken bonds, and brought in by boundaries and by a thermostat,
/// since the start, on this rank. Friction has a part in `damped`.
struct EnergyAccounts {
  ExactSum damped, external, broken;
  ExactSum friction, heat;
  std::vector<ExactSum> groups;  ///< what each of the boundaries brings in; empty: not booked
};

struct System {
  State& state;
  Domain& domain;
  ForceField& forces;
  const Boundaries& boundaries;
  EnergyAccounts& accounts;
};

}  // namespace nanoweft
