/// How far the van der Waals law has to reach.
#pragma once

#include "nanoweft/force/vdw.hpp"

namespace nanoweft {

/// Share of the cohesive energy of a bundle of 61 endless fibres, `rest` apart, that the law loses
/// by its switch and cutoff; 0 where it reaches through the bundle.
double cohesionLost(const VdwParameters& law, double rest);

/// Gives the law the shortest range that loses at most a fifth of `accuracy` of the cohesion: a
/// loss is the same everywhere, while errors of single segments cancel. The switch begins at two
/// thirds of the gap at the cutoff, as by default. Throws InputError where 16 lambda are not
/// enough.
void setRangeByAccuracy(double accuracy, double rest, VdwParameters& law);

}  // namespace nanoweft
