#include "nanoweft/force/force_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/huge_pages.hpp"
#include "nanoweft/base/log.hpp"
#include "nanoweft/base/threads.hpp"

namespace nanoweft {

ForceField::ForceField(Settings settings, const Box& box)
    : settings_(std::move(settings)),
      nearest_(box),
      energyUnit_(settings_.fibre.bond.stretch * settings_.fibre.length * settings_.fibre.length),
      rebuildEvent_(logEvent("NwRebuild")),
      bondEvent_(logEvent("NwBonds")),
      pairEvent_(logEvent("NwPairs")),
      haloEvent_(logEvent("NwHalo")) {
  const double length = settings_.fibre.length;
  skin_ = settings_.skin > 0 ? settings_.skin : length;
  // Wider, it would save little more, and cost memory, ghosts and even shares: cells grow with it.
  skinLimit_ = length;
  if (settings_.pair)
    for (int d = 0; d < 3; ++d)
      if (box.periodic[d])
        skinLimit_ = std::min(skinLimit_, 0.5 * box.length(d) - settings_.pair->reach());
  if (settings_.skin == 0) skin_ = std::min(skin_, std::max(skinLimit_, 0.05 * length));
  margin_ = 0.3 * skin_;
}

void ForceField::rebuild(State& state, Domain& domain) {
  const LogScope log(rebuildEvent_);
  tuneSkin(state);
  const double begin = MPI_Wtime();
  // Without pairs the halo holds bond partners alone; the cells then only need to find them.
  domain.rebuild(state, listRange(), std::max(listRange(), 2.0 * settings_.fibre.length),
                 rebuilds_ > 0 && state.ranks() > 1 ? &work_ : nullptr);
  const CellIndex cells(state, domain.grid(), state.local());
  // All sums are zero now but the spare ones, whose places may become a segment's.
  if (!sums_.empty()) std::fill(sums_.end() - std::ssize(shares_), sums_.end(), ForceSum{});
  shares_ = shareSegments(state, domain.grid(), cells, settings_.threads);
  bonds_.build(state, domain, shares_, settings_.breakage);
  if (settings_.pair) {
    pairs_.build(state, domain.grid(), cells, shares_, listRange(), settings_.pair->exclude());
    tuneMargin(state);
    startDrawing(state);
    reference_.resize(3 * static_cast<std::size_t>(state.owned()));
#pragma omp parallel for num_threads(static_cast <int>(shares_.size()))
    for (int i = 0; i < state.owned(); ++i) noteReference(state, i);
    listed_ = reference_;
    const ForceSum* before = sums_.data();
    sums_.resize(static_cast<std::size_t>(state.owned()) + shares_.size());
    if (sums_.data() != before) preferHugePages(sums_.data(), sums_.capacity() * sizeof(ForceSum));
    if (viscous()) viscousSums_.resize(6 * static_cast<std::size_t>(state.owned()));
  }
  noteWork(state, domain);
  bondsKnown_ = false;
  ++rebuilds_;
  rebuildSeconds_ = MPI_Wtime() - begin;
  drawSeconds_ = 0;
  evaluations_ = 0;
}

void ForceField::refresh(State& state, Domain& domain) {
  // Pairs that the list does not have were a skin out of reach when it was made.
  double farthest2 = 0;
#pragma omp parallel for num_threads(static_cast <int>(shares_.size())) reduction(max : farthest2)
  for (int i = 0; i < state.owned(); ++i) {
    farthest2 = std::max(farthest2, squaredWay(state.pose + 8 * i, listed_, i));
    noteReference(state, i);
  }
  MPI_Allreduce(MPI_IN_PLACE, &farthest2, 1, MPI_DOUBLE, MPI_MAX, state.comm());
  tuneMargin(state);
  // A list that is nearly used up still serves for a thinner margin.
  const double left = skin_ - 2.0 * std::sqrt(farthest2);
  if (!(left >= 0.5 * margin_)) return rebuild(state, domain);
  margin_ = std::min(margin_, left);
  startDrawing(state);
}

void ForceField::startDrawing(const State& state) {
  draw_ = true;
  drawStep_ = state.step;
}

void ForceField::tuneMargin(const State& state) {
  // A step looks at a rim of pairs in proportion to reach x margin (a sheet), a drawing at all
  // within reach + skin, as many steps apart as the margin lasts: least together for this margin.
  // The half: pairs of the rim cost more, since their segments are not in the cache yet.
  const std::int64_t steps = drawStep_ < 0 ? 0 : state.step - drawStep_;
  if (steps < 1) return;
  const double speed = margin_ / (2.0 * static_cast<double>(steps)),
               widening = 1.0 + skin_ / settings_.pair->reach();
  margin_ = 0.5 * widening * std::sqrt(settings_.pair->reach() * speed);
  margin_ = std::min(std::max(margin_, 0.05 * settings_.fibre.length), 0.5 * skin_);
  drawStep_ = state.step;
}

void ForceField::noteWork(const State& state, Domain& domain) {
  if (state.ranks() == 1) return;
  // A segment's own part of a step costs about as much as this many pairs.
  constexpr double pairsPerSegment = 3.0;
  work_.assign(static_cast<std::size_t>(state.owned()), pairsPerSegment);
  if (settings_.pair) pairs_.count(work_);
  double sum = 0;
  for (double w : work_) sum += w;
  domain.noteWork(state, sum);
}

void ForceField::tuneSkin(const State& state) {
  if (!settings_.pair || settings_.skin > 0 || evaluations_ < 2 || rebuilds_ < 2) return;
  // Cost of a step: (rebuild + drawings) / steps between. The steps between grow like the skin, the
  // pairs to be looked at like the square of the range (a sheet) or more: follow the derivative, in
  // steps large enough to be worth a new cell grid. Rank 0 decides, since all must agree.
  double next = skin_;
  const double gain = rebuildSeconds_ / static_cast<double>(evaluations_) / skin_;
  const double loss = 2.0 * (drawSeconds_ / static_cast<double>(evaluations_)) / listRange();
  if (gain > 1.3 * loss) next = std::min(1.2 * skin_, skinLimit_);
  if (gain < 0.7 * loss) next = std::max(skin_ / 1.2, 0.2 * settings_.fibre.length);
  MPI_Bcast(&next, 1, MPI_DOUBLE, 0, state.comm());
  if (next > 0) skin_ = std::min(next, std::max(skinLimit_, skin_));
}

void ForceField::startFollowing() {
  followed_.assign(shares_.size(), BondTally{});
  for (std::size_t t = 0; t < shares_.size(); ++t) {
    followed_[t].energyUnit = energyUnit_;
    bonds_.rewind(static_cast<int>(t));
  }
  bondsKnown_ = true;
}

void ForceField::follow(State& state, int thread, std::int32_t end) {
  const auto t = static_cast<std::size_t>(thread);
  bonds_.addUpTo(state, {settings_.fibre.bond, nearest_, false, true}, thread, shares_[t], end,
                 followed_[t]);
}

ForceOutcome ForceField::evaluate(State& state, Halo& halo, const ForceRequest& request) {
  const auto threads = shares_.size();
  // Bonds that broke then are broken, even if the forces have to be computed again.
  std::vector<BondTally> bondTallies = std::exchange(followed_, {});
  bondTallies.resize(threads);
  const bool ownKnown = std::exchange(bondsKnown_, false) && !request.energies;
  std::vector<PairTally> pairTallies(threads);
  const PairForce* pair = settings_.pair.get();
  const bool viscousOn = pair && viscous() && request.viscous;
  const bool drawing = std::exchange(draw_, false);
  auto pairJob = [&](std::size_t t, bool outer) {
    PairJob job;
    job.pose = state.pose;
    DrawnPairs& drawn = outer ? pairs_.drawn()[t].outer : pairs_.drawn()[t].inner;
    // A little wider, since the estimate of the stable step displaces what it evaluates.
    if (drawing)
      pair->draw(outer ? pairs_.threads()[t].outer : pairs_.threads()[t].inner, state.pose,
                 nearest_, 1.001 * margin_, drawn);
    job.drawn = &drawn;
    job.begin = shares_[t].begin;
    job.end = shares_[t].end;
    job.spare = state.owned() + static_cast<std::int32_t>(t);
    job.sum = sums_.data();
    job.nearest = &nearest_;
    if (viscousOn) {
      job.velocity = state.velocity;
      job.angular = state.angular;
      job.viscousSum = viscousSums_.data();
      job.viscous = settings_.viscous;
    }
    return job;
  };
  const BondList::Terms terms{settings_.fibre.bond, nearest_, request.energies, request.mayBreak};
  auto bonds = [&](std::size_t t, BondList::Part part) {
    bonds_.add(state, terms, static_cast<int>(t), shares_[t], part, bondTallies[t]);
  };
  auto innerBonds = [&](std::size_t t) {
    if (!ownKnown) {
      std::fill(state.force + 3 * shares_[t].begin, state.force + 3 * shares_[t].end, 0.0);
      std::fill(state.torque + 3 * shares_[t].begin, state.torque + 3 * shares_[t].end, 0.0);
      bonds(t, BondList::own);
    }
    bonds(t, BondList::shared);
  };
  for (std::size_t t = 0; t < threads; ++t)
    bondTallies[t].energyUnit = pairTallies[t].energyUnit = energyUnit_;

  {
    const LogScope log(haloEvent_);
    halo.refreshBegin(state);
    if (viscousOn) halo.refreshVelocities(state);
  }
  {
    const LogScope log(bondEvent_);
    onShares(threads, innerBonds);
    PetscLogFlops(290.0 * static_cast<double>(bonds_.size()));
  }
  const double begin = MPI_Wtime();
  if (pair) {
    const LogScope log(pairEvent_);
    onShares(threads, [&](std::size_t t) {
      if (viscousOn)
        std::fill(viscousSums_.begin() + 6 * shares_[t].begin,
                  viscousSums_.begin() + 6 * shares_[t].end, 0);
      pair->add(pairJob(t, false), request.energies, pairTallies[t]);
    });
  }
  double waited = MPI_Wtime();
  {
    const LogScope log(haloEvent_);
    halo.refreshEnd(state);
  }
  waited = MPI_Wtime() - waited;
  if (state.ranks() > 1) {
    const LogScope log(bondEvent_);
    onShares(threads, [&](std::size_t t) { bonds(t, BondList::outer); });
  }
  if (pair) {
    const LogScope log(pairEvent_);
    onShares(threads, [&](std::size_t t) {
      pair->add(pairJob(t, true), request.energies, pairTallies[t]);
      if (request.complete) complete(state, shares_[t].begin, shares_[t].end);
      if (viscousOn) {
        const double forceUnit = pair->forceUnit(), torqueUnit = pair->torqueUnit();
        for (std::int32_t i = shares_[t].begin; i < shares_[t].end; ++i)
          for (int c = 0; c < 3; ++c) {
            const auto k = static_cast<std::size_t>(6 * i + c);
            state.viscous[k] = forceUnit * static_cast<double>(viscousSums_[k]);
            state.viscous[k + 3] = torqueUnit * static_cast<double>(viscousSums_[k + 3]);
          }
      }
    });
    std::int64_t pointPairs = 0;
    for (const PairTally& t : pairTallies) {
      resolved_ += t.resolved;
      pointPairs += t.pointPairs;
    }
    PetscLogFlops(60.0 * static_cast<double>(pointPairs));  // about; gathers and scatter aside
  }
  // Of an evaluation that draws, about a fifth goes into it.
  if (drawing) drawSeconds_ += 0.2 * (MPI_Wtime() - begin - waited);
  ++evaluations_;

  ForceOutcome outcome;
  for (std::size_t t = 0; t < threads; ++t) {
    outcome.stretch.merge(bondTallies[t].stretch);
    outcome.shear.merge(bondTallies[t].shear);
    outcome.bending.merge(bondTallies[t].bending);
    outcome.torsion.merge(bondTallies[t].torsion);
    outcome.pair.merge(pairTallies[t].energy);
    outcome.released.merge(bondTallies[t].released);
    outcome.broken.insert(outcome.broken.end(), bondTallies[t].broken.begin(),
                          bondTallies[t].broken.end());
  }
  return outcome;
}

void ForceField::complete(State& state, std::int32_t begin, std::int32_t end) {
  if (!settings_.pair) return;
  const double forceUnit = settings_.pair->forceUnit(), torqueUnit = settings_.pair->torqueUnit();
  for (std::int32_t i = begin; i < end; ++i) {
    ForceSum& sum = sums_[static_cast<std::size_t>(i)];
    for (int c = 0; c < 3; ++c) {
      state.force[3 * i + c] += forceUnit * static_cast<double>(sum.at[c]);
      state.torque[3 * i + c] += torqueUnit * static_cast<double>(sum.at[3 + c]);
    }
    // Ready for the next ones, while the record is in the cache.
    sum = {};
  }
}

ClosestPair findClosestPair(const State& state, const ForceField& forces) {
  ClosestPair closest{std::numeric_limits<double>::infinity(), {0, 0}, {0, 0}};
  if (!forces.pair()) return closest;
  for (const auto& thread : forces.pairList().threads())
    for (const auto* list : {&thread.inner, &thread.outer})
      list->forEach([&](const ListPair& p) {
        const Vec3d separation = forces.nearest()(state.position(p.j) - state.position(p.i));
        // No points of the pair are closer than this.
        if (norm(separation) - (forces.pair()->reach() - forces.pair()->cutoff()) >=
            closest.distance)
          return;
        const double distance =
            forces.pair()->closest(separation, state.orientation(p.i), state.orientation(p.j));
        if (distance < closest.distance)
          closest = {distance,
                     {state.fibre[p.i], state.fibre[p.j]},
                     {state.chain[2 * p.i], state.chain[2 * p.j]}};
      });
  struct {
    double distance;
    int rank;
  } best{closest.distance, state.rank()};
  MPI_Allreduce(MPI_IN_PLACE, &best, 1, MPI_DOUBLE_INT, MPI_MINLOC, state.comm());
  MPI_Bcast(&closest, sizeof closest, MPI_BYTE, best.rank, state.comm());
  return closest;
}

}  // namespace nanoweft
