/// Nine tubes in three layers that cross and touch, slightly disordered, with their forces.
#pragma once

#include <petscsys.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "nanoweft/base/units.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/presets.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/boundary.hpp"
#include "nanoweft/motion/system.hpp"

namespace nanoweft::test {

constexpr int tubeLength = 16, tubeCount = 9;
constexpr std::int64_t tubeRows = tubeCount * tubeLength;

/// A number between -1 and 1 that belongs to a row.
inline double disorder(std::int64_t row, int what) {
  return std::sin(12.9898 * static_cast<double>(row + 1) + 78.233 * what);
}

class Tubes {
 public:
  explicit Tubes(int threads = 2) {
    fill();
    ForceField::Settings settings;
    settings.kinds = fibre;
    Options options;
    settings.pairs = readPairForces(options, nanoUnits(), fibre);
    settings.threads = threads;
    forces = std::make_unique<ForceField>(std::move(settings), box);
    forces->rebuild(state, domain);
  }

  ForceOutcome evaluate(bool energies = true) {
    ForceRequest request;
    request.energies = energies;
    return forces->evaluate(state, domain.halo(), request);
  }
  /// Potential energy over all ranks.
  double energy() {
    const ForceOutcome found = evaluate();
    ExactSum sum;
    for (const ExactSum* part :
         {&found.stretch, &found.shear, &found.bending, &found.torsion, &found.pair})
      sum.merge(*part);
    ExactSum::reduce(&sum, 1, state.comm());
    return sum.value(forces->energyUnit());
  }
  System system() { return {state, domain, *forces, boundaries, accounts}; }

  const Fibre fibre = cnt1010(nanoUnits());
  const Box box{{-200, -200, -200}, {200, 200, 200}, {}};
  State state{PETSC_COMM_WORLD, box, {}};
  Domain domain{state, {PartitionSettings::rectilinear, 1.05, 4}};
  std::unique_ptr<ForceField> forces;
  EnergyAccounts accounts;

 private:
  static Boundaries none() {
    Options options;
    const Fibre tube = cnt1010(nanoUnits());
    return Boundaries(options, nanoUnits(), tube, tube.diameter());
  }

  void fill() {
    const std::int64_t first = tubeRows * state.rank() / state.ranks(),
                       last = tubeRows * (state.rank() + 1) / state.ranks();
    state.addOwned(static_cast<int>(last - first));
    for (std::int64_t row = first; row < last; ++row) set(static_cast<int>(row - first), row);
    state.countTotal();
  }

  void set(int i, std::int64_t row) {
    const std::int64_t tube = row / tubeLength, index = row % tubeLength;
    const auto layer = static_cast<double>(tube / 3), place = static_cast<double>(tube % 3);
    state.row[i] = row;
    state.fibre[i] = tube;
    state.chain[2 * i] = static_cast<std::int32_t>(index);
    state.chain[2 * i + 1] = tubeLength;
    const double along = fibre.length * (static_cast<double>(index) - 0.5 * (tubeLength - 1)),
                 across = 40 * (place - 1);
    const bool alongX = tube / 3 % 2 == 0;
    double* x = state.pose + 8 * i;
    x[0] = (alongX ? along : across) + 0.05 * disorder(row, 0);
    x[1] = (alongX ? across : along) + 0.05 * disorder(row, 1);
    x[2] = 17.5 * layer + 0.05 * disorder(row, 2);
    const Quatd turn = alongX ? Quatd{1, 0, 0, 0} : rotation({0.0, 0.0, 0.5 * std::numbers::pi});
    state.setOrientation(
        i, rotation({0.01 * disorder(row, 3), 0.01 * disorder(row, 4), 0.01 * disorder(row, 5)}) *
               turn);
  }

 public:
  Boundaries boundaries = none();
};

}  // namespace nanoweft::test
