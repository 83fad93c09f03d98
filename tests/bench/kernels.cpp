/// Time of one pair resolution and of one bond, one core, everything in cache:
///
///     build/bin/kernels --benchmark_repetitions=9 --benchmark_report_aggregates_only
#include <benchmark/benchmark.h>

#include <numeric>
#include <random>

#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/force/pair_kernel.hpp"

namespace {

using namespace nanoweft;

/// Segments of two layers of parallel tubes, 17 A apart: pairs at all distances up to the cutoff.
struct Scene {
  std::vector<double> pose;
  std::vector<ListPair> pairs;
  std::vector<std::int64_t> sums;

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
    sums.resize(6 * pose.size() / 8);
  }
};

template <int N>
void pairResolution(benchmark::State& state) {
  Scene scene;
  const Vdw<PaperExponents> law{VdwParameters{}};
  const MinimumImage nearest{Box{}};
  PairJob job;
  job.pose = scene.pose.data();
  job.pairs = scene.pairs.data();
  job.count = scene.pairs.size();
  job.begin = 0;
  job.end = static_cast<std::int32_t>(scene.pose.size() / 8);
  job.sum = scene.sums.data();
  job.nearest = &nearest;
  PairTally tally;
  for (auto _ : state) {
    addPairs<false, N>(law, 13.56, law.cutoff() + 13.56 * (N - 1) / N, 0x1p-46, 0x1p-43, job,
                       tally);
    benchmark::DoNotOptimize(scene.sums.data());
    benchmark::ClobberMemory();
  }
  state.counters["s_per_pair"] = benchmark::Counter(
      static_cast<double>(scene.pairs.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(pairResolution<3>);
BENCHMARK(pairResolution<5>);

void bond(benchmark::State& state) {
  Scene scene;
  const BondParameters parameters = cnt1010(nanoUnits()).bond;
  std::vector<std::int32_t> index(scene.pose.size() / 8);
  std::iota(index.begin(), index.end(), 0);
  const std::size_t groups = index.size() / laneCount - 1;
  for (auto _ : state)
    for (std::size_t g = 0; g < groups; ++g) {
      const GatheredPose i(scene.pose.data(), &index[g * laneCount]),
          j(scene.pose.data(), &index[g * laneCount + 1]);
      auto force = bondForce(parameters, j.position - i.position, i.orientation, j.orientation);
      benchmark::DoNotOptimize(force);
    }
  state.counters["s_per_bond"] = benchmark::Counter(
      static_cast<double>(groups * laneCount),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(bond);

}  // namespace

BENCHMARK_MAIN();
