/// Messages of MPI that travel beside the work.
#pragma once

#include <mpi.h>

namespace nanoweft {

/// Lets messages on their way go on: MPI moves long ones only while one of its functions runs. The
/// main thread calls it now and then.
inline void letMessagesGoOn() {
  int any;
  MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_SELF, &any, MPI_STATUS_IGNORE);
}

}  // namespace nanoweft
