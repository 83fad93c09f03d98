/// The state: what the table of fields says holds for every field, whatever happens to segments.
#include "nanoweft/state/state.hpp"

#include "middle/segments.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft::test {
namespace {

TEST(State, FreshSegmentsHaveWhatTheTableSays) {
  State state(PETSC_COMM_WORLD, sceneBox(), allFields);
  state.addOwned(3);
  for (int i = 0; i < 3; ++i) setSegment(state, i, i);
  state.addOwned(400);
  ASSERT_EQ(state.owned(), 403);
  for (const Field& f : fields)
    f.visit(state, [&](const auto* values) {
      ASSERT_NE(values, nullptr) << f.name;
      for (int i = 3; i < 403; ++i)
        for (int c = 0; c < f.components; ++c)
          ASSERT_EQ(static_cast<double>(values[f.components * i + c]),
                    f.freshAt(static_cast<std::size_t>(c)))
              << f.name;
    });
  EXPECT_EQ(state.orientation(402).w, 1.0);
  EXPECT_EQ(state.kind(402), 0);
  // Those that were there stay as they are.
  const Reference reference;
  for (const Field& f : fields)
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(reference.same(f, state, i)) << f.name;
}

TEST(State, FieldsThatNoSceneAsksForAreNotThere) {
  const State state(PETSC_COMM_WORLD, sceneBox(), {});
  for (const Field& f : fields) EXPECT_EQ(f.data(state) != nullptr, f.extra == nullptr) << f.name;
}

TEST(State, MemoryIsAskedForAllFieldsThatAreThere) {
  const State usual(PETSC_COMM_WORLD, sceneBox(), {}), all(PETSC_COMM_WORLD, sceneBox(), allFields);
  double more = 0;
  for (const Field& f : fields)
    if (f.extra) more += static_cast<double>(f.bytes());
  EXPECT_GT(more, 600);
  EXPECT_EQ(all.memoryOfSegment(), usual.memoryOfSegment() + more);
}

TEST(State, PermutingTakesEveryFieldAlong) {
  State state(PETSC_COMM_WORLD, sceneBox(), allFields);
  state.addOwned(9);
  for (int i = 0; i < 9; ++i) setSegment(state, i, i);
  state.permute({0, 2, 1, 3, 8, 4, 5, 6, 7});
  const std::int64_t expected[] = {0, 2, 1, 3, 8, 4, 5, 6, 7};
  for (int i = 0; i < 9; ++i) EXPECT_EQ(state.row[i], expected[i]);
  Reference().expectOwned(state);
}

TEST(State, MigrationTakesEveryFieldAlongAndKeepsTheNumber) {
  State state(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(state);
  ASSERT_EQ(state.total(), allRows);
  const Reference reference;
  for (int round = 1; round < 4; ++round) {
    std::vector<int> to;
    for (int i = 0; i < state.owned(); ++i)
      to.push_back(static_cast<int>((state.row[i] * round / 3) % state.ranks()));
    state.migrate(to);
    EXPECT_EQ(state.total(), allRows);
    for (int i = 0; i < state.owned(); ++i)
      EXPECT_EQ((state.row[i] * round / 3) % state.ranks(), state.rank());
    expectEveryRowOnce(state);
    reference.expectOwned(state);
  }
}

TEST(State, MigrationInManyPassesIsTheSame) {
  State state(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(state);
  const Reference reference;
  std::vector<int> to;
  for (int i = 0; i < state.owned(); ++i)
    to.push_back(static_cast<int>((state.row[i] / 2 + 1) % state.ranks()));
  state.migrate(to, 1);  // one segment at a time
  EXPECT_EQ(state.total(), allRows);
  for (int i = 0; i < state.owned(); ++i)
    EXPECT_EQ((state.row[i] / 2 + 1) % state.ranks(), state.rank());
  expectEveryRowOnce(state);
  reference.expectOwned(state);
}

TEST(State, OneRankMayHaveAllSegmentsAndTheOthersNone) {
  State state(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(state);
  state.migrate(std::vector<int>(static_cast<std::size_t>(state.owned()), state.ranks() - 1));
  EXPECT_EQ(state.owned(), state.rank() == state.ranks() - 1 ? allRows : 0);
  Reference().expectOwned(state);
}

TEST(State, ALostSegmentEndsTheRun) {
  State state(PETSC_COMM_WORLD, sceneBox(), {});
  fillScene(state);
  state.addOwned(1);  // one more than was counted
  EXPECT_THROW(
      state.migrate(std::vector<int>(static_cast<std::size_t>(state.owned()), state.rank())),
      RunError);
}

TEST(State, GhostsComeAndGoWithoutTouchingOwnSegments) {
  State state(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(state);
  const int owned = state.owned();
  state.addGhosts(1000);
  EXPECT_EQ(state.local(), owned + 1000);
  EXPECT_EQ(state.owned(), owned);
  state.dropGhosts();
  EXPECT_EQ(state.local(), owned);
  state.countTotal();
  EXPECT_EQ(state.total(), allRows);
  Reference().expectOwned(state);
}

std::string textOf(const Ties& ties) {
  std::string text;
  for (const Tie& t : ties)
    text += (t.first ? "to " : "from ") + std::to_string(t.row) + (t.broken ? " broken; " : "; ");
  return text;
}

TEST(State, TiesRunAlongFibresAndAroundClosedOnes) {
  State state(PETSC_COMM_WORLD, sceneBox(), {});
  state.addOwned(allRows);
  for (int i = 0; i < allRows; ++i) setSegment(state, i, i);
  state.bond[12] |= previousBroken;
  EXPECT_EQ(textOf(state.ties(0)), "to 1; ");
  EXPECT_EQ(textOf(state.ties(7)), "from 6; ");
  EXPECT_EQ(textOf(state.ties(11)), "from 10; to 12 broken; ");
  EXPECT_EQ(textOf(state.ties(12)), "from 11 broken; to 13; ");
  EXPECT_EQ(textOf(state.ties(32)), "from 39; to 33; ");
  EXPECT_EQ(textOf(state.ties(39)), "from 38; to 32; ");
  // Every tie is seen from both of its segments.
  for (int i = 0; i < allRows; ++i)
    for (const Tie& tie : state.ties(i)) {
      EXPECT_EQ(state.chain[2 * tie.row], tie.index);
      int back = 0;
      for (const Tie& other : state.ties(static_cast<int>(tie.row)))
        back += other.row == i && other.first != tie.first;
      EXPECT_EQ(back, 1) << i << " and " << tie.row;
    }
}

TEST(State, AFibreOfOneSegmentHasNoTies) {
  State state(PETSC_COMM_WORLD, sceneBox(), {});
  state.addOwned(1);
  state.chain[1] = 1;
  EXPECT_EQ(textOf(state.ties(0)), "");
}

TEST(State, AKindIsKept) {
  State state(PETSC_COMM_WORLD, sceneBox(), {});
  state.addOwned(2);
  state.setKind(1, 7);
  state.permute({1, 0});
  EXPECT_EQ(state.kind(0), 7);
  EXPECT_EQ(state.kind(1), 0);
}

}  // namespace
}  // namespace nanoweft::test
