/// Work shared among threads. `num_threads` is a request: the runtime may give a smaller team
/// (OMP_THREAD_LIMIT, OMP_MAX_ACTIVE_LEVELS), so nothing here depends on the team's size.
#pragma once

#include <mpi.h>
#include <omp.h>

#include <cstddef>
#include <exception>

namespace nanoweft {

/// Calls `work(share)` once for each 0 <= share < count, each on a thread of its own where the
/// runtime gives `count` threads. When `work` throws, its thread leaves out its remaining shares,
/// and the exception (one of them, if there are several) is thrown again after all threads are
/// done.
template <class Work>
void onShares(std::size_t count, const Work& work) {
  std::exception_ptr failure;
#pragma omp parallel num_threads(static_cast <int>(count))
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

/// OMP_NUM_THREADS, or a fair share of the cores that this rank may use. Collective.
int threadsPerRank(MPI_Comm comm);

}  // namespace nanoweft
