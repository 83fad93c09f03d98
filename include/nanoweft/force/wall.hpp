/// Walls: rigid surfaces that fibres touch (model.md 20). A wall is a plane, a cylinder or a
/// sphere; it stands, moves or turns as prescribed, or follows a force.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/force/friction.hpp"

namespace nanoweft {

struct Wall {
  enum Shape { plane, cylinder, sphere };

  std::string name;
  Shape shape = plane;
  Vec3d point;          ///< on the plane or the axis, or the centre, at the start
  Vec3d axis{0, 0, 1};  ///< unit vector: normal of the plane, towards the fibres, or the axis
  double radius = 0;
  bool inside = false;        ///< the fibres are inside
  Vec3d velocity;             ///< prescribed
  double spin = 0;            ///< angular velocity about `axis` through the point
  double ramp = 0;            ///< velocity, spin and force grow linearly for this long
  double stop = 0;            ///< prescribed motion ends at this time; 0: it does not
  Vec3d force;                ///< that drives it along its direction; zero: it moves as prescribed
  double mass = 0, drag = 0;  ///< of a driven wall; drag: force over velocity
  std::vector<double> modulus;  ///< E* with each kind
  FrictionLaw friction;         ///< its mass is that of the segment

  // Present state:
  Vec3d moved;  ///< way from the start
  Vec3d speed;  ///< of a driven wall

  bool driven() const { return norm(force) > 0; }
  bool moves() const { return norm(velocity) > 0 || spin != 0; }
  /// Does its prescribed motion leave the surface where it is?
  bool slidesInItself() const;
  /// Does it go on for ever, and the surface with it?
  bool travels() const { return stop == 0 && norm(velocity) > 0 && !slidesInItself(); }
  Vec3d at() const { return point + moved; }
  double factor(double time) const { return ramp > 0 && time < ramp ? time / ramp : 1.0; }
  /// Way of a prescribed motion at a time.
  Vec3d wayAt(double time) const;
  /// Velocity of its surface at a place.
  Vec3d surfaceVelocity(const Vec3d& place, double time) const;

  /// A place as the wall sees it.
  struct Sight {
    double gap;    ///< distance from the surface; negative inside the wall
    Vec3d normal;  ///< from the wall towards the place
  };
  Sight see(const Vec3d& from) const;  ///< `from`: place less `at()`
};

using Walls = std::vector<Wall>;

/// Reads -walls and -NAME_... . Throws InputError for walls that cannot be meant.
Walls readWalls(Options& options, const UnitSystem& units, const Kinds& kinds);

}  // namespace nanoweft
