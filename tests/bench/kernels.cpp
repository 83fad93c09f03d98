/// Time of one pair resolution and of one bond, one core, everything in cache:
///
///     build/bin/kernels --benchmark_repetitions=9 --benchmark_report_aggregates_only
#include <benchmark/benchmark.h>

#include <cmath>
#include <numeric>
#include <random>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/fibre/presets.hpp"
#include "nanoweft/force/gather.hpp"
#include "nanoweft/force/pair_forces.hpp"
#include "nanoweft/force/pair_list.hpp"

namespace {

using namespace nanoweft;

/// Segments of two layers of parallel tubes, 17 A apart: pairs at all distances up to the cutoff.
struct Scene {
  std::vector<double> pose;
  std::vector<ListPair> pairs;
  std::vector<ForceSum> sums;

  Scene() {
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> jitter(-0.5, 0.5);
    for (int layer = 0; layer < 2; ++layer)
      for (int tube = 0; tube < 8; ++tube)
        for (int k = 0; k < 30; ++k) {
          const double record[8] = {13.56 * k + jitter(engine),
                                    17.1 * tube + jitter(engine),
                                    17.1 * layer,
                                    0,
                                    1,
                                    0,
                                    0,
                                    0};
          pose.insert(pose.end(), record, record + 8);
        }
    const int n = static_cast<int>(pose.size() / 8);
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) {
        if (i / 30 == j / 30) continue;
        double d2 = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const double d =
              pose[8 * static_cast<std::size_t>(j) + c] - pose[8 * static_cast<std::size_t>(i) + c];
          d2 += d * d;
        }
        if (d2 < 63.28 * 63.28) pairs.push_back({i, j});
      }
    sums.resize(pose.size() / 8 + 1);
  }
};

std::shared_ptr<PairForce> makeForce(const char* text) {
  petsc(PetscOptionsClear(nullptr));
  petsc(PetscOptionsInsertString(nullptr, text));
  Options options;
  return readPairForces(options, nanoUnits(), cnt1010(nanoUnits())).classes()[0].force;
}

