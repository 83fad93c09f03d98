/// The force field: evaluates all forces of bonds and pairs, on all threads and ranks.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/agreement.hpp"
#include "nanoweft/force/contact_history.hpp"
#include "nanoweft/force/link_forces.hpp"
#include "nanoweft/force/list_keeper.hpp"
#include "nanoweft/force/wall_forces.hpp"

namespace nanoweft {

/// What one evaluation found on this rank. The observers that report sums add them over the ranks.
struct ForceOutcome {
  /// When energies were asked for. That of pairs is no number from where pair forces or viscous
  /// forces got too large for their sums.
  ExactSum stretch, shear, bending, torsion, pair;
  ExactSum released;                 ///< energy of bonds that broke
  ExactSum wall;                     ///< energy of contacts with walls
  ExactSum friction, external;       ///< work that friction took out, that walls put in
  ExactSum dragged;                  ///< the part of `external` that comes by friction
  std::vector<std::int64_t> broken;  ///< rows of the first segments of those bonds
  /// The lists lack a pair. The caller renews them and evaluates again; until then no force is
  /// right. The next outcome has the bonds that broke in this evaluation, too.
  bool again = false;
};

struct ForceRequest {
  bool energies = false;
  bool mayBreak = true;
  bool viscous = true;   ///< false: leave State::viscous as it is
  double advance = 0;    ///< time since the last evaluation, by which friction's springs advance
  bool complete = true;  ///< false: pair forces are left to a ForcePass
  double ahead = 0;      ///< time to the next one, in which prescribed walls move on
  /// Waited for when the pairs of own segments have been computed, unless null. Not together with
  /// energies or friction, which cannot be evaluated again.
  Agreement* agreement = nullptr;
};

/// What to say where ForceField::beyondSums is true.
std::string beyondSumsText(std::int64_t step);

class ForceField {
 public:
  struct Settings {
    Kinds kinds;
    PairForces pairs;
    Breakage breakage;
    ViscousDamping viscous;  ///< of lengths of 2 rf
    LinkLaws links;
    Walls walls;
    double skin = 0;  ///< 0: tuned while running
    int threads = 1;
    bool foresees = false;  ///< may ranks hear a step late that segments move?
  };
  explicit ForceField(Settings settings, const Box& box);
  ForceField(const ForceField&) = delete;
  ForceField& operator=(const ForceField&) = delete;

  /// Distributes the segments anew and makes the lists. Collective.
  void rebuild(State& state, Domain& domain);
  /// To be called when ListKeeper::moved is true of some segment: lets the next evaluation draw the
  /// pairs anew. Returns false if the lists have to be made anew. As ListKeeper::redraw.
  /// Collective.
  bool redraw(const State& state, std::optional<double> farthest = {});

  /// Sets State::force and torque of the owned segments (and viscous, with viscous damping).
  /// Collective. Throws std::logic_error when the pair forces of the last evaluation still wait for
  /// a ForcePass.
  ForceOutcome evaluate(State& state, Halo& halo, const ForceRequest& request);

  const Kinds& kinds() const { return settings_.kinds; }
  const PairForces& pairs() const { return settings_.pairs; }
  ListKeeper& lists() { return lists_; }
  const ListKeeper& lists() const { return lists_; }
  const std::vector<Share>& shares() const { return lists_.shares(); }
  const MinimumImage& nearest() const { return nearest_; }
  const Breakage& breakage() const { return settings_.breakage; }
  const LinkForces& links() const { return links_; }
  const ContactHistory& contacts() const { return contacts_; }
  WallForces& walls() { return walls_; }
  const WallForces& walls() const { return walls_; }
  const SumUnit& energyUnit() const { return energyUnit_; }
  /// The box has been strained by these factors, with all segments in it.
  void stretch(const Box& box, const std::array<double, 3>& factor) {
    nearest_ = MinimumImage(box);
    lists_.stretch(box, factor);
  }
  /// The box has been sheared by this strain along its tilt, with all segments in it.
  void shear(const Box& box, double strain) {
    nearest_ = MinimumImage(box);
    lists_.shear(box, strain);
  }
  /// Lets bonds flow plastically, and returns the elastic energy that this rank's bonds lost. To be
  /// called after an evaluation, before segments move.
  ExactSum flow(State& state) const;
  std::int64_t pairsResolved() const { return resolved_; }
  /// Have sums of forces on some segment of this rank been out of the integers' range?
  bool beyondSums() const { return beyondSums_; }

