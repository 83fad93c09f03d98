/// What a run prints: header and summary.
#pragma once

#include "nanoweft/app/run_parts.hpp"
#include "nanoweft/record/observer.hpp"

namespace nanoweft {

void printHeader(const RunParts& parts, const Moment& start);

/// The moment from which the summary counts steps, time and pairs.
struct Clock {
  explicit Clock(const Moment& start);
  double wall, time;
  std::int64_t step, resolved;
};
/// `end`: with energies; `team`: threads that worked, on average. Collective.
void printSummary(const RunParts& parts, const Moment& end, const Clock& clock, double team);

}  // namespace nanoweft
