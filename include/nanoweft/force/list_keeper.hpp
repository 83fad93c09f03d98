/// Keeps the lists of bonds and pairs up to date while segments move: it decides when the lists are
/// made anew and how wide their skin is.
///
/// The pair list (pair_list.hpp) holds all pairs within reach plus a skin. The pairs that a step
/// goes through are drawn from it: all within reach plus a margin, which is thinner than the skin.
/// A new drawing is cheap, a new list is not. Skin and margin are tuned while running; no result
/// depends on them.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/bond_list.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "nanoweft/force/pair_list.hpp"

namespace nanoweft {

class ListKeeper {
 public:
  struct Settings {
    const Kinds& kinds;
    const Breakage& breakage;
    const PairForces& pairs;
    double skin = 0;  ///< 0: tuned while running
    int threads = 1;
    bool damped = false;    ///< is there viscous damping of pairs?
    bool foresees = false;  ///< ForceField::Settings
  };
  /// What the settings refer to must outlive this.
  ListKeeper(const Settings& settings, const Box& box);

  /// Takes effect at the next rebuild.
  void setThreads(int threads) { settings_.threads = threads; }

  /// Distributes the segments anew and makes the lists. Collective.
  void rebuild(State& state, Domain& domain);
  /// Marks the lists as out of date for another reason than motion (bonds changed, say): the next
  /// step makes them anew.
  void outdate() { outdated_ = true; }
  bool outdated() const { return outdated_; }
  /// Are segments followed ahead, so that ranks may hear a step late that some move too far?
  bool foresees() const { return settings_.foresees; }
  /// After a segment has `moved`: lets the next evaluation draw its pairs anew. Returns false, on
  /// all ranks, if the list may lack a pair: then the caller has to rebuild it. Collective.
  /// `farthest`: how far any segment of any rank may have gone since the rebuild, the same on all
  /// ranks; without it the ranks ask each other.
  bool redraw(const State& state, std::optional<double> farthest = {});
  /// How far a segment of this rank had gone since the rebuild when pairs were drawn last.
  double farthest() const { return farthest_; }
  /// How far a segment may have gone since pairs were drawn, if it is found as it moves out.
  double wayToDrawing() const { return 0.6 * margin_; }

  /// The box has been strained by these factors, with all segments in it. Motion counts from there.
  /// Throws RunError when it has become too thin for the pair lists, on all ranks.
  void stretch(const Box& box, const std::array<double, 3>& factor);
  /// The box has been sheared by this strain along its tilt, with all segments in it.
  void shear(const Box& box, double strain);

  /// Has the segment, whose pose is now `p`, moved or turned so far that a pair might be missing
  /// from the drawn ones?
  bool moved(const double* p, int i) const {
    return !holds(squaredWay(p, reference_, i), span_ > 0 ? squaredTurn(p, i) : 0.0);
  }
  /// Has it, or will it have at this velocity and angular velocity within the time `ahead`?
  bool movesSoon(const double* p, const double* v, const double* w, double ahead, int i) const {
    const Vec3d way = wayFrom(p, reference_, i);
    const Vec3d then = way + ahead * Vec3d{v[0], v[1], v[2]};
    const double way2 = std::max(dot(way, way), dot(then, then));
    if (!(span_ > 0)) return !holds(way2, 0.0);
    const Vec3d axis = axis1(Quatd{p[4], p[5], p[6], p[7]}), turn = axis - axisBefore(i);
    const Vec3d turnThen = turn + ahead * cross(Vec3d{w[0], w[1], w[2]}, axis);
    return !holds(way2, span_ * span_ * std::max(dot(turn, turn), dot(turnThen, turnThen)));
  }
  bool tracksMotion() const { return static_cast<bool>(settings_.pairs); }

