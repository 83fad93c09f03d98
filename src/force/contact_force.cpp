#include "nanoweft/force/contact_force.hpp"

#include <algorithm>
#include <utility>

#include "nanoweft/force/contact.hpp"
#include "nanoweft/force/contact_history.hpp"
#include "nanoweft/force/gather.hpp"
#include "nanoweft/force/overlap.hpp"
#include "nanoweft/force/viscous_sum.hpp"

namespace nanoweft {

namespace {

/// Which ends of the lanes' segments are free: the fourth number of a pose is the kind, a quarter
/// for a free end behind the segment and a half for one before it (State::noteFreeEnds).
FreeEnds<Lanes> freeEndsOf(const double* pose, const std::int32_t* index,
                           int (*bitsOf)(double) = freeEndBits) {
  double previous[laneCount], next[laneCount];
  for (int k = 0; k < laneCount; ++k) {
    const int ends = bitsOf(pose[8 * index[k] + 3]);
    previous[k] = ends & 1, next[k] = ends >> 1;
  }
  return {Lanes(previous, stdx::element_aligned), Lanes(next, stdx::element_aligned)};
}

/// Adds up the contacts of a job: looks at pairs, collects those that may touch, and resolves
/// `laneCount` of them at a time.
class ContactSum {
 public:
  /// The law and the friction of a contact, and units of the integer sums.
  struct Laws {
    const ContactLaw& contact;
    const FrictionLaw& friction;
    Both<double> radius;
    double force, torque;
  };
  ContactSum(const Laws& laws, const PairJob& job, bool energies, PairTally& tally)
      : laws_(laws), law_(laws.contact), job_(job), energies_(energies), tally_(tally) {}

  /// Pairs of first segments at x with axes e and the partners j; `valid`: which lanes count.
  NW_INLINE void look(const Vec3<Lanes>& x, const Vec3<Lanes>& e, const std::int32_t* i,
                      const std::int32_t* j, unsigned valid) {
    const Vec3<Lanes> r = (*job_.nearest)(gatherPositions(job_.pose, j) - x);
    const auto touching = law_.mayTouch(r, e, axis1(gatherOrientations(job_.pose, j)));
    if (!anyOf(touching)) return;
    unsigned chosen = 0;
    for (std::size_t k = 0; k < laneCount; ++k) chosen |= static_cast<unsigned>(touching[k]) << k;
    chosen &= valid;
    packLanes(chosen, i, i_ + count_);
    packLanes(chosen, j, j_ + count_);
    count_ += std::popcount(chosen);
    if (count_ >= laneCount) resolve(laneCount);
  }
  void close() {
    if (count_ > 0) resolve(count_);
  }

 private:
  [[gnu::noinline]] void resolve(int used) {
    // Padding lanes repeat the first pair.
    for (int k = used; k < laneCount; ++k) i_[k] = i_[0], j_[k] = j_[0];
    const double* pose = job_.pose;
    const Vec3<Lanes> r = (*job_.nearest)(gatherPositions(pose, j_) - gatherPositions(pose, i_));
    const Vec3<Lanes> ei = axis1(gatherOrientations(pose, i_)),
                      ej = axis1(gatherOrientations(pose, j_));
    const ContactAction<Lanes> contact =
        law_(r, ei, ej, freeEndsOf(pose, i_), freeEndsOf(pose, j_));
    LaneIntegers onI[6], onJ[6];
    auto whole = [](LaneIntegers* to, double perUnit, const Vec3<Lanes>& v) {
      to[0] = nearestIntegers(perUnit * v.x);
      to[1] = nearestIntegers(perUnit * v.y);
      to[2] = nearestIntegers(perUnit * v.z);
    };
    whole(onI, 1.0 / laws_.force, contact.force);
    for (int c = 0; c < 3; ++c) onJ[c] = -onI[c];
    whole(onI + 3, 1.0 / laws_.torque, contact.torqueI);
    whole(onJ + 3, 1.0 / laws_.torque, contact.torqueJ);
    put(i_, onI, used);
    put(j_, onJ, used);
    if (energies_)
      for (int k = 0; k < used; ++k)
        if (job_.mine(i_[k]))
          tally_.energy.add(contact.energy[static_cast<std::size_t>(k)], tally_.energyUnit);
    if (job_.breakage && endsChanged(used)) release(r, ei, ej, contact.energy, used);
    if (job_.viscousSum && job_.viscous)
      for (int k = 0; k < used; ++k)
        if (contact.energy[static_cast<std::size_t>(k)] > 0) addDamping(job_, i_[k], j_[k], tally_);
    if (job_.friction && laws_.friction)
      for (int k = 0; k < used; ++k) rub(i_[k], j_[k]);
    tally_.resolved += used;
    // What has been collected beyond a whole group moves to the front.
    std::copy(i_ + used, i_ + count_, i_);
    std::copy(j_ + used, j_ + count_, j_);
    count_ -= used;
  }

