/// Pair laws of two surfaces at a gap g = r - ra - rb (model.md 4.3 to 4.5): w(r) = p(g)/r.
///
/// Two straight fibres crossed at a right angle have E(d) = 2 pi int_d^inf w(r) r dr, so they repel
/// each other by exactly 2 pi p. Hence a law follows from either of two things: from a surface
/// energy per area e(g), p = R e with R = sqrt(ra rb) (Derjaguin: F = 2 pi R e), or from the force
/// F(g) of a crossing, p = F/(2 pi).
///
/// A new law is a file like src/force/hamaker.cpp, its declaration below and a line in
/// surface_law.cpp.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/pair_table.hpp"
#include "nanoweft/force/switch.hpp"

namespace nanoweft {

/// A function of the gap and its first two derivatives.
struct AtGap {
  double value = 0, slope = 0, curvature = 0;
};
using OfGap = std::function<AtGap(double gap)>;

/// A law for surfaces of given radii. Gaps are lengths between the surfaces.
struct SurfaceProfile {
  OfGap p;             ///< force of a crossing over 2 pi; needs no second derivative
  double join = 0;     ///< gap where branches join
  double rest = 0;     ///< gap at which fibres rest on each other; zero when the law only attracts
  double width = 0;    ///< gap over which forces change, for the number of points
  bool holds = true;   ///< keeps fibres apart
  double miss = 1e-2;  ///< of the law's table (pair_table.hpp)
};

/// The minimum of a surface energy. Below its gap the energy is a parabola of the given stiffness.
struct SurfaceMinimum {
  double gap, energy, stiffness;
  double ownStiffness;  ///< second derivative of the energy beyond the minimum, at it
};

/// p = R e S: from the energy per area beyond its minimum.
SurfaceProfile profileOfEnergy(const SurfaceMinimum& minimum, const OfGap& beyond, double radius,
                               const Switch& range);

/// A sort of law as options name it: `-pair NAME`, with parameters `-NAME_...`.
struct SurfaceLawType {
  using Values = std::vector<double>;
  /// How the value between two kinds follows from those within them.
  enum Rule { geometric, arithmetic, equal };
  struct Parameter {
    const char *name, *shown, *help;
    int energy, length;  ///< powers in the unit; both 0: an angle in radians
    double most;         ///< the lower bound is 0, excluded unless there is an upper one
    Rule rule;
    double (*fallback)(const Values&);  ///< null: it has to be given
  };

  const char* name;
  std::vector<Parameter> parameters;
  /// The gap where it ends unless given, and its help text; null: it has to be given.
  double (*usualCutoff)(const Values&);
  const char* shownCutoff;
  /// `radius` is sqrt(ra rb).
  SurfaceProfile (*profile)(const Values&, double radius, const Switch& range);
};

SurfaceLawType hamakerLaw();
SurfaceLawType hydrogenLaw();
SurfaceLawType capillaryLaw();

/// All of them.
const std::vector<SurfaceLawType>& surfaceLaws();

/// The law between two segments, u = Ti Tj w.
class SurfaceLaw {
 public:
  /// `touch` = ra + rb; `lengths` = Ti Tj.
  SurfaceLaw(SurfaceProfile profile, const Switch& range, double touch, double lengths);

  double cutoff() const { return touch_ + range_.to; }
  bool keepsApart() const { return profile_.holds; }
  double restDistance() const { return touch_ + profile_.rest; }
  /// Below this distance surfaces have passed through each other; zero when nothing keeps them
  /// apart.
  double closestSensible() const { return profile_.holds ? touch_ : 0.0; }
  /// Bound of |u'|.
  double largestForce() const;
  /// Bound of u'' from surfaces that touch on.
  double contactStiffness() const;

  PairValue<double> operator()(double r2) const;
  /// The law as the kernels use it.
  PairTable table() const;

 private:
  PairValue<double> exact(double r) const;

  SurfaceProfile profile_;
  Switch range_;
  double touch_, lengths_;
  double innermost_;  ///< below it u' is linear in r: w itself has no bound there
};

}  // namespace nanoweft