  const std::vector<Share>& shares() const { return shares_; }
  BondList& bonds() { return bonds_; }
  const BondList& bonds() const { return bonds_; }
  /// The pair lists, one for each of PairForces::classes.
  std::vector<PairList>& pairs() { return pairs_; }
  const std::vector<PairList>& pairs() const { return pairs_; }
  /// The largest reach of a pair list: cutoff, segment and skin.
  double range() const { return settings_.pairs ? settings_.pairs.reach() + skin_ : 0.0; }
  std::int64_t rebuilds() const { return rebuilds_; }

  /// The margin with which the next evaluation has to draw its pairs, once; 0: they still hold.
  double takeDrawing();
  /// Notes that an evaluation has been made, and that drawing took `drawing` seconds of it.
  void noteEvaluation(double drawing);

 private:
  /// Do the drawn pairs hold for a segment whose centre, and whose outermost point as it turns,
  /// went so far?
  bool holds(double way2, double turn2) const {
    const double left = margin_ - 2.0 * stretched_;
    // (a + b)^2 <= 1.1 a^2 + 11 b^2.
    if (span_ > 0) way2 = 1.1 * way2 + 11.0 * turn2;
    return left >= 0 && way2 <= 0.25 * left * left;
  }
  Vec3d wayFrom(const double* x, const std::vector<double>& from, int i) const {
    const double* r = &from[3 * static_cast<std::size_t>(i)];
    return nearest_(Vec3d{x[0] - r[0], x[1] - r[1], x[2] - r[2]});
  }
  double squaredWay(const double* x, const std::vector<double>& from, int i) const {
    const Vec3d d = wayFrom(x, from, i);
    return dot(d, d);
  }
  Vec3d axisBefore(int i) const {
    const double* e = &axes_[3 * static_cast<std::size_t>(i)];
    return {e[0], e[1], e[2]};
  }
  double squaredTurn(const double* p, int i) const {
    const Vec3d d = axis1(Quatd{p[4], p[5], p[6], p[7]}) - axisBefore(i);
    return span_ * span_ * dot(d, d);
  }
  void noteReference(const State& state, int i) {
    const auto at = static_cast<std::size_t>(3 * i);
    for (std::size_t d = 0; d < 3; ++d)
      reference_[at + d] = state.pose[8 * i + static_cast<int>(d)];
    if (span_ > 0) {
      const Vec3d e = axis1(state.orientation(i));
      axes_[at] = e.x, axes_[at + 1] = e.y, axes_[at + 2] = e.z;
    }
  }
  void makePairLists(State& state, const Domain& domain, const CellIndex& cells);
  void listKinds(const State& state);
  void startDrawing(const State& state);
  void tuneMargin(const State& state);
  void tuneSkin(const State& state);
  /// The widest skin with which no pair of the lists has two images in the box.
  double room(const Box& box) const;
  /// The thinnest skin that is taken.
  double leastSkin() const;
  void noteWork(const State& state, Domain& domain);

  Settings settings_;
  MinimumImage nearest_;
  double skin_;    ///< of the pair list
  double margin_;  ///< of the drawn pairs
  bool outdated_ = false;
  /// By how much a box that is strained may have moved two listed segments apart or together, since
  /// the drawing and since the rebuild; half of it a segment.
  double stretched_ = 0, listStretched_ = 0;
  double farthest_ = 0;
  bool draw_ = false;  ///< the next evaluation draws its pairs anew
  std::vector<PairList> pairs_;
  BondList bonds_;
  std::vector<Share> shares_;
  std::vector<double> listed_;     ///< [3]: where segments were at the rebuild
  std::vector<double> reference_;  ///< [3]: where they were at the drawing
  /// How far the outermost point lies from the centre, where a law is split; else 0.
  double span_ = 0;
  std::vector<double> axes_;  ///< [3]: axes at the drawing, if span_ > 0
  std::vector<double> work_;
  std::int64_t rebuilds_ = 0;
  // Counted since the last rebuild, to tune the skin.
  double drawSeconds_ = 0, rebuildSeconds_ = 0;
  std::int64_t evaluations_ = 0;
  std::int64_t drawStep_ = -1;  ///< step of the last drawing, to tune the margin
};

}  // namespace nanoweft