  bool endsChanged(int used) const {
    auto changed = [&](std::int32_t k) {
      const double fourth = job_.pose[8 * k + 3];
      return freeEndBits(fourth) != formerEndBits(fourth);
    };
    return std::any_of(i_, i_ + used, changed) || std::any_of(j_, j_ + used, changed);
  }

  /// Books what contacts, whose energy now is `energy`, lost as ends got free since the last step.
  [[gnu::noinline]] void release(const Vec3<Lanes>& r, const Vec3<Lanes>& ei, const Vec3<Lanes>& ej,
                                 const Lanes& energy, int used) {
    const Lanes before = law_(r, ei, ej, freeEndsOf(job_.pose, i_, formerEndBits),
                              freeEndsOf(job_.pose, j_, formerEndBits))
                             .energy;
    for (int k = 0; k < used; ++k)
      if (const auto lane = static_cast<std::size_t>(k); job_.mine(i_[k]))
        tally_.released.add(before[lane] - energy[lane], tally_.energyUnit);
  }

  /// Friction between two segments.
  void rub(std::int32_t i, std::int32_t j) {
    State& state = job_.friction->state;
    ContactHistory& history = job_.friction->history;
    const double advance = job_.friction->advance;
    auto ends = [&](std::int32_t k) {
      const int bits = state.freeEnds(k);
      return FreeEnds<double>{static_cast<double>(bits & 1), static_cast<double>(bits >> 1)};
    };
    const Vec3d r = (*job_.nearest)(state.position(j) - state.position(i)),
                ei = axis1(state.orientation(i));
    const ContactPatch patch = law_.patch(r, ei, axis1(state.orientation(j)), ends(i), ends(j));
    if (!(patch.load > 0)) return;
    // Both segments of a contact hold its spring, where they are this thread's.
    ContactHistory::Spring atI{}, atJ{};
    if (job_.mine(i)) atI = history.find(state, i, state.row[j]);
    if (job_.mine(j)) atJ = history.find(state, j, state.row[i]);
    const auto& [spring, fresh] = atI.at ? atI : atJ;
    if (!spring) return;
    const auto action = laws_.friction.act(patch, r, ei, laws_.radius.i,
                                           {triple(job_.velocity, i), triple(job_.velocity, j),
                                            triple(job_.angular, i), triple(job_.angular, j)},
                                           fresh ? 0.0 : advance, spring);
    if (atI.at && atJ.at) std::copy_n(atI.at, 3, atJ.at);
    auto add = [&](std::int32_t k, double sign, const Vec3d& torque) {
      if (!job_.mine(k)) return;
      const double force[3] = {action.forceI.x, action.forceI.y, action.forceI.z},
                   turn[3] = {torque.x, torque.y, torque.z};
      for (int c = 0; c < 3; ++c) {
        job_.viscousSum[6 * k + c] +=
            static_cast<std::int64_t>(sign) * wholeUnits(force[c], job_.viscousUnits.force, tally_);
        job_.viscousSum[6 * k + 3 + c] += wholeUnits(turn[c], job_.viscousUnits.torque, tally_);
      }
    };
    add(i, 1.0, action.torqueI);
    add(j, -1.0, action.torqueJ);
    if (job_.mine(i)) tally_.friction.add(action.power * advance, tally_.energyUnit);
  }

  void put(const std::int32_t* segments, const LaneIntegers* sums, int used) const {
    Row rows[laneCount];
    toRows<6>(sums, rows);
    for (int k = 0; k < used; ++k) {
      if (!job_.mine(segments[k])) continue;
      ForceSum& sum = job_.sum[segments[k]];
      Row row;
      std::memcpy(&row, &sum, sizeof row);
      row += rows[k];
      std::memcpy(&sum, &row, sizeof row);
    }
  }

