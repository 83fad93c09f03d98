/// Work shared among threads. `num_threads` is a request: the runtime may give a smaller team
/// (OMP_THREAD_LIMIT, OMP_MAX_ACTIVE_LEVELS), so nothing here depends on the team's size.
#pragma once

#include <mpi.h>
#include <omp.h>
#include <sched.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <limits>
#include <optional>
#include <vector>

namespace nanoweft {

/// The teams of this process, outside of other teams.
struct TeamMeter {
  int most = std::numeric_limits<int>::max();  ///< threads of a team (TeamSize)
  double seconds = 0;                          ///< for which teams have worked
};
TeamMeter& teamMeter();
/// Threads for so many shares.
inline int teamOf(std::size_t shares) {
  return static_cast<int>(std::min(shares, static_cast<std::size_t>(teamMeter().most)));
}

/// Adds its lifetime to the meter.
class TeamClock {
 public:
  TeamClock() : begin_(omp_get_wtime()) {}
  ~TeamClock() { teamMeter().seconds += omp_get_wtime() - begin_; }
  TeamClock(const TeamClock&) = delete;
  TeamClock& operator=(const TeamClock&) = delete;

 private:
  double begin_;
};

/// Calls `work(share)` once for each 0 <= share < count, each on a thread of its own where the
/// runtime gives `count` threads. When `work` throws, its thread leaves out its remaining shares,
/// and the exception (one of them, if there are several) is thrown again after all threads are
/// done.
template <class Work>
void onShares(std::size_t count, const Work& work) {
  std::exception_ptr failure;
  std::optional<TeamClock> clock;
  if (!omp_in_parallel()) clock.emplace();
#pragma omp parallel num_threads(teamOf(count))
  {
    const auto team = static_cast<std::size_t>(omp_get_num_threads());
    try {
      for (auto share = static_cast<std::size_t>(omp_get_thread_num()); share < count;
           share += team)
        work(share);
    } catch (...) {
#pragma omp critical(nanoweft_failure)
      failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

/// How many threads the runtime gives to a team of `wanted`.
int teamGiven(int wanted);

/// The cores that a process may run on.
using CoreSet = cpu_set_t;

/// How many of `mine` are left to a rank that shares them with all ranks of its computer (itself
/// among them) whose sets have one of them; at least 1.
int shareOfCores(const CoreSet& mine, const std::vector<CoreSet>& all);

/// OMP_NUM_THREADS, or a fair share of the cores that this rank may use. Collective.
int threadsPerRank(MPI_Comm comm);

}  // namespace nanoweft