 private:
  friend class ForcePass;
  struct Tallies;
  Tallies startTallies(const ForceRequest& request, bool viscous);
  PairJob pairJob(const State& state, std::size_t thread, bool viscous);
  /// When pairs are resolved: while the positions of ghosts travel; when they have arrived, what
  /// other ranks wait for; while that travels.
  enum class Phase { first, forOthers, last };
  void addPairs(State& state, std::size_t thread, Phase phase, Tallies& tallies);
  /// Resolves the pairs that this rank has taken for others, too, and sends off their sums.
  void sendSums(State& state, Halo& halo, Tallies& tallies);
  /// Adds what other ranks have summed on this rank's segments.
  void receiveSums(const State& state, Halo& halo, Tallies& tallies);
  /// Adds what other threads have summed on a thread's segments.
  void takeShared(std::size_t thread);
  void addBonds(State& state, std::size_t thread, BondList::Part part, Tallies& tallies);
  /// Adds the bonds within this rank, those of a thread's own segments unless a ForcePass has.
  void addInnerBonds(State& state, bool ownKnown, Tallies& tallies);
  /// Adds the pairs of own segments while the ghosts' positions and the agreement travel. Returns
  /// false if the lists do not hold.
  bool addInnerPairs(State& state, Halo& halo, Tallies& tallies);
  /// Gives up an evaluation before anything but bonds has come out of it.
  ForceOutcome abandon(Tallies& tallies);
  /// Adds the bonds with a ghost, and the links.
  void addOuterBonds(State& state, Tallies& tallies);
  /// Sets State::viscous to what bonds do.
  void addViscosity(State& state, const Tallies& tallies);
  void clear(State& state, std::size_t thread) const;
  /// Adds the summed pair forces on segments begin <= i < end to State::force and torque.
  void handOver(State& state, std::int32_t begin, std::int32_t end);
  void startViscous(const State& state, Share share);
  /// Forgets contacts that are gone, and lets new ones take over springs.
  void endContacts(State& state, Halo& halo);
  void addWalls(State& state, Tallies& tallies);
  void handOverViscous(State& state, Share share);
  void notePairs(const Tallies& tallies);

  Settings settings_;
  MinimumImage nearest_;
  SumUnit energyUnit_;
  ListKeeper lists_;
  LinkForces links_;
  std::vector<BondTally> followed_;       ///< what the threads of a ForcePass found in their bonds
  bool bondsKnown_ = false;               ///< a ForcePass has added the threads' own bonds already
  std::atomic<bool> beyondSums_ = false;  ///< sums of forces have been out of the integers' range
  bool owed_ = false;                     ///< pair forces wait in sums_ for a ForcePass
  bool sending_ = false;                  ///< are sums on ghosts sent to their owners?
  /// Of the owned segments, of the ghosts for each thread if they are sent, a spare one for each
  /// thread.
  std::vector<ForceSum> sums_;
  ForceUnits viscousUnits_;
  std::vector<std::int64_t> viscousSums_;  ///< [6] a segment
  std::int64_t resolved_ = 0;
  PetscLogEvent rebuildEvent_, bondEvent_, pairEvent_, haloEvent_;
  ContactHistory contacts_;
  WallForces walls_;
};

/// One pass over the owned segments between two evaluations, made by the stepper that moves them.
/// It does two things while a segment is in the cache anyway: before the segment moves, it adds the
/// pair forces that the last evaluation left in its sums (ForceRequest::complete); after the move,
/// it adds the bond forces at the new positions.
///
/// Each thread goes through its share in order. It calls `handOver` for a group of segments before
/// it uses their forces. When it has moved them it sets their forces to zero and calls `moved`.
class ForcePass {
 public:
  enum Purpose {
    look,  ///< segments stay where they are
    move,  ///< all segments move, and their forces are set to zero
  };
  ForcePass(ForceField& forces, State& state, Purpose purpose);
  ~ForcePass();
  ForcePass(const ForcePass&) = delete;
  ForcePass& operator=(const ForcePass&) = delete;

  void handOver(std::int32_t begin, std::int32_t end) {
    if (owed_) forces_.handOver(state_, begin, end);
  }
  /// The thread's segments below `end` are at their new places.
  void moved(std::size_t thread, std::int32_t end);

 private:
  ForceField& forces_;
  State& state_;
  bool owed_;
};

}  // namespace nanoweft
