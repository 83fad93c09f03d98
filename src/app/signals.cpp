#include "nanoweft/app/signals.hpp"

#include <csignal>
#include <initializer_list>

namespace nanoweft {

namespace {
volatile std::sig_atomic_t requested = 0;
}

void catchSignals() {
  for (int signal : {SIGTERM, SIGUSR1}) std::signal(signal, [](int) { requested = 1; });
  // A file at its largest size is an error of the write, as a full disk is.
  std::signal(SIGXFSZ, SIG_IGN);
}

bool stopRequested() {
  return requested != 0;
}

}  // namespace nanoweft
