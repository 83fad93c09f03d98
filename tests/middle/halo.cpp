/// Domain and halo: who sees whom, and what ghosts know of their owners.
#include "nanoweft/domain/halo.hpp"

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
