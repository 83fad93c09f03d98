/// -wall_time: when a run has to stop so that its checkpoint is written in time.
#pragma once

#include <optional>
#include <string>

namespace nanoweft {

/// Wall time since the first call, which runProgram makes.
double secondsSinceStart();

/// Seconds of h:mm:ss, mm:ss, days-hh, days-hh:mm, days-hh:mm:ss or a number of seconds; nothing
/// when it is none of these.
std::optional<double> parseDuration(const std::string& text);

/// h:mm:ss.
std::string shownDuration(double seconds);

/// Knows how long a step and a checkpoint take, and keeps their time in reserve.
class WallLimit {
 public:
  /// Without a limit it is never over.
  explicit WallLimit(std::optional<double> limit = std::nullopt) : limit_(limit) {}

  double limit() const { return limit_.value_or(0.0); }
  /// An estimate of seconds, until a checkpoint has been timed.
  void expectCheckpoint(double seconds) { checkpoint_ = seconds; }
  void checkpointTook(double seconds);
  /// To be called in each step; `now` in seconds since the start. True when the next step might be
  /// one too many.
  bool over(double now);

 private:
  std::optional<double> limit_;
  double checkpoint_ = 0, longestStep_ = 0, last_ = -1;
  bool timed_ = false;
};

}  // namespace nanoweft
