/// From a fibre's material and cross-section to the parameters of its segments and bonds
/// (model.md 2; Table 1 of the paper).
///
/// Symbols: rf radius, h wall, T segment length, E Young's and G shear modulus, S cross-section,
/// J second moment of area, Jp = 2J polar moment, m and I a segment's mass and moment of inertia.
#pragma once

#include <string>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/fibre/bond_viscosity.hpp"
#include "nanoweft/fibre/kink.hpp"
#include "nanoweft/fibre/yield.hpp"

namespace nanoweft {

/// What a material's breakage defaults to (breakage_law.hpp says what the numbers mean).
struct Strength {
  bool weibull = false;
  double mean = 0.3, deviation = 0.05;  ///< of a length of 2 rf, normal law
  double shape = 7, strain = 0.3;       ///< Weibull's law, which then scatters as the normal one
  double length = 0;                    ///< L0 of Weibull's law
};

/// One kind of fibre, in internal units.
struct Fibre {
  double radius = 0;    ///< rf, which is where others touch it
  double wall = 0;      ///< h of a tube; 0: a solid round fibre
  double middle = 0;    ///< radius of the middle surface of a tube's thick wall; 0: rf
  double young = 0;     ///< E
  double shear = 0;     ///< G
  bool elastic = true;  ///< do the bond's stiffnesses follow from E and G?
  double mass = 0;      ///< of a segment
  double length = 0;    ///< T of a segment
  double inertia = 0;   ///< of a segment, isotropic
  EvmBond bond;
  Kink kink;
  BondViscosity viscosity;
  double retardation = 0;  ///< the longest of the times that `viscosity` comes from
  Yield yield;
  /// Rest shape: twist about the axis and curvatures about the second and third body axis, per
  /// length. Zero: straight.
  Vec3d rest{0, 0, 0};

  std::string kind;  ///< its name among -kinds

  // What other defaults follow from:
  std::string preset;        ///< name of what the options started from
  std::string law = "none";  ///< usual -pair
  double transverse = 0;     ///< Young's modulus across the axis; 0: not known
  double poisson = 0.3;      ///< Poisson's ratio across the axis
  double sheet = 0;          ///< thickness of a woven sheet; 0: the rest distance of the pair law
  double step = 0;           ///< usual time step; 0: from the stable step
  Strength strength;

  bool kinks() const { return kink.angle > 0; }
  /// Stiffness of a bond whose ends turn against each other.
  double bendingOfBond() const { return 0.25 * bond.shear + bond.bending + 0.5 * bond.torsion; }
  bool curved() const { return rest.x != 0 || rest.y != 0 || rest.z != 0; }
  /// Rotation from a segment's frame to its successor's at rest, as a rotation vector.
  Vec3d restRotation() const { return length * rest; }
  double diameter() const { return 2.0 * radius; }
  double middleRadius() const { return middle > 0 ? middle : radius; }
  double density() const { return mass / (crossSection() * length); }
  double crossSection() const;                                               ///< S
  double secondMoment() const;                                               ///< J
  double bendingRigidity() const { return young * secondMoment(); }          ///< E J
  double torsionalRigidity() const { return 2.0 * shear * secondMoment(); }  ///< G Jp

  /// Fills `inertia` and `bond` from the other members.
  void derive();
};

/// Reads -fibre_preset and the single parameters that override it. Throws InputError when the
/// cross-section is not the preset's and neither mass nor density says what it weighs, or when the
/// preset is a thick tube, whose name has the radii.
Fibre readFibre(Options& options, const UnitSystem& units);

}  // namespace nanoweft
