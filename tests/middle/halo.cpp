/// Domain and halo: who sees whom, and what ghosts know of their owners.
#include "nanoweft/domain/halo.hpp"

#include <csignal>
#include <set>

#include "middle/segments.hpp"

namespace nanoweft::test {
namespace {

constexpr double range = 15;

class HaloOf : public testing::TestWithParam<PartitionSettings::Kind> {
 protected:
  HaloOf() {
    fillScene(state);
    rebuild();
  }
  void rebuild() { domain.rebuild(state, range, range, nullptr); }

  State state{PETSC_COMM_WORLD, sceneBox(), allFields};
  Domain domain{state, {GetParam(), 1.05, 4}};
};
INSTANTIATE_TEST_SUITE_P(Partitions, HaloOf,
                         testing::Values(PartitionSettings::rectilinear, PartitionSettings::metis));

bool tied(std::int64_t a, std::int64_t b) {
  if (a / fibreLength != b / fibreLength) return false;
  const std::int64_t apart = std::abs(a - b);
  return apart == 1 || (a >= firstClosed && apart == fibreLength - 1);
}

/// Rows that a rank with these must see: those within range of them, and what they are bonded to.
std::set<std::int64_t> neededBy(const std::set<std::int64_t>& own) {
  const Reference reference;
  const State& all = reference.state();
  const MinimumImage nearest(all.box);
  std::set<std::int64_t> needed;
  for (const std::int64_t row : own)
    for (int j = 0; j < all.owned(); ++j) {
      const Vec3d d = nearest(all.position(j) - all.position(static_cast<int>(row)));
      if (!own.contains(j) && (dot(d, d) < range * range || tied(row, j))) needed.insert(j);
    }
  return needed;
}

TEST_P(HaloOf, GhostsAreWhatOwnSegmentsReachAndAreBondedTo) {
  std::set<std::int64_t> own, ghosts;
  for (int i = 0; i < state.local(); ++i) (i < state.owned() ? own : ghosts).insert(state.row[i]);
  EXPECT_EQ(static_cast<int>(ghosts.size()), state.ghosts());
  EXPECT_EQ(ghosts, neededBy(own));
  EXPECT_EQ(ghosts.empty(), state.ranks() == 1);
  expectEveryRowOnce(state);
}

TEST_P(HaloOf, GhostsCarryWhatTheTableSays) {
  const Reference reference;
  for (const Field& f : fields)
    for (int i = state.owned(); i < state.local(); ++i)
      if (f.ghosts == Ghosts::whenBuilt || f.ghosts == Ghosts::everyStep) {
        ASSERT_TRUE(reference.same(f, state, i)) << f.name << " of row " << state.row[i];
      }
}

TEST_P(HaloOf, RefreshingBringsWhatHasChangedSince) {
  const Reference moved(0.125);
  for (int i = 0; i < state.owned(); ++i) setSegment(state, i, state.row[i], 0.125);
  auto expectGhosts = [&](Ghosts which) {
    for (const Field& f : fields)
      for (int i = state.owned(); f.ghosts == which && i < state.local(); ++i)
        ASSERT_TRUE(moved.same(f, state, i)) << f.name << " of row " << state.row[i];
  };
  domain.halo().refreshBegin(state);
  domain.halo().refreshVelocities(state);
  domain.halo().refreshEnd(state);
  expectGhosts(Ghosts::everyStep);
  expectGhosts(Ghosts::whenAsked);
  moved.expectOwned(state);
}

TEST_P(HaloOf, SegmentsThatMoveAreGivenToTheirRanksWithAllTheirFields) {
  for (int round = 1; round < 5; ++round) {
    for (int i = 0; i < state.owned(); ++i) setSegment(state, i, state.row[i], 10.0 * round);
    rebuild();
    EXPECT_EQ(state.total(), allRows);
    expectEveryRowOnce(state);
    const Reference moved(10.0 * round);
    moved.expectOwned(state);
    for (int i = 0; i < state.local(); ++i) EXPECT_EQ(domain.localIndex(state.row[i]), i);
  }
}

void answer(int) {}

TEST_P(HaloOf, HandlersOfSignalsStay) {
  struct sigaction own = {}, found = {}, before = {};
  own.sa_handler = answer;
  own.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &own, &before);
  Domain another(state, {GetParam(), 1.05, 4});
  another.rebuild(state, range, range, nullptr);
  sigaction(SIGTERM, &before, &found);
  EXPECT_EQ(found.sa_handler, own.sa_handler);
  EXPECT_TRUE(found.sa_flags & SA_RESTART);
}

TEST(Domain, WhatIsBrokenNeedNotBeFound) {
  // Two parts of a fibre lie far apart, of three ranks on two; a bond and a link between them widen
  // the cells until their ends are neighbours, unless they are broken.
  for (const bool broken : {true, false}) {
    State state(PETSC_COMM_WORLD, {{0, 0, 0}, {4000, 100, 100}, {false, false, false}}, {});
    const std::int64_t first = 16 * state.rank() / state.ranks(),
                       last = 16 * (state.rank() + 1) / state.ranks();
    state.addOwned(static_cast<int>(last - first));
    Link link;
    link.row = {0, 15};
    link.index = {0, 15};
    link.broken = broken;
    state.linked = true;
    for (std::int64_t row = first; row < last; ++row) {
      const auto i = static_cast<int>(row - first);
      setSegment(state, i, row);
      state.chain[2 * i] = static_cast<std::int32_t>(row);
      state.chain[2 * i + 1] = 16;
      state.bond[i] = broken ? (row == 4 ? nextBroken : row == 5 ? previousBroken : 0) : 0;
      state.pose[8 * i] = 10.0 * static_cast<double>(row) + (row > 4 ? 3500.0 : 0.0);
      state.pose[8 * i + 1] = state.pose[8 * i + 2] = 50;
      if ((row == 0 || row == 15) && state.links.empty()) state.links.push_back(link);
    }
    state.countTotal();
    Domain domain(state, {PartitionSettings::rectilinear, 1.05, 4});
    domain.rebuild(state, range, range, nullptr);
    if (broken || state.ranks() == 1)
      EXPECT_EQ(domain.grid().range(), range);
    else
      EXPECT_GT(domain.grid().range(), 1000);
  }
}

TEST_P(HaloOf, ABondLongerThanTheRangeStillFindsItsPartner) {
  // Only the segments with odd rows move: every bond is over 40 long.
  for (int i = 0; i < state.owned(); ++i)
    setSegment(state, i, state.row[i], state.row[i] % 2 ? 40.0 : 0.0);
  rebuild();
  for (int i = 0; i < state.owned(); ++i)
    for (const Tie& tie : state.ties(i))
      EXPECT_EQ(state.row[domain.partner(state, i, tie)], tie.row) << "row " << state.row[i];
}

TEST_P(HaloOf, TheCensusCountsGhostsAndBondsBetweenRanks) {
  const auto census = domain.census(state);
  std::int64_t ghosts = state.ghosts(), cut = 0;
  for (int i = 0; i < state.owned(); ++i)
    for (int j = state.owned(); j < state.local(); ++j) cut += tied(state.row[i], state.row[j]);
  MPI_Allreduce(MPI_IN_PLACE, &ghosts, 1, MPI_INT64_T, MPI_SUM, PETSC_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &cut, 1, MPI_INT64_T, MPI_SUM, PETSC_COMM_WORLD);
  cut /= 2;  // either rank has counted it
  EXPECT_EQ(census.ghosts, ghosts);
  EXPECT_EQ(census.cutBonds, cut);
  if (GetParam() == PartitionSettings::rectilinear) {
    EXPECT_EQ(cut > 0, state.ranks() > 1);
  }
}

}  // namespace
}  // namespace nanoweft::test
