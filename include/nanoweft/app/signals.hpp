/// SIGTERM and SIGUSR1 ask a run to write a checkpoint and to end with status 3.
#pragma once

namespace nanoweft {

void catchSignals();
/// Has this rank been asked to stop?
bool stopRequested();

}  // namespace nanoweft
