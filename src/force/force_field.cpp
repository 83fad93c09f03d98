#include "nanoweft/force/force_field.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/huge_pages.hpp"
#include "nanoweft/base/log.hpp"
#include "nanoweft/base/threads.hpp"
#include "nanoweft/force/bond_viscosity.hpp"
#include "nanoweft/force/plastic_flow.hpp"

namespace nanoweft {

/// What an evaluation is to do, and what its threads find.
struct ForceField::Tallies {
  ForceRequest request;
  bool viscousBonds, viscousPairs;
  double margin;  ///< of the pairs to be drawn; 0: those drawn before still hold
  std::vector<BondTally> bonds;
  std::vector<PairTally> pairs;
  std::vector<WallTally> walls;
  double waited = 0;  ///< seconds, for other ranks

  ForceOutcome sum() const {
    ForceOutcome outcome;
    for (const BondTally& t : bonds) {
      outcome.stretch.merge(t.stretch);
      outcome.shear.merge(t.shear);
      outcome.bending.merge(t.bending);
      outcome.torsion.merge(t.torsion);
      outcome.released.merge(t.released);
      outcome.broken.insert(outcome.broken.end(), t.broken.begin(), t.broken.end());
    }
    for (const PairTally& t : pairs) {
      outcome.pair.merge(t.energy);
      outcome.friction.merge(t.friction);
      outcome.released.merge(t.released);
    }
    for (const WallTally& t : walls) {
      outcome.wall.merge(t.energy);
      outcome.friction.merge(t.friction);
      outcome.external.merge(t.external);
      outcome.dragged.merge(t.dragged);
    }
    return outcome;
  }
};

namespace {

/// Units in which damping may be as strong as it is at twice the speed of sound in the fibres, for
/// eight partners, and friction as strong as pair forces.
ForceUnits unitsOfViscousSums(const ForceField::Settings& settings) {
  const double speed = 2.0 * settings.kinds.speedOfSound();
  double force = settings.pairs.largestForce();
  for (const PairForces::Class& c : settings.pairs.classes()) {
    const ViscousDamping damping = settings.viscous.between(*c.force);
    const double spin = speed / settings.kinds.shortest();
    force = std::max(
        {force, damping.linear * speed, damping.angular * spin / settings.kinds.longest()});
  }
  return ForceUnits::holding(force, settings.kinds.longest());
}

}  // namespace

std::string beyondSumsText(std::int64_t step) {
  return format(
      "at step %lld forces or energies of pairs have become larger than what is summed: fibres lie "
      "deep in each other, -damping_viscous or -contact_friction and its stiffness are far too "
      "large for the pair forces, or a parameter is out of all proportion",
      static_cast<long long>(step));
}

ForceField::ForceField(Settings settings, const Box& box)
    : settings_(std::move(settings)),
      nearest_(box),
      energyUnit_(settings_.kinds.energyScale()),
      lists_({settings_.kinds, settings_.breakage, settings_.pairs, settings_.skin,
              settings_.threads, static_cast<bool>(settings_.viscous), settings_.foresees},
             box),
      links_(settings_.links, settings_.kinds),
      rebuildEvent_(logEvent("NwRebuild")),
      bondEvent_(logEvent("NwBonds")),
      pairEvent_(logEvent("NwPairs")),
      haloEvent_(logEvent("NwHalo")),
      walls_(settings_.walls, settings_.kinds) {
  if (settings_.pairs) viscousUnits_ = unitsOfViscousSums(settings_);
}

void ForceField::rebuild(State& state, Domain& domain) {
  const LogScope log(rebuildEvent_);
  // handOver has zeroed the records of segments. The threads' spare records at the end are zeroed
  // here, since they become those of segments when this rank gets more.
  if (!sums_.empty()) std::fill(sums_.end() - std::ssize(shares()), sums_.end(), ForceSum{});
  lists_.rebuild(state, domain);
  if (state.linked) links_.build(state, domain);
  if (settings_.pairs) {
    sending_ = std::ranges::any_of(lists_.pairs(), &PairList::ranksShare);
    const std::size_t threads = shares().size(),
                      apart = sending_ ? threads * static_cast<std::size_t>(state.ghosts()) : 0;
    const ForceSum* before = sums_.data();
    sums_.resize(static_cast<std::size_t>(state.owned()) + apart + threads);
    if (sums_.data() != before) preferHugePages(sums_.data(), sums_.capacity() * sizeof(ForceSum));
    if (settings_.viscous || settings_.pairs.rubs())
      viscousSums_.resize(6 * static_cast<std::size_t>(state.owned()));
  }
  if (state.extras().friction) contacts_.rebuild(state, domain);
  bondsKnown_ = false;
}

bool ForceField::redraw(const State& state, std::optional<double> farthest) {
  return lists_.redraw(state, farthest);
}

PairJob ForceField::pairJob(const State& state, std::size_t thread, bool viscous) {
  PairJob job;
  job.pose = state.pose;
  job.begin = shares()[thread].begin;
  job.end = shares()[thread].end;
  job.spare = static_cast<std::int32_t>(sums_.size() - shares().size() + thread);
  job.sum = sums_.data();
  job.nearest = &nearest_;
  if (viscous) {
    job.velocity = state.velocity;
    job.angular = state.angular;
    job.viscousSum = viscousSums_.data();
    job.viscousUnits = viscousUnits_;
  }
  return job;
}

void ForceField::addPairs(State& state, std::size_t thread, Phase phase, Tallies& tallies) {
  const double margin = tallies.margin;
  const bool energies = tallies.request.energies;
  PairTally& tally = tallies.pairs[thread];
  PairJob job = pairJob(state, thread, tallies.viscousPairs);
  FrictionJob friction{state, contacts_, tallies.request.advance};
  if (tallies.viscousPairs && settings_.pairs.rubs()) job.friction = &friction;
  job.breakage = tallies.request.mayBreak && settings_.breakage;
  job.messages = thread == 0 && state.ranks() > 1;
  for (std::size_t c = 0; c < lists_.pairs().size(); ++c) {
    const PairForces::Class& between = settings_.pairs.classes()[c];
    const PairForce& force = *between.force;
    PairList& list = lists_.pairs()[c];
    const PairList::Parts& listed = list.threads()[thread];
    PairList::Drawn& drawn = list.drawn()[thread];
    const bool sends = list.ranksShare();
    job.viscous = between.damps ? settings_.viscous.between(force) : ViscousDamping{};
    job.viscousSum =
        tallies.viscousPairs && (job.viscous || force.rubs()) ? viscousSums_.data() : nullptr;
    auto draw = [&](const PairRuns& from, DrawnPairs& to) {
      if (margin > 0) force.draw(from, state.pose, nearest_, margin, to);
    };
    auto add = [&](const DrawnPairs& pairs, Chunks chunks) {
      job.drawn = &pairs;
      job.chunks = chunks;
      force.add(job, energies, tally);
    };
    // With sums to be sent, the other half of the pairs of own segments waits until they travel.
    auto half = [&] { return (drawn.inner.ends.size() + 1) / 2; };
    switch (phase) {
      case Phase::first:
        draw(listed.inner, drawn.inner);
        add(drawn.inner, sends ? Chunks{0, half()} : Chunks{});
        drawn.shared.add(force, job, margin, energies, tally);
        break;
      case Phase::forOthers:
        if (!sends) break;
        job.both = true;
        job.spare = static_cast<std::int32_t>(thread) * state.ghosts();
        draw(listed.taken, drawn.taken);
        add(drawn.taken, {});
        break;
      case Phase::last:
        if (sends) {
          add(drawn.inner, {.begin = half()});
        } else {
          draw(listed.taken, drawn.taken);
          add(drawn.taken, {});
        }
    }
  }
}

void ForceField::sendSums(State& state, Halo& halo, Tallies& tallies) {
  ForceSum* const sums = sums_.data() + state.owned();
  {
    const LogScope log(pairEvent_);
    onShares(shares().size(),
             [&](std::size_t t) { addPairs(state, t, Phase::forOthers, tallies); });
    // Threads have summed apart.
    const auto ghosts = static_cast<std::size_t>(state.ghosts());
#pragma omp parallel for num_threads(teamOf(shares().size()))
    for (std::size_t g = 0; g < ghosts; ++g)
      for (std::size_t t = 1; t < shares().size(); ++t) {
        ForceSum& from = sums[t * ghosts + g];
        for (int c = 0; c < 6; ++c) sums[g].at[c] += from.at[c];
        from = {};
      }
  }
  const LogScope log(haloEvent_);
  halo.addGhostsBegin(sums->at);
}

void ForceField::receiveSums(const State& state, Halo& halo, Tallies& tallies) {
  const LogScope log(haloEvent_);
  const double begin = MPI_Wtime();
  ForceSum* const ghosts = sums_.data() + state.owned();
  halo.addGhostsEnd(ghosts->at, sums_.data()->at);
  tallies.waited += MPI_Wtime() - begin;
  std::fill_n(ghosts, state.ghosts(), ForceSum{});
}

void ForceField::takeShared(std::size_t thread) {
  for (PairList& list : lists_.pairs())
    for (PairList::Drawn& other : list.drawn()) other.shared.giveTo(shares()[thread], sums_.data());
}

void ForceField::addBonds(State& state, std::size_t thread, BondList::Part part, Tallies& tallies) {
  lists_.bonds().add(
      state, {settings_.kinds, nearest_, tallies.request.energies, tallies.request.mayBreak},
      static_cast<int>(thread), shares()[thread], part, tallies.bonds[thread]);
}

void ForceField::clear(State& state, std::size_t thread) const {
  const Share share = shares()[thread];
  std::fill(state.force + 3 * share.begin, state.force + 3 * share.end, 0.0);
  std::fill(state.torque + 3 * share.begin, state.torque + 3 * share.end, 0.0);
}

void ForceField::addOuterBonds(State& state, Tallies& tallies) {
  const LogScope log(bondEvent_);
  if (state.ranks() > 1)
    onShares(shares().size(), [&](std::size_t t) { addBonds(state, t, BondList::outer, tallies); });
  if (state.linked)
    links_.add(state, nearest_, tallies.request.energies, tallies.request.mayBreak,
               tallies.bonds[0]);
}

void ForceField::addViscosity(State& state, const Tallies& tallies) {
  onShares(shares().size(), [&](std::size_t t) {
    const Share share = shares()[t];
    std::fill(state.viscous + 6 * share.begin, state.viscous + 6 * share.end, 0.0);
    if (tallies.viscousBonds)
      addBondViscosity(state, settings_.kinds, nearest_, lists_.bonds(), static_cast<int>(t),
                       share);
  });
}

ExactSum ForceField::flow(State& state) const {
  ExactSum lost;
  if (!settings_.kinds.yields()) return lost;
  onShares(shares().size(), [&](std::size_t t) {
    PlasticFlow flow(settings_.kinds, nearest_, energyUnit_);
    flow.flow(state, lists_.bonds(), static_cast<int>(t), shares()[t]);
#pragma omp critical
    lost.merge(flow.lost());
  });
  return lost;
}

ForceField::Tallies ForceField::startTallies(const ForceRequest& request, bool viscous) {
  const auto threads = shares().size();
  // followed_: bonds that broke during a ForcePass count, even if their forces are computed again.
  Tallies tallies{request,
                  viscous && settings_.kinds.viscous(),
                  viscous && settings_.pairs && (settings_.viscous || settings_.pairs.rubs()),
                  lists_.takeDrawing(),
                  std::exchange(followed_, {}),
                  std::vector<PairTally>(threads),
                  {},
                  0};
  tallies.bonds.resize(threads);
  for (std::size_t t = 0; t < threads; ++t)
    tallies.bonds[t].energyUnit = tallies.pairs[t].energyUnit = energyUnit_;
  return tallies;
}

void ForceField::addInnerBonds(State& state, bool ownKnown, Tallies& tallies) {
  const LogScope log(bondEvent_);
  const bool viscous = state.extras().viscous && tallies.request.viscous;
  onShares(shares().size(), [&](std::size_t t) {
    if (viscous) startViscous(state, shares()[t]);
    if (!ownKnown) {
      clear(state, t);
      addBonds(state, t, BondList::own, tallies);
    }
    addBonds(state, t, BondList::shared, tallies);
  });
  PetscLogFlops(290.0 * static_cast<double>(lists_.bonds().size()));
}

bool ForceField::addInnerPairs(State& state, Halo& halo, Tallies& tallies) {
  Agreement* const agreement = tallies.request.agreement;
  auto wait = [&] {
    const double begin = MPI_Wtime();
    {
      const LogScope log(haloEvent_);
      halo.refreshEnd(state);
    }
    const bool hold = !agreement || agreement->listsHold();
    tallies.waited = MPI_Wtime() - begin;
    return hold;
  };
  // A rank that doubts must not compute pairs, since its positions may be no numbers.
  const bool early = agreement && agreement->doubts();
  if (early && !wait()) return false;
  if (settings_.pairs) {
    const LogScope log(pairEvent_);
    onShares(shares().size(), [&](std::size_t t) { addPairs(state, t, Phase::first, tallies); });
  }
  return early || wait();
}

ForceOutcome ForceField::abandon(Tallies& tallies) {
  std::ranges::fill(sums_, ForceSum{});
  for (PairList& list : lists_.pairs())
    for (PairList::Drawn& thread : list.drawn()) thread.shared.clear();
  followed_ = std::move(tallies.bonds);
  ForceOutcome outcome;
  outcome.again = true;
  return outcome;
}

ForceOutcome ForceField::evaluate(State& state, Halo& halo, const ForceRequest& request) {
  if (owed_) throw std::logic_error("pair forces have not been handed over");
  const bool pairs = static_cast<bool>(settings_.pairs);
  const bool viscous = state.extras().viscous && request.viscous;
  Tallies tallies = startTallies(request, viscous);
  const bool ownKnown = std::exchange(bondsKnown_, false) && !request.energies;
  {
    const LogScope log(haloEvent_);
    halo.refreshBegin(state);
    if (viscous) halo.refreshVelocities(state);
  }
  addInnerBonds(state, ownKnown, tallies);
  const double begin = MPI_Wtime();
  if (!addInnerPairs(state, halo, tallies)) return abandon(tallies);
  if (sending_) sendSums(state, halo, tallies);
  addOuterBonds(state, tallies);
  if (viscous) addViscosity(state, tallies);
  if (walls_) addWalls(state, tallies);
  if (pairs) {
    const LogScope log(pairEvent_);
    if (state.ranks() > 1)
      onShares(shares().size(), [&](std::size_t t) { addPairs(state, t, Phase::last, tallies); });
    if (sending_) receiveSums(state, halo, tallies);
    onShares(shares().size(), [&](std::size_t t) {
      takeShared(t);
      if (request.complete) handOver(state, shares()[t].begin, shares()[t].end);
      if (tallies.viscousPairs) handOverViscous(state, shares()[t]);
    });
    owed_ = !request.complete;
    notePairs(tallies);
  }
  if (viscous && state.extras().friction) endContacts(state, halo);
  // An evaluation that draws spends about a fifth of its time on drawing.
  lists_.noteEvaluation(tallies.margin > 0 ? 0.2 * (MPI_Wtime() - begin - tallies.waited) : 0.0);
  ForceOutcome outcome = tallies.sum();
  if (beyondSums_) outcome.pair.poison();
  return outcome;
}

void ForceField::notePairs(const Tallies& tallies) {
  std::int64_t pointPairs = 0;
  for (const PairTally& t : tallies.pairs) {
    resolved_ += t.resolved;
    pointPairs += t.pointPairs;
    if (t.beyondSums) beyondSums_ = true;
  }
  PetscLogFlops(60.0 * static_cast<double>(pointPairs));  // an estimate, without loads and stores
}

void ForceField::handOver(State& state, std::int32_t begin, std::int32_t end) {
  const double forceUnit = settings_.pairs.forceUnit(), torqueUnit = settings_.pairs.torqueUnit();
  std::int64_t edge = 0;
  for (std::int32_t i = begin; i < end; ++i) {
    ForceSum& sum = sums_[static_cast<std::size_t>(i)];
    edge |= atEdge(sum.at);
    for (int c = 0; c < 3; ++c) {
      state.force[3 * i + c] += forceUnit * static_cast<double>(sum.at[c]);
      state.torque[3 * i + c] += torqueUnit * static_cast<double>(sum.at[3 + c]);
    }
    // The next evaluation needs a zero record, and this one is in the cache now.
    sum = {};
  }
  if (edge < 0) beyondSums_ = true;
}

void ForceField::startViscous(const State& state, Share share) {
  if (!viscousSums_.empty())
    std::fill(viscousSums_.begin() + 6 * share.begin, viscousSums_.begin() + 6 * share.end, 0);
  if (state.extras().friction) contacts_.begin(share);
}

void ForceField::endContacts(State& state, Halo& halo) {
  onShares(shares().size(), [&](std::size_t t) { contacts_.end(state, shares()[t]); });
  if (!settings_.pairs.rubs()) return;
  halo.refreshContacts(state);
  std::vector<std::vector<ContactHistory::Heir>> heirs(shares().size());
  onShares(shares().size(), [&](std::size_t t) { heirs[t] = contacts_.heirs(state, shares()[t]); });
  for (const auto& thread : heirs)
    for (const auto& [at, spring] : thread) at[0] = spring.x, at[1] = spring.y, at[2] = spring.z;
}

void ForceField::addWalls(State& state, Tallies& tallies) {
  const bool viscous = state.extras().viscous && tallies.request.viscous;
  tallies.walls.resize(shares().size());
  onShares(shares().size(), [&](std::size_t t) {
    walls_.add(state, state.extras().friction ? &contacts_ : nullptr,
               {nearest_, state.time, tallies.request.advance, tallies.request.ahead, viscous},
               shares()[t], tallies.walls[t]);
  });
  if (tallies.request.viscous) walls_.note(tallies.walls);
  if (tallies.request.ahead > 0) walls_.noteAhead(tallies.walls);
}

void ForceField::handOverViscous(State& state, Share share) {
  std::int64_t edge = 0;
  for (std::int32_t i = share.begin; i < share.end; ++i) {
    edge |= atEdge(viscousSums_.data() + 6 * static_cast<std::size_t>(i));
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(6 * i + c);
      state.viscous[k] += viscousUnits_.force * static_cast<double>(viscousSums_[k]);
      state.viscous[k + 3] += viscousUnits_.torque * static_cast<double>(viscousSums_[k + 3]);
    }
  }
  if (edge < 0) beyondSums_ = true;
}

ForcePass::ForcePass(ForceField& forces, State& state, Purpose purpose)
    : forces_(forces), state_(state), owed_(forces.owed_) {
  if (purpose == look) return;
  forces.followed_.assign(forces.shares().size(), BondTally{});
  for (std::size_t t = 0; t < forces.shares().size(); ++t) {
    forces.followed_[t].energyUnit = forces.energyUnit_;
    forces.lists_.bonds().rewind(static_cast<int>(t));
  }
  forces.bondsKnown_ = true;
}

ForcePass::~ForcePass() {
  forces_.owed_ = false;
}

void ForcePass::moved(std::size_t thread, std::int32_t end) {
  forces_.lists_.bonds().addUpTo(state_, {forces_.settings_.kinds, forces_.nearest_, false, true},
                                 static_cast<int>(thread), forces_.shares()[thread], end,
                                 forces_.followed_[thread]);
}

}  // namespace nanoweft
