/// Checks that there is memory for the segments before it is allocated: a rank that fails to
/// allocate later would leave the others waiting.
#pragma once

#include <mpi.h>

#include <cstdint>

namespace nanoweft {

/// What the fields that every state has take alone, with the room that it keeps for migration. A
/// run with pair forces takes about twice as much.
inline constexpr double stateBytes = 400;

/// Throws RunError on all ranks when some rank, or its computer, cannot hold its `segments`. The
/// estimate is a lower bound, so what passes may still prove too large. Collective.
void requireMemory(MPI_Comm comm, std::int64_t segments, double bytesPerSegment);

/// Throws RunError on all ranks when some rank has more `segments`, its own and ghosts, than places
/// can number. Collective.
void requirePlaces(MPI_Comm comm, std::int64_t segments);

}  // namespace nanoweft
