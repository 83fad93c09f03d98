#include "nanoweft/base/team_size.hpp"

#include <sched.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

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
/// Delay from which on a thread surely shares its core with an equal: then it has half of it.
constexpr double sharedDelay = 0.3;

/// Seconds from which on the cores' statistics, which count hundredths, say something.
constexpr double shortest = 0.08;

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

/// Seconds since the computer started for which cores that this process may use did nothing, waited
/// for a disc, or ran what others had put behind (nice), from the statistics of Linux.
std::optional<double> secondsSpare() {
  CoreSet mine;
  CPU_ZERO(&mine);
  if (sched_getaffinity(0, sizeof mine, &mine) != 0) return std::nullopt;
  std::ifstream statistics("/proc/stat");
  double ticks = 0;
  bool found = false;
  for (std::string line; std::getline(statistics, line);) {
    int core;
    double user, nice, system, idle, waiting;
    if (std::sscanf(line.c_str(), "cpu%d %lf %lf %lf %lf %lf", &core, &user, &nice, &system, &idle,
                    &waiting) != 6 ||
        core >= CPU_SETSIZE || !CPU_ISSET(core, &mine))
      continue;
    ticks += nice + idle + waiting;
    found = true;
  }
  if (!found) return std::nullopt;
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

/// Seconds of processors that this process has used.
double secondsUsed() {
  timespec used{};
  if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used) != 0) return 0.0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

}  // namespace

CoreWatch::CoreWatch() : wall_(omp_get_wtime()), used_(secondsUsed()), spare_(secondsSpare()) {}

std::optional<double> CoreWatch::spare() const {
  const double wall = omp_get_wtime() - wall_;
  const auto spare = secondsSpare();
  if (!spare || !spare_ || wall < shortest) return std::nullopt;
  return (*spare - *spare_) / wall;
}

double CoreWatch::used() const {
  return (secondsUsed() - used_) / (omp_get_wtime() - wall_);
}

void TeamTrials::note(double cost, double delay, double seconds, double freeCores) {
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
  // More threads would have to share a core.
  if (next > size_ && freeCores < 0.5) return;
  settled_ = size_;
  cost_ = cost;
  size_ = next;
}

void TeamTrials::begin(double cores) {
  size_ = std::clamp(static_cast<int>(std::lround(cores)), 1, most_);
  held_ = hold_;  // a larger one may be tried at once
}

void TeamTrials::lookBack(double delay) {
  if (delay < sharedDelay || size_ < 2) return;
  --size_;
  held_ = hold_;  // a larger one may be tried at once
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

TeamSize::TeamSize(int most, bool fixed, const CoreWatch& cores)
    : fixed_(fixed || most < 2 || !secondsDelayed()), trials_(most) {
  if (fixed_) return;
  if (const auto spare = cores.spare()) trials_.begin(*spare + cores.used());
  teamMeter().most = trials_.size();
  startWindow();
}

void TeamSize::startSteps() {
  if (fixed_) return;
  const int size = trials_.size();
  if (const double seconds = teamMeter().seconds - begin_; seconds > 2.0 * window)
    trials_.lookBack((secondsDelayed().value_or(0.0) - delayed_) / (size * seconds));
  teamMeter().most = trials_.size();
  startWindow();
}

// What comes after in this process starts with all threads.
TeamSize::~TeamSize() {
  teamMeter().most = TeamMeter{}.most;
}

void TeamSize::startWindow() {
  steps_ = 0;
  begin_ = teamMeter().seconds;
  delayed_ = secondsDelayed().value_or(0.0);
  cores_ = CoreWatch();
}

bool TeamSize::noteStep(std::size_t shares) {
  if (fixed_) return false;
  const bool waited = std::exchange(waits_, static_cast<std::size_t>(trials_.size()) > shares);
  if (waits_) return true;
  // What it has cost to make them says nothing about the new size.
  if (waited) startWindow();
  measure();
  return false;
}

void TeamSize::measure() {
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
  trials_.note(cost, delay, seconds, cores_.spare().value_or(1.0));
  teamMeter().most = trials_.size();
  // Threads that have nothing to do would go on waiting in the runtime, and may spin.
  if (trials_.size() < size) omp_pause_resource(omp_pause_soft, omp_get_initial_device());
  startWindow();
}

double TeamSize::mean() const {
  return seconds_ > 0 ? threadSeconds_ / seconds_ : trials_.most();
}

}  // namespace nanoweft
