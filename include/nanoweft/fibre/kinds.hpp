/// The kinds of fibre in a run (-kinds): each has its own material, cross-section and segment.
/// A segment knows its kind by number (State::kind); all segments of a fibre are of one kind.
#pragma once

#include <string>
#include <vector>

#include "nanoweft/fibre/breakage_law.hpp"
#include "nanoweft/fibre/material.hpp"

namespace nanoweft {

/// At least one.
class Kinds {
 public:
  Kinds() = default;
  Kinds(const Fibre& only) : Kinds(std::vector<Fibre>{only}) {}
  explicit Kinds(std::vector<Fibre> fibres);

  int count() const { return static_cast<int>(fibres_.size()); }
  bool several() const { return fibres_.size() > 1; }
  /// Is any of them at rest in another shape than straight?
  bool curved() const;
  bool kinks() const;
  bool viscous() const;  ///< internally
  bool yields() const;
  /// Half of the rotation from a segment to its successor at rest.
  const Quatd& restHalf(int kind) const { return restHalves_[static_cast<std::size_t>(kind)]; }
  const Fibre& operator[](int kind) const { return fibres_[static_cast<std::size_t>(kind)]; }
  auto begin() const { return fibres_.begin(); }
  auto end() const { return fibres_.end(); }

  /// The names, each once; one empty name when -kinds was not given.
  std::vector<std::string> names() const;

  /// The shortest and the longest segment T, and the largest radius.
  double shortest() const;
  double longest() const;
  double thickest() const;
  /// Scales of exact sums: the largest B1 T and the largest B1 T^2 (force and energy of a bond
  /// stretched by its own length).
  double forceScale() const;
  double energyScale() const;
  /// Of stretching waves in a long chain; the largest of all kinds.
  double speedOfSound() const;

 private:
  std::vector<Fibre> fibres_;
  std::vector<Quatd> restHalves_;
};

/// Reads -kinds, and -fibre_... of each kind: with its name as prefix, else those meant for all.
/// Throws InputError for names that cannot serve as prefixes.
Kinds readKinds(Options& options, const UnitSystem& units);

/// The breakage laws of the kinds. A kind without one does not break.
class Breakage {
 public:
  Breakage() = default;
  explicit Breakage(std::vector<std::optional<BreakageLaw>> ofKinds)
      : ofKinds_(std::move(ofKinds)) {}

  /// Does any kind break?
  explicit operator bool() const;
  const std::optional<BreakageLaw>& operator[](int kind) const {
    return ofKinds_[static_cast<std::size_t>(kind)];
  }
  /// Critical strain of the bond from segment `index` of `fibre` to its successor; infinite for a
  /// kind that does not break.
  double criticalStrain(int kind, std::int64_t fibre, std::int32_t index,
                        std::int32_t segments) const;

 private:
  std::vector<std::optional<BreakageLaw>> ofKinds_;
};

/// Reads -break_... of each kind.
Breakage readBreakageOf(const Kinds& kinds, Options& options, const UnitSystem& units,
                        std::uint64_t seed);

}  // namespace nanoweft
