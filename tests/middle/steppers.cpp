/// Steppers: what a step does, whoever looks at its end.
#include "nanoweft/motion/stepper.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>

#include "middle/tubes.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/record/energies.hpp"

namespace nanoweft::test {
namespace {

const StepperKind& kindOf(const std::string& name) {
  return *std::ranges::find(stepperKinds(), name, &StepperKind::name);
}

/// Makes steps as a run does, and ends with one that is seen. `moved`: to do after each motion.
void go(
    Tubes& tubes, Stepper& stepper, int steps, bool seen,
    const std::function<void()>& moved = [] {}) {
  System system = tubes.system();
  ForceRequest request;
  request.complete = false;
  for (int k = 1; k <= steps; ++k) {
    const DriftReport drift = stepper.move(system);
    moved();
    int stale = drift.stale;
    MPI_Allreduce(MPI_IN_PLACE, &stale, 1, MPI_INT, MPI_MAX, tubes.state.comm());
    if (stale && !tubes.forces->redraw(tubes.state))
      tubes.forces->rebuild(tubes.state, tubes.domain);
    tubes.forces->evaluate(tubes.state, tubes.domain.halo(), request);
    stepper.finish(system, seen || k == steps);
  }
}

Energies energiesOf(Tubes& tubes) {
  return sumEnergies(tubes.state, *tubes.forces, tubes.evaluate(), tubes.accounts);
}

class SteppersOf : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Kinds, SteppersOf, testing::Values("dynamics", "fire"));

TEST_P(SteppersOf, AreNotDisturbedByWhoLooks) {
  Tubes watched, alone;
  const auto one = kindOf(GetParam()).make(watched.fibre, {10, 0.1}),
             other = kindOf(GetParam()).make(alone.fibre, {10, 0.1});
  for (Tubes* tubes : {&watched, &alone}) tubes->evaluate();
  go(watched, *one, 40, true);
  go(alone, *other, 40, false);
  ASSERT_EQ(watched.state.owned(), alone.state.owned());
  const auto n = static_cast<std::size_t>(alone.state.owned());
  EXPECT_EQ(std::memcmp(watched.state.pose, alone.state.pose, 8 * n * sizeof(double)), 0);
  EXPECT_EQ(std::memcmp(watched.state.velocity, alone.state.velocity, 3 * n * sizeof(double)), 0);
  EXPECT_EQ(watched.state.step, 40);
  EXPECT_EQ(watched.state.time, alone.state.time);
}

TEST_P(SteppersOf, KeepTheBooksOfTheirEnergy) {
  Tubes tubes;
  const auto stepper = kindOf(GetParam()).make(tubes.fibre, {5, 0.2});
  const Energies first = energiesOf(tubes);
  go(tubes, *stepper, 200, false);
  const Energies last = energiesOf(tubes);
  EXPECT_GT(last.damped, 0);
  EXPECT_LT(last.total(), first.total());
  EXPECT_NEAR(last.balance(), first.balance(), 0.02 * last.damped);
}

TEST(Dynamics, ErrsInItsEnergyBySecondOrder) {
  auto error = [](double dt, int steps) {
    Tubes tubes;
    const auto stepper = kindOf("dynamics").make(tubes.fibre, {dt, 0.0});
    const Energies first = energiesOf(tubes);
    go(tubes, *stepper, steps, false);
    const Energies last = energiesOf(tubes);
    EXPECT_GT(last.kinetic, 0.01);
    EXPECT_EQ(last.damped, 0);
    EXPECT_EQ(stepper->dt(), dt);
    return last.total() - first.total();
  };
  const double coarse = error(2, 100), fine = error(1, 200);
  EXPECT_NE(fine, 0);
  EXPECT_NEAR(coarse / fine, 4, 0.1);
}

TEST(Fire, TakesNoLongerStepThanItMay) {
  Tubes tubes;
  const auto stepper = kindOf("fire").make(tubes.fibre, {20, 0.0});
  tubes.evaluate();
  EXPECT_LE(stepper->dt(), 20);
  stepper->limit(3);
  EXPECT_LE(stepper->dt(), 3);
  go(tubes, *stepper, 60, false);
  EXPECT_LE(stepper->dt(), 3);
  EXPECT_EQ(stepper->longest(), 3);
  // A limit never widens what there is.
  stepper->limit(30);
  EXPECT_EQ(stepper->longest(), 3);
}

/// The farthest that a point of a segment moves in a step of FIRE, on all ranks; one starts fast.
double farthestMove(std::optional<double> bound) {
  Tubes tubes;
  const auto stepper = kindOf("fire").make(tubes.fibre, {20, 0.0, {}, bound});
  tubes.evaluate();
  const State& s = tubes.state;
  s.velocity[1] = 0.02;  // A/fs
  double farthest = 0;
  go(tubes, *stepper, 200, false, [&] {
    for (int i = 0; i < s.owned(); ++i) {
      const double *v = s.velocity + 3 * i, *w = s.angular + 3 * i;
      const double point =
          std::hypot(v[0], v[1], v[2]) + 0.5 * tubes.fibre.length * std::hypot(w[0], w[1], w[2]);
      farthest = std::max(farthest, stepper->dt() * point);
    }
  });
  MPI_Allreduce(MPI_IN_PLACE, &farthest, 1, MPI_DOUBLE, MPI_MAX, s.comm());
  return farthest;
}

TEST(Fire, MovesNoPointFartherThanItMay) {
  EXPECT_GT(farthestMove({}), 0.02);
  for (const double bound : {0.02, 0.001}) {
    const double found = farthestMove(bound);
    EXPECT_LE(found, bound * (1 + 1e-9));
    EXPECT_GT(found, 0.2 * bound);
  }
}

TEST(Fire, KeepsTheBooksOfItsEnergyWhereItIsBraked) {
  Tubes tubes;
  const auto stepper = kindOf("fire").make(tubes.fibre, {5, 0.0, {}, 0.002});
  const Energies first = energiesOf(tubes);
  go(tubes, *stepper, 200, false);
  const Energies last = energiesOf(tubes);
  EXPECT_LT(last.total(), first.total());
  EXPECT_NEAR(last.balance(), first.balance(), 0.02 * last.damped);
}

TEST(Fire, GoesOnFromItsRecordAsIfNothingHadBeen) {
  Tubes through, stopped;
  const StepperKind& fire = kindOf("fire");
  const auto one = fire.make(through.fibre, {20, 0.0});
  auto other = fire.make(stopped.fibre, {20, 0.0});
  through.evaluate();
  stopped.evaluate();
  go(through, *one, 30, false);
  go(stopped, *other, 17, false);
  RunRecord record;
  other->save(record);
  other = fire.make(stopped.fibre, {20, 0.0});
  other->restore(record);
  stopped.evaluate();
  go(stopped, *other, 13, false);
  EXPECT_EQ(one->dt(), other->dt());
  EXPECT_EQ(std::memcmp(through.state.pose, stopped.state.pose,
                        8 * sizeof(double) * static_cast<std::size_t>(through.state.owned())),
            0);
  record.reals.erase("fire");
  EXPECT_THROW(other->restore(record), InputError);
}

}  // namespace
}  // namespace nanoweft::test
