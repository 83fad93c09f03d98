#include "nanoweft/app/signals.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>

namespace nanoweft {

// Handlers may call only what POSIX lists as safe in them: no malloc, stdio, MPI or PETSc.

namespace {

volatile std::sig_atomic_t requested = 0;
/// Seconds of the monotonic clock at the first SIGINT or SIGTERM; 0: none came.
volatile std::sig_atomic_t firstInterrupt = 0;
int crashRank = 0;
bool terminal = false;  ///< somebody may be looking at standard error

std::sig_atomic_t seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::sig_atomic_t>(now.tv_sec) + 1;
}

void endBy(int signal) {
  struct sigaction standard {};
  standard.sa_handler = SIG_DFL;
  sigaction(signal, &standard, nullptr);
  raise(signal);
}

void tellHowToEnd() {
  constexpr char text[] =
      "nanoweft: a checkpoint is written at the end of this step; once more ends at once\n";
  [[maybe_unused]] const auto ignored = write(STDERR_FILENO, text, sizeof text - 1);
}

void onStop(int signal) {
  const int error = errno;
  requested = 1;
  if (signal == SIGINT || signal == SIGTERM) {
    // Batch systems may send the same SIGTERM twice within moments, to a job and to its steps.
    if (firstInterrupt == 0) {
      firstInterrupt = seconds();
      if (signal == SIGINT && terminal) tellHowToEnd();
    } else if (signal == SIGINT || seconds() > firstInterrupt + 1)
      endBy(signal);
  }
  errno = error;
}

struct Crash {
  int signal;
  const char* name;
};
constexpr Crash crashes[] = {
    {SIGSEGV, "SIGSEGV (invalid memory access)"},
    {SIGBUS, "SIGBUS (memory or a mapped file has gone)"},
    {SIGFPE, "SIGFPE (arithmetic exception)"},
    {SIGILL, "SIGILL (the processor lacks an instruction: see NANOWEFT_ARCH)"},
    {SIGABRT, "SIGABRT (a library gave up)"}};

class CrashLine {
 public:
  void add(const char* text) {
    const std::size_t n = std::min(std::strlen(text), sizeof buffer_ - length_);
    std::memcpy(buffer_ + length_, text, n);
    length_ += n;
  }
  void add(int number) {
    char digits[12] = "";
    char* at = digits + sizeof digits - 1;
    do *--at = static_cast<char>('0' + number % 10);
    while (number /= 10);
    add(at);
  }
  void write() const {
    [[maybe_unused]] const auto ignored = ::write(STDERR_FILENO, buffer_, length_);
  }

 private:
  char buffer_[256];
  std::size_t length_ = 0;
};

// Not used under sanitizers.
[[maybe_unused]] void onCrash(int signal) {
  CrashLine line;
  line.add("nanoweft: error: rank ");
  line.add(crashRank);
  line.add(" crashed by ");
  for (const Crash& c : crashes)
    if (c.signal == signal) line.add(c.name);
  line.add("\n");
  line.write();
  endBy(signal);
}

bool ignored(int signal) {
  struct sigaction present {};
  return sigaction(signal, nullptr, &present) == 0 && present.sa_handler == SIG_IGN;
}

void handle(int signal, void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

void catchSignals() {
  terminal = isatty(STDERR_FILENO) == 1;
  for (int signal : {SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU}) handle(signal, onStop, SA_RESTART);
  for (int signal : {SIGINT, SIGHUP})
    if (!ignored(signal)) handle(signal, onStop, SA_RESTART);
  for (int signal : {SIGPIPE, SIGXFSZ}) handle(signal, SIG_IGN, 0);
}

void catchCrashes(int rank) {
  crashRank = rank;
// Sanitizers report crashes themselves, with a trace.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // A stack that is full has no room for a handler.
  static char room[16384];
  stack_t stack{};
  stack.ss_sp = room;
  stack.ss_size = sizeof room;
  sigaltstack(&stack, nullptr);
  for (const Crash& c : crashes) handle(c.signal, onCrash, SA_ONSTACK);
#endif
}

bool stopRequested() {
  return requested != 0;
}

}  // namespace nanoweft
