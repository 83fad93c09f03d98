/// The forces of links (state/links.hpp) on this rank's segments.
///
/// Each rank resolves all links that it holds a copy of, with the ends in the same order, so both
/// owners get the same bits and break the same links. A segment may have any number of links; the
/// forces of all are added by exact sums, whose order does not matter.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/link_law.hpp"
#include "nanoweft/force/bond_list.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class LinkForces {
 public:
  LinkForces(const LinkLaws& laws, const Kinds& kinds);

  /// The largest MinimumImage::shareOfHalf of a link. A longer one might take the next step to
  /// another image of its end.
  static constexpr double mostOfHalf = 0.95;

  const LinkLaws& laws() const { return laws_; }
  /// Finds the ends of the links among the local segments; to be called at each rebuild.
  void build(const State& state, const Domain& domain);
  /// Adds forces and torques to State::force and torque of the owned segments, energies to the
  /// tally, and breaks links where `mayBreak`. After all bonds, before pair forces are handed over.
  void add(State& state, const MinimumImage& nearest, bool energies, bool mayBreak,
           BondTally& tally);

  /// What a link does now.
  struct Action {
    Vec3d separation;  ///< from the first end to the second
    BondForce<double> force;
    BondEnergy<double> energy;
  };
  Action resolve(const State& state, const MinimumImage& nearest, std::size_t link) const;
  /// Did the last evaluation meet a link beyond `mostOfHalf`, among those of this rank?
  bool tooLong() const { return tooLong_; }
  /// Local indices of a link's ends.
  const std::array<int, 2>& ends(std::size_t link) const { return ends_[link]; }

 private:
  /// One end of a link at an owned segment.
  struct End {
    int segment;
    std::size_t link;
    int side;
  };
  const LinkLaw& law(const Link& link) const { return laws_[static_cast<std::size_t>(link.kind)]; }
  bool breaks(const Link& link, const Action& action) const;

  LinkLaws laws_;
  SumUnit forceUnit_, torqueUnit_;
  std::vector<std::array<int, 2>> ends_;
  std::vector<End> owned_;  ///< sorted by segment
  bool tooLong_ = false;
};

}  // namespace nanoweft
