#include "nanoweft/force/list_keeper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/threads.hpp"

namespace nanoweft {

ListKeeper::ListKeeper(const Settings& settings, const Box& box)
    : settings_(settings), nearest_(box) {
  const double length = settings_.kinds.shortest();
  skin_ = settings_.skin > 0 ? settings_.skin : std::clamp(room(box), leastSkin(), length);
  margin_ = 0.05 * length;  // tuned from the second drawing on
  // Damping and contacts keep more of a segment than one sum of forces, and its thread keeps it.
  for (const PairForces::Class& c : settings_.pairs.classes()) {
    pairs_.emplace_back(!settings_.damped && !c.force->touches() && !c.force->rubs());
    if (const NearRange near = c.force->nearRange(); near.cutoff > 0)
      span_ = std::max({span_, near.span().i, near.span().j});
  }
}

void ListKeeper::rebuild(State& state, Domain& domain) {
  tuneSkin(state);
  const double begin = MPI_Wtime();
  // Without pairs the halo holds bond partners alone; the cells then only need to find them.
  domain.rebuild(state, range(), std::max(range(), 2.0 * settings_.kinds.longest()),
                 rebuilds_ > 0 && state.ranks() > 1 ? &work_ : nullptr);
  const CellIndex cells(state, domain.grid(), state.local());
  // Pairs of two shares cost more than others, so there are no more shares than threads that work.
  shares_ =
      shareSegments(state, domain.grid(), cells, std::min(settings_.threads, teamMeter().most));
  bonds_.build(state, domain, shares_, settings_.breakage);
  if (settings_.pairs) makePairLists(state, domain, cells);
  noteWork(state, domain);
  outdated_ = false;
  listStretched_ = farthest_ = 0;
  ++rebuilds_;
  rebuildSeconds_ = MPI_Wtime() - begin;
  drawSeconds_ = 0;
  evaluations_ = 0;
}

void ListKeeper::makePairLists(State& state, const Domain& domain, const CellIndex& cells) {
  if (settings_.kinds.several())
    listKinds(state);
  else
    for (std::size_t c = 0; c < pairs_.size(); ++c)
      pairs_[c].build(state, {domain.grid(), cells}, shares_,
                      settings_.pairs.classes()[c].force->reach() + skin_,
                      settings_.pairs.exclude());
  tuneMargin(state);
  margin_ = std::min(margin_, skin_);
  startDrawing(state);
  reference_.resize(3 * static_cast<std::size_t>(state.owned()));
  if (span_ > 0) axes_.resize(reference_.size());
#pragma omp parallel for num_threads(teamOf(shares_.size()))
  for (int i = 0; i < state.owned(); ++i) noteReference(state, i);
  listed_ = reference_;
}

void ListKeeper::listKinds(const State& state) {
  std::vector<std::vector<int>> ofKind(static_cast<std::size_t>(settings_.kinds.count()));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> lower{infinity, infinity, infinity}, upper{-infinity, -infinity, -infinity};
  for (int i = 0; i < state.local(); ++i) {
    ofKind[static_cast<std::size_t>(state.kind(i))].push_back(i);
    for (std::size_t d = 0; d < 3; ++d) {
      lower[d] = std::min(lower[d], state.pose[8 * static_cast<std::size_t>(i) + d]);
      upper[d] = std::max(upper[d], state.pose[8 * static_cast<std::size_t>(i) + d]);
    }
  }
  for (std::size_t d = 0; d < 3; ++d)
    if (state.box.periodic[d]) lower[d] = state.box.lower[d], upper[d] = state.box.upper[d];
  const auto& classes = settings_.pairs.classes();
  for (std::size_t c = 0; c < classes.size(); ++c) {
    const auto first = static_cast<std::size_t>(classes[c].first),
               second = static_cast<std::size_t>(classes[c].second);
    const PairForce& force = *classes[c].force;
    const auto& others = ofKind[second];
    const double range = force.reach() + skin_;
    // Cells for the others' own range: those for a range far beyond it would hold too many.
    const PairForce* among = settings_.pairs.between(classes[c].second, classes[c].second);
    const double edge = std::min(range, among ? among->reach() + skin_ : range);
    const CellLattice lattice(lower, upper, state.box, edge, range,
                              static_cast<double>(others.size()));
    const CellIndex cells(state, lattice, others);
    if (classes[c].mixed())
      pairs_[c].buildMixed(state, ofKind[first], {lattice, cells}, shares_, range);
    else
      pairs_[c].build(state, {lattice, cells}, shares_, range, force.exclude());
  }
}

double ListKeeper::room(const Box& box) const {
  double room = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d)
    if (settings_.pairs && box.periodic[d])
      room = std::min(room, 0.5 * box.length(d) - settings_.pairs.reach());
  return room;
}

