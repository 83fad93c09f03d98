#include "nanoweft/base/threads.hpp"

namespace nanoweft {

int teamGiven(int wanted) {
  int given = 1;
#pragma omp parallel num_threads(wanted)
#pragma omp single
  given = omp_get_num_threads();
  return given;
}

}  // namespace nanoweft
