/// Contact detection where kinds differ much in size: forces against a sum over all pairs.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "middle/tubes.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/force/pair_forces.hpp"

namespace nanoweft::test {
namespace {

/// Short fibres of three kinds (radii 1 : 2 : 20) scattered in a box that is periodic along x.
class Mixture {
 public:
  static constexpr int fibres[3] = {60, 30, 4}, segments[3] = {5, 4, 3};

  explicit Mixture(int threads) {
    fill();
    ForceField::Settings settings;
    settings.kinds = kinds;
    settings.pairs = pairs;
    settings.threads = threads;
    forces = std::make_unique<ForceField>(std::move(settings), box);
    forces->rebuild(state, domain);
  }

  void evaluate() {
    ForceRequest request;
    request.energies = true;
    outcome = forces->evaluate(state, domain.halo(), request);
  }
  double pairEnergy() {
    ExactSum sum = outcome.pair;
    ExactSum::reduce(&sum, 1, state.comm());
    return sum.value(forces->energyUnit());
  }

  static Kinds readThree() {
    petsc(PetscOptionsInsertString(
        nullptr,
        "-kinds thin,middle,thick -thin_fibre_radius 6.78 -middle_fibre_radius 13.56 "
        "-middle_fibre_density 2000 -thick_fibre_radius 135.6 -thick_fibre_density 1500 "
        "-thick_fibre_segment_length 200 -pair_points 3 -thick_pair_points 12"));
    Options options;
    return readKinds(options, nanoUnits());
  }
  static PairForces readLaws(const Kinds& kinds) {
    Options options;
    PairForces pairs = readPairForces(options, nanoUnits(), kinds);
    petsc(PetscOptionsClear(nullptr));
    return pairs;
  }

  const Kinds kinds = readThree();
  const PairForces pairs = readLaws(kinds);
  const Box box{{-900, -900, -900}, {900, 900, 900}, {true, false, false}};
  State state{PETSC_COMM_WORLD, box, {}};
  Domain domain{state, {PartitionSettings::rectilinear, 1.05, 4}};
  std::unique_ptr<ForceField> forces;
  ForceOutcome outcome;

 private:
  void fill() {
    state.kinds = {"thin", "middle", "thick"};
    std::int64_t row = 0, fibre = 0;
    for (int kind = 0; kind < 3; ++kind)
      for (int f = 0; f < fibres[kind]; ++f, ++fibre) {
        // Bonds stay far from rest, which pair forces don't mind.
        const Vec3d start{900 * disorder(fibre, 0), 350 * disorder(fibre, 1),
                          350 * disorder(fibre, 2)};
        const Quatd turn =
            rotation({disorder(fibre, 3), 2 * disorder(fibre, 4), 2 * disorder(fibre, 5)});
        for (int k = 0; k < segments[kind]; ++k, ++row) {
          if (row * state.ranks() / rows() != state.rank()) continue;
          state.addOwned(1);
          const int i = state.owned() - 1;
          state.row[i] = row;
          state.fibre[i] = fibre;
          state.chain[2 * i] = k;
          state.chain[2 * i + 1] = segments[kind];
          const Vec3d x = start + (k * kinds[kind].length) * axis1(turn);
          state.pose[8 * i] = x.x, state.pose[8 * i + 1] = x.y, state.pose[8 * i + 2] = x.z;
          state.setKind(i, kind);
          state.setOrientation(i, turn);
          state.box.wrap(state.pose + 8 * i, state.image + 3 * i);
        }
      }
    state.countTotal();
  }
  static std::int64_t rows() {
    std::int64_t n = 0;
    for (int kind = 0; kind < 3; ++kind) n += fibres[kind] * segments[kind];
    return n;
  }
};

/// What a segment is, by row, on every rank.
struct Whole {
  std::vector<double> pose, force, torque;
  std::vector<std::int64_t> fibre;

  explicit Whole(const State& s) {
    const auto n = static_cast<std::size_t>(s.total());
    pose.resize(8 * n), force.resize(3 * n), torque.resize(3 * n), fibre.resize(n);
    for (int i = 0; i < s.owned(); ++i) {
      const auto row = static_cast<std::size_t>(s.row[i]);
      std::copy_n(s.pose + 8 * i, 8, &pose[8 * row]);
      std::copy_n(s.force + 3 * i, 3, &force[3 * row]);
      std::copy_n(s.torque + 3 * i, 3, &torque[3 * row]);
      fibre[row] = s.fibre[i];
    }
    for (auto* v : {&pose, &force, &torque})
      MPI_Allreduce(MPI_IN_PLACE, v->data(), static_cast<int>(v->size()), MPI_DOUBLE, MPI_SUM,
                    s.comm());
    MPI_Allreduce(MPI_IN_PLACE, fibre.data(), static_cast<int>(n), MPI_INT64_T, MPI_SUM, s.comm());
  }
  Vec3d position(std::size_t r) const { return {pose[8 * r], pose[8 * r + 1], pose[8 * r + 2]}; }
  Quatd orientation(std::size_t r) const {
    return {pose[8 * r + 4], pose[8 * r + 5], pose[8 * r + 6], pose[8 * r + 7]};
  }
  int kind(std::size_t r) const { return static_cast<int>(pose[8 * r + 3]); }
};

TEST(MixedSizes, EnergyIsTheSumOverAllPairs) {
  for (const int threads : {1, 3}) {
    Mixture mixture(threads);
    mixture.evaluate();
    const Whole all(mixture.state);
    const MinimumImage nearest(mixture.box);
    double energy = 0;
    std::map<std::pair<int, int>, int> met;
    for (std::size_t i = 0; i < all.fibre.size(); ++i)
      for (std::size_t j = 0; j < all.fibre.size(); ++j) {
        if (all.fibre[i] == all.fibre[j]) continue;
        const Vec3d d = nearest(all.position(j) - all.position(i));
        for (const auto& c : mixture.pairs.classes()) {
          const bool fits = c.first == all.kind(i) && c.second == all.kind(j);
          // Equal kinds meet twice in this loop.
          if (!fits || (!c.mixed() && j < i) || norm(d) >= c.force->reach()) continue;
          const double u = c.force->resolve(d, all.orientation(i), all.orientation(j)).energy;
          energy += u;
          met[{c.first, c.second}] += u != 0;
        }
      }
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b <= a; ++b)
        EXPECT_GT((met[{a, b}] + (a == b ? 0 : met[{b, a}])), 0) << "kinds " << a << " and " << b;
    EXPECT_NEAR(mixture.pairEnergy() / energy, 1.0, 1e-10) << threads << " threads";
  }
}

TEST(MixedSizes, ForcesAddUpToNothingAndAreTheSameBitsOnAnyThreads) {
  Mixture one(1), three(3);
  one.evaluate();
  three.evaluate();
  const Whole a(one.state), b(three.state);
  EXPECT_EQ(a.force, b.force);
  EXPECT_EQ(a.torque, b.torque);
  // Bonds are far from rest; their forces, too, add up to nothing.
  double sum[3] = {}, largest = 0;
  for (std::size_t k = 0; k < a.force.size(); ++k) {
    sum[k % 3] += a.force[k];
    largest = std::max(largest, std::abs(a.force[k]));
  }
  for (const double s : sum)
    EXPECT_NEAR(s, 0, 1e-11 * largest * static_cast<double>(a.fibre.size()));
}

}  // namespace
}  // namespace nanoweft::test
