#include "nanoweft/base/threads.hpp"

#include <algorithm>
#include <cstdlib>
#include <thread>

namespace nanoweft {

TeamMeter& teamMeter() {
  static TeamMeter meter;
  return meter;
}

int teamGiven(int wanted) {
  int given = 1;
#pragma omp parallel num_threads(wanted)
#pragma omp single
  given = omp_get_num_threads();
  return given;
}

int threadsPerRank(MPI_Comm comm) {
  if (std::getenv("OMP_NUM_THREADS")) return omp_get_max_threads();
  MPI_Comm node;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  int ranks;
  MPI_Comm_size(node, &ranks);
  MPI_Comm_free(&node);
  const int usable = omp_get_num_procs(),
            cores = static_cast<int>(std::thread::hardware_concurrency());
  // A bound rank has its cores for itself; unbound ones share them all.
  return usable < cores ? usable : std::max(1, usable / ranks);
}

}  // namespace nanoweft
