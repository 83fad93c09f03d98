#include "nanoweft/record/grip_stress.hpp"

#include "nanoweft/base/exact_sum.hpp"

namespace nanoweft {

std::array<double, 2> gripStress(const State& state, const ForceField& forces, const Tension& t,
                                 const UnitSystem& units) {
  const SumUnit unit(forces.kinds().forceScale());
  ExactSum sums[2];
  for (int i = 0; i < state.owned(); ++i)
    for (int side = 0; side < 2; ++side)
      if (state.group[i] >> (side == 0 ? leftGripBit : rightGripBit) & 1)
        sums[side].add(state.force[3 * i + t.axis] + state.viscousOn(i, t.axis), unit);
  ExactSum::reduce(sums, 2, state.comm());
  // The piece pulls the left grip forwards and the right grip back.
  const double area = t.width * t.thickness * units.gigapascal;
  return {sums[0].value(unit) / area, -sums[1].value(unit) / area};
}

}  // namespace nanoweft
