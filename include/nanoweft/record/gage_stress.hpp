/// Virial stress of the gage region of a tension test: the momentum that flows through it, averaged
/// over its volume.
///
///     sigma = 1/V [ sum over bonds and pairs of lambda_ij r_ij (x) F_ij
///                   - sum over free segments inside of m v (x) v ]
///
/// with r_ij = x_j - x_i, F_ij the force of j on i, and lambda_ij the part of the line from x_i to
/// x_j inside the region (the contour of Irving and Kirkwood). The region lies between two planes
/// x = a and x = b, V = (b - a) width thickness; they are half a segment inside the innermost
/// segments of the grips, so that no row of segments lies on a plane. Tension is positive. Forces
/// between rigid segments act between their centres as far as linear momentum goes; torques carry
/// none of it. With couples between segments the tensor need not be symmetric; this is its
/// symmetric part.
///
/// Why it agrees with the grips. The force that crosses a plane x = c is P(c), the sum of F_ij,x
/// over all i left of it and j right of it; so lambda_ij (x_j - x_i) F_ij,x sums to the integral of
/// P over the region. By Newton's third law P(c) is the force on all segments left of the plane: on
/// the left grip, F_L, and on the free ones. Hence, whatever the motion,
///
///     mean of P = (F_L + F_R)/2 + sum over free k of s_k F_k,x,
///     s_k = (b - x_k)/(b - a) - 1/2, held between -1/2 and 1/2,
///
/// F_R being the pull on the right grip. In equilibrium all F_k vanish: the axial stress is the
/// grips' to round-off. Without damping the sum is 1/(b - a) (sum m v^2 - d/dt sum m v (x -
/// middle)) along the axis: the kinetic term takes the first part away, and the rate of a bounded
/// quantity averages out over time. Damping is no part of sigma: it acts on segments like a load,
/// and what it takes from the momentum between the grips stands between their stress and this one.
#pragma once

#include <array>
#include <vector>

#include "nanoweft/base/units.hpp"
#include "nanoweft/domain/domain.hpp"
#include "nanoweft/force/force_field.hpp"
#include "nanoweft/motion/boundary.hpp"

namespace nanoweft {

/// xx, yy, zz, xy, xz, yz in GPa, right after an evaluation of the forces. The same bits on any
/// number of ranks and threads. Collective.
std::array<double, 6> gageStress(const State& state, const Domain& domain, const ForceField& forces,
                                 const Tension& tension, const UnitSystem& units);

/// The same tensor of all bonds, pairs, links and segments of a periodic box, over a volume; and
/// yx, zx, zy: the forces along the second axis through faces across the first, which differ from
/// the means xy, xz, yz while segments turn. Collective.
std::array<double, 9> boxStress(const State& state, const Domain& domain, const ForceField& forces,
                                double volume, const UnitSystem& units);

/// The part of each carrier (carriers.hpp) in the axial component of that stress, GPa. Collective.
std::vector<double> carriedStress(const State& state, const Domain& domain,
                                  const ForceField& forces, const Tension& tension,
                                  const UnitSystem& units);

}  // namespace nanoweft
