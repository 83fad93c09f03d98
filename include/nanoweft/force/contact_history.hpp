/// What friction remembers: for each contact of a segment the tangential spring (model.md 19). Each
/// segment has slots for its contacts in State::contact and spring, so that they go with it; both
/// segments of a contact hold the same bits. Which slot a contact has means nothing.
///
/// A contact that moves along its two fibres passes from one pair of segments to the next. The next
/// pair is a new contact, whose spring is zero in its first evaluation and then the mean of those
/// of its neighbours: the pairs that either segment, or its neighbour along the fibre, makes with
/// the other one or that one's neighbours.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/pair_list.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

class ContactHistory {
 public:
  /// To be called whenever the segments have changed places.
  void rebuild(const State& state, const Domain& domain);

  /// Before and after a thread finds the contacts of its share: those that it does not find are
  /// forgotten.
  void begin(Share share);
  void end(State& state, Share share);

  struct Spring {
    double* at;  ///< [3]; null when all slots are taken
    bool fresh;  ///< of a new contact: zero
  };
  /// The spring of the contact of the thread's segment i with the segment `partner` (a row). Marks
  /// the contact as found.
  Spring find(State& state, int i, std::int64_t partner);

  /// A new contact and the spring that it takes over.
  struct Heir {
    double* at;
    Vec3d spring;
  };
  /// Those of the new contacts of a share whose neighbours have springs. To be called after `end`
  /// and Halo::refreshContacts; the caller sets the springs when all threads have looked.
  std::vector<Heir> heirs(State& state, Share share) const;

  /// Did some segment have no slot left?
  bool full() const { return full_.load(std::memory_order_relaxed); }

 private:
  /// Mean spring of the neighbours of a contact; zero where none of them has one.
  Vec3d meanAround(State& state, int i, int j) const;

  std::vector<std::uint32_t> taken_, found_, fresh_;  ///< a bit a slot
  const Domain* domain_ = nullptr;                    ///< knows where rows are
  std::atomic<bool> full_{false};
};

}  // namespace nanoweft