double ListKeeper::leastSkin() const {
  return settings_.skin > 0 ? settings_.skin : 0.05 * settings_.kinds.shortest();
}

void ListKeeper::stretch(const Box& box, const std::array<double, 3>& factor) {
  nearest_ = MinimumImage(box);
  double most = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    const double middle = 0.5 * (box.lower[d] + box.upper[d]);
    most = std::max(most, std::abs(factor[d] - 1.0));
    for (std::vector<double>* places : {&reference_, &listed_})
      for (std::size_t k = d; k < places->size(); k += 3)
        (*places)[k] = middle + factor[d] * ((*places)[k] - middle);
  }
  if (const double wide = room(box); wide < skin_) {
    if (wide < leastSkin())
      throw RunError(format(
          "the periodic box has become too thin: two list ranges (reach of the forces + skin) "
          "are %g at least, and it is %g x %g x %g",
          2.0 * (settings_.pairs.reach() + leastSkin()), box.length(0), box.length(1),
          box.length(2)));
    // Thinner than need be, so that a box that goes on shrinking has new lists now and then only.
    skin_ = std::max(0.8 * wide, leastSkin());
    outdated_ = true;
  }
  stretched_ += most * range();
  listStretched_ += most * range();
}

void ListKeeper::shear(const Box& box, double strain) {
  nearest_ = MinimumImage(box);
  const auto along = static_cast<std::size_t>(box.tilt.along),
             across = static_cast<std::size_t>(box.tilt.across);
  const double middle = 0.5 * (box.lower[across] + box.upper[across]);
  for (std::vector<double>* places : {&reference_, &listed_})
    for (std::size_t k = 0; k < places->size(); k += 3)
      (*places)[k + along] += strain * ((*places)[k + across] - middle);
  stretched_ += std::abs(strain) * range();
  listStretched_ += std::abs(strain) * range();
}

bool ListKeeper::redraw(const State& state, std::optional<double> farthest) {
  // A pair that the list lacks was farther apart than reach + skin when the list was made.
  double farthest2 = 0;
#pragma omp parallel for num_threads(teamOf(shares_.size())) reduction(max : farthest2)
  for (int i = 0; i < state.owned(); ++i) {
    farthest2 = std::max(farthest2, squaredWay(state.pose + 8 * i, listed_, i));
    noteReference(state, i);
  }
  farthest_ = std::sqrt(farthest2);
  if (!farthest) {
    farthest = farthest_;
    if (state.ranks() > 1)
      MPI_Allreduce(MPI_IN_PLACE, &*farthest, 1, MPI_DOUBLE, MPI_MAX, state.comm());
  }
  tuneMargin(state);
  // If less of the skin is left than the margin, the list still serves for a thinner margin.
  const double left = skin_ - 2.0 * *farthest - 2.0 * listStretched_;
  if (!(left >= 0.5 * margin_)) return false;
  margin_ = std::min(margin_, left);
  startDrawing(state);
  return true;
}

double ListKeeper::takeDrawing() {
  // A little wider than asked, since the estimate of the stable step evaluates displaced segments.
  return std::exchange(draw_, false) ? 1.001 * margin_ : 0.0;
}

