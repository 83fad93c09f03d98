/// The numbers of points by an error that is asked for (-pair_accuracy).
#pragma once

#include <functional>
#include <memory>

#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/pair_force.hpp"

namespace nanoweft {

using MakeWithPoints = std::function<std::unique_ptr<PairForce>(const PointChoice&)>;

/// The fewest points with which the force errors of two fibres of a kind, expectedForceErrors, are
/// below half the `accuracy`, and the nearest place where the law may be split, between its
/// distance at `rest` and `switchFrom`; a law without a switch, 0, is not split. Throws InputError
/// where the error can't be estimated or not be reached.
PointChoice pointsByAccuracy(double accuracy, const Fibre& fibre, double rest, double switchFrom,
                             const MakeWithPoints& make);

}  // namespace nanoweft
