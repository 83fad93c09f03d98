/// Signals. SIGINT, SIGHUP, SIGTERM, SIGUSR1, SIGUSR2 and SIGXCPU ask a run to write a checkpoint
/// and to end with status 3; a crash says in one line which signal it was.
#pragma once

#include <stdexcept>

namespace nanoweft {

/// A signal came before there was anything to save: exit status 3. Thrown by all ranks together.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// From now on the signals above are only noted, but a second SIGINT, or a second SIGTERM a second
/// or more after the first, ends the program at once. SIGINT and SIGHUP stay ignored where they are
/// (nohup). A closed pipe and the limit of a file's size come as errors of the write and not as
/// signals.
void catchSignals();

/// SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT print a line with this rank before they end the
/// program.
void catchCrashes(int rank);

/// Has this rank been asked to stop?
bool stopRequested();

}  // namespace nanoweft