void ListKeeper::noteEvaluation(double drawing) {
  drawSeconds_ += drawing;
  ++evaluations_;
}

void ListKeeper::startDrawing(const State& state) {
  draw_ = true;
  stretched_ = 0;
  drawStep_ = state.step;
}

void ListKeeper::tuneMargin(const State& state) {
  // A step looks at the pairs of the rim, in proportion to reach x margin (for a sheet); with a law
  // that is split, at the near pairs of the margin. A drawing looks at all within reach + skin,
  // once in the steps that the margin lasts. This margin makes the sum of both least. The factor
  // 0.5: pairs of the rim cost more, since their segments are not in the cache yet.
  const std::int64_t steps = drawStep_ < 0 ? 0 : state.step - drawStep_;
  if (steps < 1) return;
  const double speed = margin_ / (2.0 * static_cast<double>(steps)),
               reach = settings_.pairs.reach(), widening = 1.0 + skin_ / reach;
  margin_ = 0.5 * widening * std::sqrt(reach * speed);
  margin_ = std::min(std::max(margin_, 0.05 * settings_.kinds.shortest()), 0.5 * skin_);
  drawStep_ = state.step;
}

void ListKeeper::noteWork(const State& state, Domain& domain) {
  if (state.ranks() == 1) return;
  // What a step does for each segment (bonds, motion) costs about as much as this many pairs.
  constexpr double pairsPerSegment = 3.0;
  // A ghost, whose position comes and whose sums go, costs as much as six pairs (a dense bundle on
  // two ranks, straight cuts against METIS), and something in the lists.
  constexpr double pairsPerGhost = 8.0;
  work_.assign(static_cast<std::size_t>(state.owned()), pairsPerSegment);
  double resolved = pairsPerSegment * state.owned() + pairsPerGhost * state.ghosts();
  const auto& classes = settings_.pairs.classes();
  for (std::size_t c = 0; c < classes.size(); ++c) {
    // A pair of the first class counts 1.
    auto pointPairs = [&](std::size_t k) {
      const Both<int> n = classes[k].force->points().near;
      return static_cast<double>(n.i * n.j);
    };
    const double weight = pointPairs(c) / pointPairs(0);
    pairs_[c].count(weight, work_);
    resolved += weight * static_cast<double>(pairs_[c].size());
  }
  double sum = 0;
  for (double w : work_) sum += w;
  domain.noteWork(state, sum, resolved);
}

void ListKeeper::tuneSkin(const State& state) {
  if (!settings_.pairs || settings_.skin > 0 || evaluations_ < 2 || rebuilds_ < 2) return;
  // Cost of the lists per step: (rebuild + drawings) / (steps between rebuilds). The steps between
  // grow like the skin, the pairs that a drawing looks at like the square of the range (a sheet) or
  // more. The skin follows the derivative, by changes large enough to be worth a new cell grid.
  // Rank 0 decides, since all ranks must agree.
  constexpr std::int64_t few = 30;
  // A wider skin would save little more time, and would cost memory and ghosts. It would also make
  // the shares of ranks less equal, since cells grow with it. But a fibre that recoils after a
  // break outruns one segment in a few steps, and all lists with it.
  const double limit =
      std::min(room(state.box), (evaluations_ < few ? 2.0 : 1.0) * settings_.kinds.shortest());
  double next = skin_;
  const double gain = rebuildSeconds_ / static_cast<double>(evaluations_) / skin_;
  const double loss = 2.0 * (drawSeconds_ / static_cast<double>(evaluations_)) / range();
  if (gain > 1.3 * loss) next = std::max(skin_, std::min(1.2 * skin_, limit));
  if (gain < 0.7 * loss) next = std::max(skin_ / 1.2, 0.2 * settings_.kinds.shortest());
  MPI_Bcast(&next, 1, MPI_DOUBLE, 0, state.comm());
  if (next > 0) skin_ = std::min(next, std::max(limit, skin_));
}

}  // namespace nanoweft
