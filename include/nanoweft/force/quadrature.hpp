/// How many quadrature points the pair forces of a segment need, and the error of those it has.
///
/// The rule of equal points converges exponentially once they are closer than the width of the
/// law as seen along a fibre, sqrt(2 d g): d the distance of two fibres' axes, g the gap over which
/// the law acts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/pair_force.hpp"

namespace nanoweft {

/// Largest spacing of points over sqrt(2 d g): for laws of adhesion (5 points for the (10,10)
/// tube), for a soft repulsion, for surface laws, and for the far part of a law (1 point).
inline constexpr double nearSpacing = 0.24, softSpacing = 0.42, surfaceSpacing = 0.32,
                        farSpacing = 0.5;
/// Beyond this spacing, forces show the single points rather than a fibre.
inline constexpr double coarsestSpacing = 0.8;

/// Points that a segment of `length` needs; not limited to mostPairPoints.
int pointsNeeded(double length, double distance, double gap, double spacing);

/// Gap over which a law acts between two fibres: the gap at rest, or the overlap of a soft
/// repulsion.
double lawWidth(double restDistance, const Fibre& a, const Fibre& b);

/// Rms errors of the pair forces on a segment over the rms of these forces.
struct ForceErrors {
  double bundle;    ///< in a slightly disordered bundle of 61 fibres
  double crossing;  ///< around the place where two fibres at rest cross at a right angle

  double larger() const { return bundle > crossing ? bundle : crossing; }
};

/// The reference is the sum over many points (13 for the (10,10) tube, and twice those of `pair` at
/// least). Depends on law, points and
/// fibre alone; `pair` is that of two fibres of one kind. Empty when the estimate would take
/// minutes, for a law that reaches very far or is very narrow against the segment, and for a law
/// that only attracts, since nothing rests by it.
std::optional<ForceErrors> expectedForceErrors(const PairForce& pair, const Fibre& fibre);

/// Warnings about the number of points that a run uses. `a`, `b`: the fibres of the pair's first
/// and second segment.
std::vector<std::string> pointWarnings(const PairForce& pair, const Fibre& a, const Fibre& b,
                                       const UnitSystem& units);

}  // namespace nanoweft
