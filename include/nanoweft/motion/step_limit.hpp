/// Estimates the largest stable step of velocity Verlet: dt < 2/omega_max, the highest frequency.
#pragma once

#include <algorithm>
#include <cmath>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// Longest step over the stable one, for a stepper that adapts its step.
inline constexpr double adaptedShare = 0.9;

/// A run's estimates of its stable step: the first, the lowest, the latest; 0: none yet.
struct StepLimits {
  double first = 0, lowest = 0, present = 0;

  void note(double limit) {
    if (std::isnan(limit)) return;
    if (first == 0) first = lowest = limit;
    present = limit;
    lowest = std::min(lowest, limit);
  }
};

/// Limit of the present state: omega_max^2 is the largest eigenvalue of the mass-weighted
/// stiffness, found by Lanczos iteration on differences of forces. State and forces are left as
/// they were; lists must be up to date. Infinite where nothing is stiff; not a number where
/// something is more than 1e5 times as stiff as the bonds. Collective.
double presentStepLimit(State& state, ForceField& forces, Halo& halo);

/// Limit of one free straight chain without viscosity, from its dispersion relations (axial,
/// torsional and bending-shear branches of the linear EVM chain).
double chainStepLimit(const Fibre& fibre);

/// Limit of chains pressed together in hexagonal bundles: the chain's omega^2 plus that of the
/// contacts, 6 K/m with K the contact stiffness of two parallel segments, the sum of those of all
/// laws between them, and the viscosity of the chain. A segment longer than its fibre is thick
/// turns faster than it moves, by m T^2/(12 I). K is that of aligned points in full repulsion, or
/// of a line as deep as fibres come that fall together, whichever is more. The lowest of all kinds.
double bundleStepLimit(const Kinds& kinds, const PairForces& pairs);
/// The lowest limit of the kinds' free chains, with their viscosity.
double chainStepLimit(const Kinds& kinds);

}  // namespace nanoweft
