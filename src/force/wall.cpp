#include "nanoweft/force/wall.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

bool Wall::slidesInItself() const {
  const double whole = norm(velocity), along = std::abs(dot(velocity, axis));
  if (whole == 0) return true;
  return shape == plane      ? along <= 1e-12 * whole
         : shape == cylinder ? along >= (1.0 - 1e-12) * whole
                             : false;
}

Vec3d Wall::wayAt(double time) const {
  const double t = stop > 0 ? std::min(time, stop) : time;
  return (ramp > 0 && t < ramp ? 0.5 * t * t / ramp : t - 0.5 * ramp) * velocity;
}

Vec3d Wall::surfaceVelocity(const Vec3d& place, double time) const {
  const double moves = stop > 0 && time >= stop ? 0.0 : factor(time);
  const Vec3d turning = cross((moves * spin) * axis, place - at());
  return turning + (driven() ? speed : moves * velocity);
}

Wall::Sight Wall::see(const Vec3d& from) const {
  if (shape == plane) return {dot(from, axis), axis};
  const Vec3d across = shape == cylinder ? from - dot(from, axis) * axis : from;
  const double distance = norm(across);
  // On the axis there is no direction; any will do.
  const Vec3d out = distance > 0
                        ? (1.0 / distance) * across
                        : cross(axis, std::abs(axis.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0});
  return inside ? Sight{radius - distance, -out} : Sight{distance - radius, out};
}

namespace {

/// Options of one wall.
class WallReader {
 public:
  WallReader(Options& options, const UnitSystem& units, const std::string& name)
      : s_(OptionSection(options, "Walls").family()), units_(units), name_(name) {}

  Wall read(const Kinds& kinds) {
    Wall w;
    w.name = name_;
    readShape(w);
    readMotion(w);
    readLaw(w, kinds);
    return w;
  }

 private:
  std::string option(const char* suffix) const { return "-" + name_ + suffix; }
  std::optional<Vec3d> vector(const char* suffix) {
    const auto v = s_.reals(name_ + suffix, 3, "", "", "");
    return v ? std::optional(Vec3d{(*v)[0], (*v)[1], (*v)[2]}) : std::nullopt;
  }
  double real(const char* suffix, double fallback, Bounds bounds) {
    return s_.real(name_ + suffix, fallback, "", "", bounds);
  }

  void readShape(Wall& w) {
    const std::string shape =
        s_.choice(name_ + "_shape", "plane", {"plane", "cylinder", "sphere"}, "");
    w.shape = shape == "plane" ? Wall::plane : shape == "cylinder" ? Wall::cylinder : Wall::sphere;
    const auto point = vector("_point");
    if (!point) throw InputError("-walls " + name_ + ": give " + option("_point"));
    w.point = *point;
    const auto axis = vector("_axis");
    if (!axis && w.shape != Wall::sphere)
      throw InputError("-walls " + name_ + ": give " + option("_axis") +
                       (w.shape == Wall::plane ? ", the normal towards the fibres" : ""));
    if (axis) {
      if (!(norm(*axis) > 0 && std::isfinite(norm(*axis))))
        throw InputError(option("_axis") + ": must not be zero, nor beyond all numbers");
      w.axis = (1.0 / norm(*axis)) * *axis;
    }
    const auto radius = s_.maybeReal(name_ + "_radius", "", "", "", positive);
    if (radius.has_value() != (w.shape != Wall::plane))
      throw InputError("-walls " + name_ + ": " +
                       (radius ? option("_radius") + " is for a cylinder or a sphere"
                               : "give " + option("_radius")));
    w.radius = radius.value_or(0.0);
    axisGiven_ = axis.has_value();
    w.inside = s_.flag(name_ + "_inside", false, "");
    if (w.inside && w.shape == Wall::plane)
      throw InputError(option("_inside") + ": a plane has no inside; turn " + option("_axis"));
  }

