#include "nanoweft/app/wall_time.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// Seconds for what comes after the checkpoint.
constexpr double farewell = 0.5;

std::optional<double> number(const std::string& text, bool fraction) {
  if (text.empty() ||
      text.find_first_not_of(fraction ? "0123456789." : "0123456789") != std::string::npos)
    return std::nullopt;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (*end != '\0' || value > 1e9) return std::nullopt;
  return value;
}

std::optional<std::vector<double>> fields(const std::string& text) {
  std::vector<double> values;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(':', begin), text.size());
    const auto value = number(text.substr(begin, end - begin), end == text.size());
    if (!value) return std::nullopt;
    values.push_back(*value);
    begin = end + 1;
  }
  return values;
}

}  // namespace

double secondsSinceStart() {
  static const auto start = std::chrono::steady_clock::now();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::optional<double> parseDuration(const std::string& text) {
  const auto dash = text.find('-');
  const bool days = dash != std::string::npos;
  auto values = fields(days ? text.substr(dash + 1) : text);
  if (!values || values->size() > 3) return std::nullopt;
  double hours = 0;
  if (days) {
    const auto count = number(text.substr(0, dash), false);
    if (!count || values->front() >= 24) return std::nullopt;
    hours = 24 * *count;
    // With days the first field is hours.
    values->resize(3, 0.0);
  }
  for (std::size_t k = 1; k < values->size(); ++k)
    if ((*values)[k] >= 60) return std::nullopt;
  double seconds = 0;
  for (const double v : *values) seconds = 60 * seconds + v;
  return seconds + 3600 * hours;
}

std::string shownDuration(double seconds) {
  const long s = std::lround(seconds);
  return format("%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
}

std::string roundedDuration(double seconds) {
  const long s = std::lround(seconds);
  if (s < 100) return format("%ld s", s);
  if (s < 6000) return format("%ld min %02ld s", s / 60, s % 60);
  return format("%ld h %02ld min", s / 3600, s / 60 % 60);
}

bool WallLimit::over(double now, double checkpoint) {
  // A single slow step is forgotten after some hundreds.
  if (last_ >= 0) longestStep_ = std::max(now - last_, 0.99 * longestStep_);
  last_ = now;
  return now + 2 * longestStep_ + 1.5 * checkpoint + farewell >= limit_;
}

}  // namespace nanoweft
