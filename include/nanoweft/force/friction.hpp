/// Friction and damping at a contact (model.md 19; springs after Cundall and Strack). The
/// tangential spring xi is the way that the surface of j has gone over that of i, in the plane
/// normal to n:
///
///     force on i = k_t xi + g v_t, at most mu N,   k_t = ratio times the contact's stiffness
///
/// Beyond the bound the spring slides along. The normal force is damped by g (v.n) n, at most as
/// strongly as the contact presses. With a restitution e, beta = -ln e/sqrt(pi^2 + ln^2 e) and the
/// reduced mass m, g = 2 beta w sqrt(m k/w) for both, where k is the stiffness of the two segments'
/// contact and w their share in that of their fibres, so that a contact has one g wherever it
/// falls.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nanoweft/base/options.hpp"
#include "nanoweft/fibre/bond_viscosity.hpp"
#include "nanoweft/force/contact.hpp"

namespace nanoweft {

/// Far beyond what surfaces have: more stands for a slip of the pen.
inline constexpr Bounds coefficientBounds{0.0, 1e3};
/// A contact gives way along the surfaces at least as easily as across.
inline constexpr Bounds tangentialBounds{0.0, 1.0, true};

struct FrictionLaw {
  double mu = 0;
  double tangential = 2.0 / 7.0;  ///< k_t over the normal stiffness
  double restitution = 1;
  double mass = 0;  ///< reduced mass of the two segments

  explicit operator bool() const { return mu > 0 || restitution < 1; }

  struct Action {
    Vec3d forceI, torqueI, torqueJ;  ///< force on j: the negative
    double power = 0;                ///< that friction takes out
  };

  /// `separation`: x_j - x_i; `radiusI`: of i's surface. The spring advances by the time `dt`.
  Action act(const ContactPatch& patch, const Vec3d& separation, const Vec3d& ei, double radiusI,
             const TwoVelocities& u, double dt, double* spring) const {
    const Vec3d n = patch.normal;
    const Vec3d leverI = patch.placeI * ei + (radiusI - 0.5 * patch.overlap) * n,
                leverJ = leverI - separation;
    const Vec3d v = u.vj + cross(u.wj, leverJ) - u.vi - cross(u.wi, leverI);
    const double opening = dot(v, n);
    const Vec3d along = v - opening * n;
    Vec3d xi{spring[0], spring[1], spring[2]};
    // The spring turns with the contact: it keeps its length.
    const double length = norm(xi);
    xi -= dot(xi, n) * n;
    if (const double now = norm(xi); now > 0) xi = (length / now) * xi;
    xi += dt * along;
    const double damping = dampingOf(patch.share * patch.stiffness),
                 stiffness = tangential * patch.stiffness;
    Vec3d force = stiffness * xi + damping * along;
    const double bound = mu * patch.load;
    if (const double size = norm(force); size > bound) {
      force = (bound / size) * force;
      // Damping alone may exceed the bound; then the spring is slack.
      const Vec3d viscous = damping * along;
      xi = norm(viscous) > bound ? Vec3d{} : (1.0 / stiffness) * (force - viscous);
    }
    spring[0] = xi.x, spring[1] = xi.y, spring[2] = xi.z;
    Action action;
    action.power = dot(force, v);
    action.forceI = force + std::max(damping * opening, -patch.load) * n;
    if (damping * opening > patch.load) action.forceI = force + patch.load * n;
    action.torqueI = cross(leverI, action.forceI);
    action.torqueJ = -cross(leverJ, action.forceI);
    return action;
  }

 private:
  double dampingOf(double stiffness) const {
    if (!(restitution < 1)) return 0.0;
    const double log = std::log(std::max(restitution, 1e-3));
    const double beta = -log / std::hypot(std::numbers::pi, log);
    return 2.0 * beta * std::sqrt(stiffness * mass);
  }
};

}  // namespace nanoweft
