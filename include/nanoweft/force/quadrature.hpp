/// How many points a segment needs for its pair forces, and what error those that it has leave.
///
/// The rule of equal points converges exponentially once they are closer than the width of the
/// law as seen along a fibre, sqrt(2 d g): d the distance of two fibres' axes, g the gap over which
/// the law acts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nanoweft/force/pair_force.hpp"

namespace nanoweft {

/// Most distance of points over sqrt(2 d g) for pairs near (5 points for the (10,10) tube), for a
/// soft repulsion, and for pairs far apart (1 point).
inline constexpr double nearSpacing = 0.24, softSpacing = 0.42, farSpacing = 0.44;
/// Beyond this, forces are those of the points rather than of the fibres.
inline constexpr double coarsestSpacing = 0.8;

/// Points a segment of `length` needs, not limited.
int pointsNeeded(double length, double distance, double gap, double spacing);

/// Gap over which a law acts: the gap at rest, or the overlap of a soft repulsion.
double lawWidth(double restDistance, const Fibre& fibre);

/// Rms error of the pair forces on a segment over the rms of these forces, against many points (13
/// for the (10,10) tube), in a slightly disordered bundle of 61 fibres. Depends on law, points and
/// fibre alone. Nothing for a law that reaches so far, or is so narrow against the segment, that it
/// would take minutes.
std::optional<double> expectedForceError(const PairForce& pair, const Fibre& fibre);

/// What there is to say against the points that a run uses.
std::vector<std::string> pointWarnings(const PairForce& pair, const Fibre& fibre,
                                       const UnitSystem& units);

}  // namespace nanoweft