  const Laws laws_;
  const ContactLaw& law_;
  const PairJob& job_;
  bool energies_;
  PairTally& tally_;
  int count_ = 0;
  std::int32_t i_[2 * laneCount], j_[2 * laneCount];
};

void lookAtGroups(ContactSum& sum, const LaneView& pairs, const PairJob& job) {
  const std::int32_t* partners = pairs.partners;
  for (const LaneGroup& group : pairs.groups) {
    const Vec3<Lanes> x = gatherPositions(job.pose, group.first),
                      e = axis1(gatherOrientations(job.pose, group.first));
    for (int k = 0; k < group.depth(); ++k, partners += laneCount) {
      unsigned valid = 0;
      for (int lane = 0; lane < laneCount; ++lane)
        valid |= static_cast<unsigned>(k < group.count[lane]) << lane;
      sum.look(x, e, group.first, partners, valid);
    }
  }
}

void lookAtRim(ContactSum& sum, std::span<const ListPair> rim, const PairJob& job) {
  for (std::size_t begin = 0; begin < rim.size(); begin += laneCount) {
    const std::size_t used = std::min<std::size_t>(laneCount, rim.size() - begin);
    std::int32_t i[laneCount], j[laneCount];
    for (std::size_t k = 0; k < laneCount; ++k) {
      const ListPair& p = rim[begin + std::min(k, used - 1)];
      i[k] = p.i, j[k] = p.j;
    }
    sum.look(gatherPositions(job.pose, i), axis1(gatherOrientations(job.pose, i)), i, j,
             (1u << used) - 1);
  }
}

class ContactForce final : public PairForce {
 public:
  ContactForce(const ContactLaw& law, const FrictionLaw& friction, const PairTraits& traits,
               const PairChoice& choice)
      : law_(law), friction_(friction) {
    traits_ = traits;
    points_ = PointChoice{1, 1};
    exclude_ = choice.exclude;
    length_ = choice.length;
    cutoff_ = law.touch();
    reach_ = law.reach();
    setUnits(traits.largestForce, std::max(length_.i, length_.j));
  }

  void add(const PairJob& job, bool energies, PairTally& tally) const override {
    ContactSum sum({law_, friction_, traits_.radius, forceUnit_, torqueUnit_}, job, energies,
                   tally);
    const DrawnPairs& drawn = *job.drawn;
    const Chunks chunks = drawn.existing(job.chunks);
    for (std::size_t k = chunks.begin; k < chunks.end; ++k) {
      const DrawnPairs::Ends begin = drawn.begin(k), &end = drawn.ends[k];
      lookAtGroups(sum, drawn.inside.between(begin.inside, end.inside), job);
      lookAtRim(sum, std::span(drawn.rim).subspan(begin.rim, end.rim - begin.rim), job);
    }
    sum.close();
  }

  PairAction resolve(const Vec3d& separation, const Quatd& qi, const Quatd& qj,
                     Both<int> freeEnds) const override {
    auto ends = [](int bits) {
      return FreeEnds<double>{static_cast<double>(bits & 1), static_cast<double>(bits >> 1)};
    };
    const auto contact = law_(separation, axis1(qi), axis1(qj), ends(freeEnds.i), ends(freeEnds.j));
    return {contact.energy, contact.force};
  }
  PairAction average(Both<int>, const Vec3d& separation, const Vec3d& ei,
                     const Vec3d& ej) const override {
    const auto contact = law_(separation, ei, ej, FreeEnds<double>{}, FreeEnds<double>{});
    return {contact.energy, contact.force};
  }
  double closest(const Vec3d& separation, const Quatd& qi, const Quatd& qj) const override {
    return distanceOfPieces(separation, axis1(qi), axis1(qj), pointSpan());
  }
  bool touches() const override { return true; }
  bool rubs() const override { return static_cast<bool>(friction_); }
  bool damps() const override { return friction_.restitution < 1; }
  Both<double> pointSpan() const override { return {0.5 * length_.i, 0.5 * length_.j}; }

 private:
  ContactLaw law_;
  FrictionLaw friction_;
};

}  // namespace

std::unique_ptr<PairForce> makeContactForce(const ContactLaw& law, const FrictionLaw& friction,
                                            const PairTraits& traits, const PairChoice& choice) {
  return std::make_unique<ContactForce>(law, friction, traits, choice);
}

}  // namespace nanoweft
