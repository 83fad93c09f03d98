/// All forces between segments: bonds and pairs, over threads and ranks.
#pragma once

#include <memory>
#include <optional>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/bond_list.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/pair_list.hpp"

namespace nanoweft {

/// What one evaluation found on this rank; sums are completed over the ranks by whoever reports.
struct ForceOutcome {
  ExactSum stretch, shear, bending, torsion, pair;  ///< when energies were asked for
  ExactSum released;                                ///< energy of bonds that broke
  std::vector<std::int64_t> broken;                 ///< rows of the first segments of those bonds
};

struct ForceRequest {
  bool energies = false;
  bool mayBreak = true;
  bool viscous = true;   ///< false: leave State::viscous as it is
  bool complete = true;  ///< false: pair forces are left to ForceField::complete
};

class ForceField {
 public:
  struct Settings {
    Fibre fibre;
    std::unique_ptr<PairForce> pair;  ///< empty: none
    std::optional<BreakageLaw> breakage;
    ViscousDamping viscous;
    double skin = 0;  ///< 0: tuned while running
    int threads = 1;
  };
  explicit ForceField(Settings settings, const Box& box);

  /// Takes effect at the next rebuild.
  void setThreads(int threads) { settings_.threads = threads; }

  /// Distributes the segments anew and makes the lists. Collective.
  void rebuild(State& state, Domain& domain);

  /// To be called when a segment has `moved`: sees to it that no pair is missing, by a rebuild or,
  /// when the list still has them all, by drawing the present pairs from it anew. Collective.
  void refresh(State& state, Domain& domain);

  /// For somebody who moves all segments and sets their forces to zero, each thread its own in
  /// their order: adds bond forces while all that they need is in the cache. `startFollowing` once,
  /// then `follow` on every thread again and again: its segments below `end` are at their places.
  /// The next evaluation adds the rest.
  void startFollowing();
  void follow(State& state, int thread, std::int32_t end);

  /// Sets State::force and torque of the owned segments (and viscous, with viscous damping).
  ForceOutcome evaluate(State& state, Halo& halo, const ForceRequest& request);

  /// Hands over the pair forces on segments begin <= i < end, which evaluate() left out: adds them
  /// to the others. To be called once for every segment before the next evaluation.
  void complete(State& state, std::int32_t begin, std::int32_t end);

  /// Has the segment, now at `x`, moved so far that a pair might be missing from the present ones?
  bool moved(const double* x, int i) const {
    return !(squaredWay(x, reference_, i) <= 0.25 * margin_ * margin_);
  }
  bool tracksMotion() const { return settings_.pair != nullptr; }

  const Fibre& fibre() const { return settings_.fibre; }
  const PairForce* pair() const { return settings_.pair.get(); }
  const PairList& pairList() const { return pairs_; }
  const MinimumImage& nearest() const { return nearest_; }
  const std::optional<BreakageLaw>& breakage() const { return settings_.breakage; }
  const std::vector<Share>& shares() const { return shares_; }
  const SumUnit& energyUnit() const { return energyUnit_; }
  bool viscous() const { return static_cast<bool>(settings_.viscous); }
  /// Reach of the pair list: cutoff, segment and skin.
  double listRange() const { return settings_.pair ? settings_.pair->reach() + skin_ : 0.0; }
  double skin() const { return skin_; }
  std::int64_t rebuilds() const { return rebuilds_; }
  std::int64_t pairsResolved() const { return resolved_; }
  std::int64_t bonds() const { return bonds_.size(); }

 private:
  double squaredWay(const double* x, const std::vector<double>& from, int i) const {
    const double* r = &from[3 * static_cast<std::size_t>(i)];
    const Vec3d d = nearest_(Vec3d{x[0] - r[0], x[1] - r[1], x[2] - r[2]});
    return dot(d, d);
  }
  void noteReference(const State& state, int i) {
    for (int d = 0; d < 3; ++d)
      reference_[static_cast<std::size_t>(3 * i + d)] = state.pose[8 * i + d];
  }
  void startDrawing(const State& state);
  void tuneMargin(const State& state);
  void tuneSkin(const State& state);
  void noteWork(const State& state, Domain& domain);

  Settings settings_;
  MinimumImage nearest_;
  SumUnit energyUnit_;
  double skin_, skinLimit_;  ///< of the list
  double margin_;            ///< of the present pairs, drawn from the list
  bool draw_ = false;        ///< the next evaluation draws them
  PairList pairs_;
  BondList bonds_;
  std::vector<BondTally> followed_;  ///< what `follow` found, a thread each
  bool bondsKnown_ = false;          ///< State::force holds all that `follow` can know
  std::vector<Share> shares_;
  std::vector<double> listed_;     ///< [3]: where segments were at the rebuild
  std::vector<double> reference_;  ///< [3]: where they were at the drawing
  std::vector<double> work_;
  std::vector<ForceSum> sums_;
  std::vector<std::int64_t> viscousSums_;  ///< [6] a segment
  std::int64_t rebuilds_ = 0, resolved_ = 0;
  // Since the last rebuild, for tuning the skin.
  double drawSeconds_ = 0, rebuildSeconds_ = 0;
  std::int64_t evaluations_ = 0;
  std::int64_t drawStep_ = -1;  ///< step of the last drawing, for tuning the margin
  PetscLogEvent rebuildEvent_, bondEvent_, pairEvent_, haloEvent_;
};

/// The smallest distance of points over all listed pairs, and the segments it belongs to.
struct ClosestPair {
  double distance;
  std::int64_t fibre[2];
  std::int32_t index[2];
};
ClosestPair findClosestPair(const State& state, const ForceField& forces);

}  // namespace nanoweft
