/// What friction remembers: for each contact of a segment the tangential spring (model.md 19). Each
/// segment has slots for its contacts in State::contact and spring, so that they go with it; both
/// segments of a contact hold the same bits. Which slot a contact has means nothing.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "nanoweft/force/pair_list.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class ContactHistory {
 public:
  /// To be called whenever the segments have changed places.
  void rebuild(const State& state);

  /// Before and after a thread finds the contacts of its share: those that it does not find are
  /// forgotten.
  void begin(Share share);
  void end(State& state, Share share);

  /// The spring of the contact of the thread's segment i with the segment `partner` (a row); a new
  /// one is zero. Marks the contact as found. Null when all slots are taken.
  double* find(State& state, int i, std::int64_t partner);
  /// Did some segment have no slot left?
  bool full() const { return full_.load(std::memory_order_relaxed); }

 private:
  std::vector<std::uint32_t> taken_, found_;  ///< a bit a slot
  std::atomic<bool> full_{false};
};

}  // namespace nanoweft
