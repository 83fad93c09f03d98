/// The plastic flow of bonds, between two steps.
#pragma once

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/force/bond_list.hpp"

namespace nanoweft {

/// Lets bonds flow, and sums the elastic energy that they lose.
class PlasticFlow {
 public:
  PlasticFlow(const Kinds& kinds, const MinimumImage& nearest, const SumUnit& unit)
      : kinds_(kinds), nearest_(nearest), unit_(unit) {}

  /// The thread's bonds whose first segment is of its share, or is a ghost: each rank that holds a
  /// bond finds the same bits. The poses must be those of the last evaluation.
  void flow(State& state, const BondList& bonds, int thread, Share share);
  /// Of the bonds whose first segment this rank owns.
  const ExactSum& lost() const { return lost_; }

 private:
  void flow(State& state, int i, int j);

  const Kinds& kinds_;
  const MinimumImage& nearest_;
  const SumUnit& unit_;
  ExactSum lost_;
};

}  // namespace nanoweft
