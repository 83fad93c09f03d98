/// Mass and moment of inertia of segments by their kind.
#pragma once

#include <vector>

#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

struct Mass {
  double mass, inertia, perMass, perInertia;
};

class Masses {
 public:
  /// `scale`: what perMass and perInertia are over their masses.
  explicit Masses(const Kinds& kinds, double scale = 1.0) {
    for (const Fibre& f : kinds)
      ofKinds_.push_back({f.mass, f.inertia, scale / f.mass, scale / f.inertia});
  }

  /// Where there is one kind, the thread need not read the segment's.
  const Mass& of(const State& state, int i) const {
    return several() ? ofKinds_[static_cast<std::size_t>(state.kind(i))] : ofKinds_[0];
  }
  bool several() const { return ofKinds_.size() > 1; }

 private:
  std::vector<Mass> ofKinds_;
};

}  // namespace nanoweft
