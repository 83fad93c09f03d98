/// All pair forces of a run: one for each law between each two kinds of fibre. Laws between the
/// same two kinds add; each has its own list, range and points.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/pair_force.hpp"

namespace nanoweft {

class PairForces {
 public:
  /// In its pairs the first segment is of the kind `first`, which has the longer segments.
  struct Class {
    int first, second;
    std::shared_ptr<PairForce> force;
    /// Of several laws between two kinds, the one whose list reaches farthest: new links go by it.
    bool widest = true;
    /// Of several laws between two kinds, the one whose forces reach farthest: viscous damping acts
    /// where it does.
    bool damps = true;

    bool mixed() const { return first != second; }
    bool between(int a, int b) const {
      return (first == a && second == b) || (first == b && second == a);
    }
  };

  PairForces() = default;
  /// The only pair force of a run with one kind, or none when null.
  PairForces(std::unique_ptr<PairForce> only);
  explicit PairForces(std::vector<Class> classes);

  /// Does any of them touch where axes come closest?
  bool touches() const;
  /// Has any of them friction?
  bool rubs() const;
  /// Has any of them damping of its own?
  bool damps() const;
  explicit operator bool() const { return !classes_.empty(); }
  const std::vector<Class>& classes() const { return classes_; }
  /// The widest between segments of two kinds, in any order; null where they do not interact.
  const PairForce* between(int a, int b) const;
  /// The largest resting distance of the laws between two kinds; empty where they do not interact.
  std::optional<double> restDistance(int a, int b) const;
  /// Does a law between two kinds keep fibres that touch apart?
  bool keepsApart(int a, int b) const;
  /// The largest reach of all.
  double reach() const;
  /// The largest force of all, a bound of |u'|.
  double largestForce() const;
  /// The largest -pair_exclude.
  int exclude() const;
  double forceUnit() const { return classes_.empty() ? 1.0 : classes_[0].force->forceUnit(); }
  double torqueUnit() const { return classes_.empty() ? 1.0 : classes_[0].force->torqueUnit(); }

 private:
  std::vector<Class> classes_;
};

/// Reads -pair and the options of the laws for each two kinds (pair_forces_read.cpp).
PairForces readPairForces(Options& options, const UnitSystem& units, const Kinds& kinds);

/// Resting distance of two fibres under their presets' law with its default parameters, or of
/// surfaces that touch. A scene without pair forces lays its fibres at this distance.
double usualRestDistance(const Fibre& a, const Fibre& b, const UnitSystem& units);

}  // namespace nanoweft