  void readMotion(Wall& w) {
    const auto velocity = vector("_velocity"), force = vector("_force");
    w.velocity = velocity.value_or(Vec3d{});
    w.force = force.value_or(Vec3d{});
    w.spin = real("_spin", 0.0, {});
    if (w.shape == Wall::sphere && w.spin != 0 && !axisGiven_)
      throw InputError("-walls " + name_ + ": give " + option("_axis") + ", about which it turns");
    if (w.shape == Wall::sphere && w.spin == 0 && axisGiven_)
      throw InputError(option("_axis") + ": not used by this run, whose sphere does not turn");
    w.ramp = real("_ramp", 0.0, nonNegative);
    w.stop = real("_stop", 0.0, nonNegative);
    if (velocity && force)
      throw InputError(option("_velocity") + ", " + option("_force") + ": give one of the two");
    if (force && !w.driven()) throw InputError(option("_force") + ": must not be zero");
    const auto mass = s_.maybeReal(name_ + "_mass", "", "", "", positive);
    if (w.driven() && !mass)
      throw InputError("-walls " + name_ + ": a wall that a force drives needs " + option("_mass"));
    if (mass && !w.driven())
      throw InputError(option("_mass") + ": not used by this run, no " + option("_force") +
                       " drives the wall");
    w.mass = mass.value_or(0.0) * units_.mass;
    w.drag = real("_drag", 0.0, nonNegative);
    if (w.drag > 0 && !w.driven())
      throw InputError(option("_drag") + ": not used by this run, no " + option("_force") +
                       " drives the wall");
    if (w.stop > 0 && !w.moves())
      throw InputError(option("_stop") + ": not used by this run: it ends " + option("_velocity") +
                       " and " + option("_spin"));
    if (w.ramp > 0 && !w.moves() && !w.driven())
      throw InputError(option("_ramp") + ": not used by this run, whose wall stands still");
  }

  void readLaw(Wall& w, const Kinds& kinds) {
    const auto modulus = s_.maybeReal(name_ + "_modulus", "", "", "", positive);
    for (const Fibre& f : kinds) {
      if (!modulus && !(f.transverse > 0))
        throw InputError("-walls " + name_ + ": give " + option("_modulus") +
                         " (GPa), or -fibre_transverse_young of the fibres");
      w.modulus.push_back(modulus ? *modulus * units_.gigapascal
                                  : f.transverse / (1.0 - f.poisson * f.poisson));
    }
    w.friction.mu = real("_friction", 0.0, coefficientBounds);
    w.friction.restitution = real("_restitution", 1.0, {0.0, 1.0});
    if (norm(w.velocity) > 0 && w.slidesInItself() && w.friction.mu == 0)
      throw InputError(option("_velocity") + ": not used by this run: a wall without " +
                       option("_friction") + " that slides in itself drags nothing along");
    if (w.spin != 0 && w.friction.mu == 0)
      throw InputError(option("_spin") + ": not used by this run: a wall without " +
                       option("_friction") + " drags nothing along");
  }

  OptionSection s_;
  const UnitSystem& units_;
  std::string name_;
  bool axisGiven_ = false;
};

void documentWalls(OptionSection& s, const UnitSystem& units) {
  const std::string speed = std::string(units.length) + "/" + units.time;
  const std::string turning = std::string("1/") + units.time;
  s.document("NAME_shape", "plane", "", "plane, cylinder or sphere");
  s.document("NAME_point", "none", units.length,
             "a point of the plane or of the axis, or the centre");
  s.document(
      "NAME_axis", "none", "",
      "normal of the plane, towards the fibres, axis of the cylinder, or of a sphere's spin");
  s.document("NAME_radius", "none", units.length, "of a cylinder or a sphere");
  s.document("NAME_inside", "false", "", "the fibres are inside the cylinder or the sphere");
  s.document("NAME_velocity", "0,0,0", speed.c_str(), "prescribed velocity of the wall");
  s.document("NAME_spin", "0", turning.c_str(), "angular velocity of its surface about the axis");
  s.document("NAME_force", "0,0,0", units.force, "force that drives the wall along its direction");
  s.document("NAME_mass", "none", units.massName, "mass of a wall that a force drives");
  s.document("NAME_drag", "0", (std::string(units.force) + "/(" + speed + ")").c_str(),
             "force over velocity against its motion");
  s.document("NAME_ramp", "0", units.time, "velocity, spin and force grow linearly for this long");
  s.document("NAME_stop", "0", units.time, "time when prescribed motion ends; 0: it does not");
  s.document("NAME_modulus", "from the modulus across the fibre", "GPa", "E* of its contacts");
  s.document("NAME_friction", "0", "", "coefficient of friction");
  s.document("NAME_restitution", "1", "", "as -contact_restitution");
}

}  // namespace

Walls readWalls(Options& options, const UnitSystem& units, const Kinds& kinds) {
  OptionSection s(options, "Walls");
  const auto names = s.words("walls", "names of rigid walls, separated by commas; NAME below");
  documentWalls(s, units);
  Walls walls;
  checkPrefixes("-walls", "a wall", names);
  for (const std::string& name : names)
    walls.push_back(WallReader(options, units, name).read(kinds));
  return walls;
}

}  // namespace nanoweft
