#include "nanoweft/base/threads.hpp"

#include <algorithm>
#include <cstdlib>

#include "nanoweft/base/gather.hpp"

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

int shareOfCores(const CoreSet& mine, const std::vector<CoreSet>& all) {
  const auto sharing = std::ranges::count_if(all, [&](const CoreSet& other) {
    CoreSet both;
    CPU_AND(&both, &mine, &other);
    return CPU_COUNT(&both) > 0;
  });
  return std::max(1, CPU_COUNT(&mine) / static_cast<int>(std::max<std::ptrdiff_t>(1, sharing)));
}

int threadsPerRank(MPI_Comm comm) {
  CoreSet mine;
  CPU_ZERO(&mine);
  const bool known = sched_getaffinity(0, sizeof mine, &mine) == 0;
  // All ranks come here, since some may have the variable and others not.
  MPI_Comm node;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  const std::vector<CoreSet> all = ofAllRanks(std::vector<CoreSet>{mine}, node);
  MPI_Comm_free(&node);
  if (std::getenv("OMP_NUM_THREADS")) return omp_get_max_threads();
  return known ? shareOfCores(mine, all) : 1;
}

}  // namespace nanoweft
