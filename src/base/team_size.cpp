#include "nanoweft/base/team_size.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

#include "nanoweft/base/threads.hpp"

namespace nanoweft {

namespace {

/// What is measured at a time: so many seconds and steps that drawing pairs and making lists weigh
/// about what they do in the mean, or more seconds and few steps, or less of what threads without a
/// core hold up.
constexpr double shortWindow = 0.03, window = 0.1, longWindow = 1.0;
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
    const bool found = cost < better * cost_;
    hold_ = found ? shortestHold : std::min(2.0 * hold_, longestHold);
    smallerIsNoBetter_ = !found && size_ < settled_;
    if (!found) size_ = settled_;
    settled_ = 0;
    held_ = 0;
    return;
  }
  held_ += seconds;
  const bool wantsSmaller = disturbed(delay);
  const int next = wantsSmaller ? std::max(size_ - 1, 1) : std::min(size_ + 1, most_);
  // Each step beside a thread without a core costs, so a smaller size is tried at once.
  const bool atOnce = wantsSmaller && !smallerIsNoBetter_;
  if (next == size_ || (held_ < hold_ && !atOnce)) return;
  settled_ = size_;
  cost_ = cost;
  size_ = next;
}

bool TeamTrials::disturbed(double delay) {
  return delay > noticedDelay;
}

bool TeamTrials::enough(long steps, double cost, double delay, double seconds) const {
  if (steps < fewestSteps || seconds < shortWindow) return false;
  if (disturbed(delay) && hopeless(cost)) return true;
  if (seconds < window) return false;
  return steps >= enoughSteps || seconds >= longWindow || (disturbed(delay) && settled_ == 0);
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
  const double seconds = teamMeter().seconds - begin_, cost = seconds / static_cast<double>(steps_);
  const int size = trials_.size();
  // The scheduler is asked only where the answer may count.
  if (!trials_.enough(steps_, cost, 1.0, seconds)) return;
  // A thread that has ended has taken its part of the delay along.
  const double delay = std::max(0.0, secondsDelayed().value_or(0.0) - delayed_) / (size * seconds);
  if (!trials_.enough(steps_, cost, delay, seconds)) return;
  threadSeconds_ += size * seconds;
  seconds_ += seconds;
  trials_.note(cost, delay, seconds);
  teamMeter().most = trials_.size();
  // Threads that have nothing to do would go on waiting in the runtime, and may spin.
  if (trials_.size() < size) omp_pause_resource(omp_pause_soft, omp_get_initial_device());
  startWindow();
}

double TeamSize::mean() const {
  return seconds_ > 0 ? threadSeconds_ / seconds_ : trials_.most();
}

}  // namespace nanoweft
