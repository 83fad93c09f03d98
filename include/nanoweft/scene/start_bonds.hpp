/// The bonds of a state as a scene has filled it, before segments are distributed.
#pragma once

#include <array>

#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// A bond from segment `i` of this rank to its successor, which may be another rank's.
struct StartBond {
  int i;
  Vec3d from, to;       ///< the centres
  Quatd first, second;  ///< the orientations
  bool closes;          ///< from the last segment of a closed fibre to its first
};

class StartBonds {
 public:
  /// Rows must lie on the ranks in blocks, in their order. Collective.
  explicit StartBonds(const State& state);

  /// Calls `visit(const StartBond&)` for this rank's bonds that are not broken.
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (int i = 0; i < state_.owned(); ++i)
      for (const Tie& tie : state_.ties(i)) {
        if (tie.broken || !tie.first) continue;
        const bool closes = tie.index == 0;
        const int j = closes ? i - state_.chain[2 * i] : i + 1;
        const double* pose = closes ? (j >= 0 ? state_.pose + 8 * j : start_.data())
                                    : (j < state_.owned() ? state_.pose + 8 * j : after_.data());
        visit(StartBond{i, state_.position(i), Vec3d{pose[0], pose[1], pose[2]},
                        state_.orientation(i), Quatd{pose[4], pose[5], pose[6], pose[7]}, closes});
      }
  }
  const State& state() const { return state_; }

 private:
  const State& state_;
  std::array<double, 8> after_{};  ///< pose of the first segment behind this rank's
  std::array<double, 8> start_{};  ///< pose of the first segment of the fibre this rank begins in
};

}  // namespace nanoweft