/// Whole passes over the list, as a step makes them.
void pairResolution(benchmark::State& state, const char* options) {
  Scene scene;
  const auto force = makeForce(options);
  const MinimumImage nearest{Box{}};
  PairRuns listed;
  listed.set(FoundPairs(scene.pairs), static_cast<int>(scene.pose.size() / 8));
  // Drawn once, as it is for ten steps or more.
  DrawnPairs drawn;
  force->draw(listed, scene.pose.data(), nearest, 1.0, drawn);
  PairJob job;
  job.pose = scene.pose.data();
  job.drawn = &drawn;
  job.begin = 0;
  job.end = job.spare = static_cast<std::int32_t>(scene.pose.size() / 8);
  job.sum = scene.sums.data();
  job.nearest = &nearest;
  PairTally tally;
  for (auto _ : state) {
    force->add(job, false, tally);
    benchmark::DoNotOptimize(scene.sums.data());
    benchmark::ClobberMemory();
  }
  state.counters["s_per_pair"] = benchmark::Counter(
      static_cast<double>(scene.pairs.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(pairResolution, 3_points, "-pair_points 3");
BENCHMARK_CAPTURE(pairResolution, 3_points_1_far, "-pair_points 3 -pair_far_points 1");
BENCHMARK_CAPTURE(pairResolution, 1_point, "-pair_points 1");
BENCHMARK_CAPTURE(pairResolution, 5_points, "-pair_points 5");
BENCHMARK_CAPTURE(pairResolution, 5_points_1_far, "-pair_points 5 -pair_far_points 1");
BENCHMARK_CAPTURE(pairResolution, 7_points, "-pair_points 7");

BENCHMARK_CAPTURE(pairResolution, 3_points_single, "-pair_points 3 -pair_precision single");
BENCHMARK_CAPTURE(pairResolution, 3_points_1_far_single,
                  "-pair_points 3 -pair_far_points 1 -pair_precision single");
BENCHMARK_CAPTURE(pairResolution, 5_points_single, "-pair_points 5 -pair_precision single");

/// Two layers of fibres that cross at an angle, `apart` from each other; all pairs within the
/// contact's reach. Time of a pair, or of a pair that touches.
void contacts(benchmark::State& state, double angle, double apart) {
  Scene scene;
  scene.pose.clear();
  scene.pairs.clear();
  std::mt19937 engine(2);
  std::uniform_real_distribution<double> jitter(-0.5, 0.5);
  const Vec3d axes[2] = {{1, 0, 0}, {std::cos(angle), std::sin(angle), 0}};
  for (int layer = 0; layer < 2; ++layer)
    for (int fibre = 0; fibre < 20; ++fibre) {
      const Vec3d e = axes[layer], across{-e.y, e.x, 0};
      const Quatd q = quaternionFromAxes(e, across, {0, 0, 1});
      const double shift = jitter(engine);
      for (int k = 0; k < 20; ++k) {
        const Vec3d x = (13.56 * (k - 10 + shift)) * e + (13.7 * (fibre - 10)) * across +
                        Vec3d{0, 0, apart * layer};
        scene.pose.insert(scene.pose.end(), {x.x, x.y, x.z, 0, q.w, q.x, q.y, q.z});
      }
    }
  const auto force = makeForce("-pair contact -contact_modulus 10");
  const int n = static_cast<int>(scene.pose.size() / 8);
  for (int i = 0; i < n / 2; ++i)
    for (int j = n / 2; j < n; ++j) {
      const double *a = &scene.pose[8 * static_cast<std::size_t>(i)],
                   *b = &scene.pose[8 * static_cast<std::size_t>(j)];
      if (norm(Vec3d{b[0] - a[0], b[1] - a[1], b[2] - a[2]}) < force->reach())
        scene.pairs.push_back({i, j});
    }
  scene.sums.assign(static_cast<std::size_t>(n + 1), ForceSum{});
  const MinimumImage nearest{Box{}};
  PairRuns listed;
  listed.set(FoundPairs(scene.pairs), n);
  DrawnPairs drawn;
  force->draw(listed, scene.pose.data(), nearest, 1.0, drawn);
  PairJob job;
  job.pose = scene.pose.data();
  job.drawn = &drawn;
  job.begin = 0;
  job.end = job.spare = n;
  job.sum = scene.sums.data();
  job.nearest = &nearest;
  PairTally tally;
  std::int64_t rounds = 0;
  for (auto _ : state) {
    force->add(job, false, tally);
    benchmark::DoNotOptimize(scene.sums.data());
    benchmark::ClobberMemory();
    ++rounds;
  }
  auto counter = [&](double pairs) {
    return benchmark::Counter(
        pairs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  };
  state.counters["s_per_pair"] = counter(static_cast<double>(scene.pairs.size()));
  if (tally.resolved > 0)
    state.counters["s_per_contact"] =
        counter(static_cast<double>(tally.resolved) / static_cast<double>(rounds));
  state.counters["touching"] =
      static_cast<double>(tally.resolved) / static_cast<double>(rounds * std::ssize(scene.pairs));
}
BENCHMARK_CAPTURE(contacts, crossed, 1.2, 13.4);
BENCHMARK_CAPTURE(contacts, along, 0.1, 13.4);
BENCHMARK_CAPTURE(contacts, apart, 1.2, 13.7);

/// What the core can do at most: independent fused multiply-adds in registers.
void peak(benchmark::State& state) {
  constexpr int chains = 12;
  Lanes x[chains];
  for (int k = 0; k < chains; ++k) x[k] = Lanes(1.0 + 1e-3 * k);
  const Lanes a(0.999999), b(1e-9);
  for (auto _ : state) {
    for (int n = 0; n < 1000; ++n)
#pragma GCC unroll 12
      for (int k = 0; k < chains; ++k) x[k] = multiplyAdd(x[k], a, b);
    benchmark::DoNotOptimize(x);
  }
  state.counters["flops"] = benchmark::Counter(2.0 * 1000 * chains * laneCount,
                                               benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(peak);

void bond(benchmark::State& state) {
  Scene scene;
  const EvmBond law = cnt1010(nanoUnits()).bond;
  std::vector<std::int32_t> index(scene.pose.size() / 8);
  std::iota(index.begin(), index.end(), 0);
  const std::size_t groups = index.size() / laneCount - 1;
  for (auto _ : state)
    for (std::size_t g = 0; g < groups; ++g) {
      const double* pose = scene.pose.data();
      const std::int32_t *i = &index[g * laneCount], *j = i + 1;
      auto force =
          law.force(BondGeometry<Lanes>{gatherPositions(pose, j) - gatherPositions(pose, i),
                                        gatherOrientations(pose, i), gatherOrientations(pose, j)});
      benchmark::DoNotOptimize(force);
    }
  state.counters["s_per_bond"] = benchmark::Counter(
      static_cast<double>(groups * laneCount),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(bond);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  nanoweft::petsc(PetscInitializeNoArguments());
  benchmark::RunSpecifiedBenchmarks();
  nanoweft::petsc(PetscFinalize());
}
