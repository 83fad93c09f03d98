/// Is there memory for the segments, before it is asked for: a rank that finds none later would
/// leave the others waiting.
#pragma once

#include <mpi.h>

#include <cstdint>

namespace nanoweft {

/// Throws RunError on all ranks when some rank, or its computer, cannot hold its `segments`. The
/// estimate is a lower bound, so what passes may still prove too large. Collective.
void requireMemory(MPI_Comm comm, std::int64_t segments);

}  // namespace nanoweft
