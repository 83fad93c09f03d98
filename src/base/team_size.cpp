#include "nanoweft/base/team_size.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

#include "nanoweft/base/threads.hpp"

namespace nanoweft {

namespace {

/// What is measured at a time: so long, and so many steps, that drawing pairs and making lists
/// weigh about what they do in the mean, or as many seconds and few steps.
constexpr double window = 0.1, longWindow = 1.0;
constexpr long enoughSteps = 20, fewestSteps = 3;
/// A smaller size is tried from this delay on; a size is better when it costs this much less.
constexpr double noticedDelay = 0.1, better = 0.95;

/// Seconds for which threads of this process had work but no core, from the scheduler's statistics
/// of Linux.
std::optional<double> secondsDelayed() {
  double nanoseconds = 0;
  std::error_code failure;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", failure)) {
    std::ifstream statistics(task.path() / "schedstat");
    double ran, waited;
    if (!(statistics >> ran >> waited)) continue;  // the thread has just ended
    nanoseconds += waited;
  }
  return failure ? std::nullopt : std::optional(1e-9 * nanoseconds);
}

}  // namespace

void TeamTrials::note(double cost, double delay, double seconds) {
  if (settled_ > 0) {
    if (cost < better * cost_) {
      hold_ = shortestHold;
    } else {
      size_ = settled_;
      hold_ = std::min(2.0 * hold_, longestHold);
    }
    settled_ = 0;
    held_ = 0;
    return;
  }
  held_ += seconds;
  if (held_ < hold_) return;
  const int next = delay > noticedDelay && size_ > 1 ? size_ - 1 : std::min(size_ + 1, most_);
  if (next == size_) return;
  settled_ = size_;
  cost_ = cost;
  size_ = next;
}

TeamSize::TeamSize(int most, bool fixed)
    : fixed_(fixed || most < 2 || !secondsDelayed()), trials_(most) {
  if (!fixed_) startWindow();
}

// What comes after in this process starts with all threads.
TeamSize::~TeamSize() {
  teamMeter().most = TeamMeter{}.most;
}

void TeamSize::startWindow() {
  steps_ = 0;
  begin_ = teamMeter().seconds;
  delayed_ = secondsDelayed().value_or(0.0);
}

void TeamSize::noteStep() {
  if (fixed_) return;
  ++steps_;
  const double seconds = teamMeter().seconds - begin_;
  if (seconds < window || steps_ < fewestSteps) return;
  if (steps_ < enoughSteps && seconds < longWindow &&
      !trials_.hopeless(seconds / static_cast<double>(steps_)))
    return;
  const int size = trials_.size();
  threadSeconds_ += size * seconds;
  seconds_ += seconds;
  // A thread that has ended has taken its part of the delay along.
  const double delay = std::max(0.0, secondsDelayed().value_or(0.0) - delayed_);
  trials_.note(seconds / static_cast<double>(steps_), delay / (size * seconds), seconds);
  teamMeter().most = trials_.size();
  // Threads that have nothing to do would go on waiting in the runtime, and may spin.
  if (trials_.size() < size) omp_pause_resource(omp_pause_soft, omp_get_initial_device());
  startWindow();
}

double TeamSize::mean() const {
  return seconds_ > 0 ? threadSeconds_ / seconds_ : trials_.most();
}

}  // namespace nanoweft
