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

/// In words, with the two largest units.
std::string roundedDuration(double seconds);

/// Knows how long a step takes, and keeps the time of two, and of a checkpoint, in reserve.
class WallLimit {
 public:
  explicit WallLimit(double limit) : limit_(limit) {}

  double limit() const { return limit_; }
  /// To be called in each step; `now`: seconds since the start; `checkpoint`: seconds that one
  /// takes. True when the next step might be one too many.
  bool over(double now, double checkpoint);

 private:
  double limit_, longestStep_ = 0, last_ = -1;
};

}  // namespace nanoweft
