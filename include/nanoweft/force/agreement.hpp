/// The interface by which the force field takes part in what ranks agree on in each step: the
/// messages travel while it computes (app/simulation.hpp implements it).
#pragma once

namespace nanoweft {

/// What ranks tell each other while they compute forces.
class Agreement {
 public:
  virtual ~Agreement() = default;
  /// Has this rank itself noticed that its segments cannot be trusted, or that the lists do not
  /// hold?
  virtual bool doubts() const = 0;
  /// Waits for what the other ranks say. Do the lists still hold? To be called once. Throws on all
  /// ranks what ends the run. Collective.
  virtual bool listsHold() = 0;
};

}  // namespace nanoweft
