#include "nanoweft/app/signals.hpp"

#include <csignal>
#include <initializer_list>

namespace nanoweft {

namespace {
volatile std::sig_atomic_t requested = 0;
}

void catchSignals() {
  for (int signal : {SIGTERM, SIGUSR1}) std::signal(signal, [](int) { requested = 1; });
}

bool stopRequested() {
  return requested != 0;
}

}  // namespace nanoweft
