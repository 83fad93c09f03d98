/// The force field and its lists.
#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "middle/tubes.hpp"
#include "nanoweft/force/pair_survey.hpp"

namespace nanoweft::test {
namespace {

/// Forces and torques by row, on every rank.
std::vector<double> byRow(const State& state) {
  std::vector<double> all(6 * tubeRows, 0.0);
  for (int i = 0; i < state.owned(); ++i)
    for (int c = 0; c < 3; ++c) {
      const auto row = static_cast<std::size_t>(6 * state.row[i]);
      all[row + static_cast<std::size_t>(c)] = state.force[3 * i + c];
      all[row + 3 + static_cast<std::size_t>(c)] = state.torque[3 * i + c];
    }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM,
                state.comm());
  return all;
}

/// Where the segment of a row is owned, or -1.
int placeOf(const State& state, std::int64_t row) {
  for (int i = 0; i < state.owned(); ++i)
    if (state.row[i] == row) return i;
  return -1;
}

TEST(Forces, AreTheSlopeOfTheEnergy) {
  Tubes tubes;
  tubes.evaluate();
  const std::vector<double> forces = byRow(tubes.state);
  constexpr double step = 1e-4;
  for (const std::int64_t row : {0, 5, 42, 57, 106}) {
    const int i = placeOf(tubes.state, row);
    double energies[2];
    for (const int side : {0, 1}) {
      if (i >= 0) tubes.state.pose[8 * i + 1] += side ? -2 * step : step;
      energies[side] = tubes.energy();
    }
    if (i >= 0) tubes.state.pose[8 * i + 1] += step;
    const double slope = (energies[0] - energies[1]) / (2 * step);
    EXPECT_NEAR(forces[static_cast<std::size_t>(6 * row + 1)], -slope, 1e-4) << "row " << row;
  }
}

TEST(Forces, AddUpToNothing) {
  Tubes tubes;
  ExactSum pairs = tubes.evaluate().pair;
  ExactSum::reduce(&pairs, 1, tubes.state.comm());
  EXPECT_LT(pairs.value(tubes.forces->energyUnit()), -0.1);
  double sum[3] = {}, largest = 0;
  const std::vector<double> forces = byRow(tubes.state);
  for (std::size_t k = 0; k < forces.size(); k += 6)
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c] += forces[k + c];
      largest = std::max(largest, std::abs(forces[k + c]));
    }
  EXPECT_GT(largest, 0.1);
  for (const double s : sum) EXPECT_NEAR(s, 0, 1e-12 * largest * tubeRows);
}

TEST(Forces, AreTheSameBitsOnAnyThreadsWithEnergiesOrWithout) {
  Tubes one(1), three(3);
  one.evaluate(true);
  three.evaluate(false);
  EXPECT_EQ(byRow(one.state), byRow(three.state));
}

TEST(Forces, OfTwoThreadsSegmentsAreResolvedOnceAndSurveyedOnce) {
  Tubes one(1), three(3);
  for (Tubes* tubes : {&one, &three}) tubes->evaluate();
  EXPECT_GT(one.forces->pairsResolved(), 0);
  EXPECT_EQ(one.forces->pairsResolved(), three.forces->pairsResolved());
  const StrongestSum alone = findStrongestSum(one.state, *one.forces),
                     shared = findStrongestSum(three.state, *three.forces);
  EXPECT_GT(alone.share, 0);
  EXPECT_NEAR(shared.share, alone.share, 1e-12 * alone.share);
}

TEST(Forces, HandedOverByAPassAreThoseOfAWholeEvaluation) {
  Tubes whole, passed;
  whole.evaluate();
  ForceRequest request;
  request.complete = false;
  passed.forces->evaluate(passed.state, passed.domain.halo(), request);
  {
    ForcePass pass(*passed.forces, passed.state, ForcePass::look);
    pass.handOver(0, passed.state.owned());
  }
  EXPECT_EQ(byRow(whole.state), byRow(passed.state));
}

TEST(Forces, LeftInTheirSumsCannotBeForgotten) {
  Tubes tubes;
  ForceRequest request;
  request.complete = false;
  tubes.forces->evaluate(tubes.state, tubes.domain.halo(), request);
  EXPECT_THROW(tubes.evaluate(), std::logic_error);
}

TEST(Lists, HaveAllPairsAfterSegmentsHaveMoved) {
  Tubes moved;
  // Further and further, by what needs no list, a new drawing, a new list.
  for (const double way : {0.1, 1.0, 3.0, 9.0, 80.0}) {
    bool left = false;
    for (int i = 0; i < moved.state.owned(); ++i)
      if (moved.state.fibre[i] == 4) {
        moved.state.pose[8 * i] += way;
        left = left || moved.forces->lists().moved(moved.state.pose + 8 * i, i);
      }
    MPI_Allreduce(MPI_IN_PLACE, &left, 1, MPI_C_BOOL, MPI_LOR, moved.state.comm());
    if (left && !moved.forces->redraw(moved.state))
      moved.forces->rebuild(moved.state, moved.domain);
    moved.evaluate();
    const std::vector<double> kept = byRow(moved.state);
    moved.forces->rebuild(moved.state, moved.domain);
    moved.evaluate();
    EXPECT_EQ(kept, byRow(moved.state)) << way;
  }
}

TEST(Lists, AreOutdatedUntilTheyAreMadeAnew) {
  Tubes tubes;
  EXPECT_FALSE(tubes.forces->lists().outdated());
  tubes.forces->lists().outdate();
  EXPECT_TRUE(tubes.forces->lists().outdated());
  tubes.forces->rebuild(tubes.state, tubes.domain);
  EXPECT_FALSE(tubes.forces->lists().outdated());
}

}  // namespace
}  // namespace nanoweft::test
