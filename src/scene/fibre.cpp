/// Scene `fibre`: one fibre, straight, bent into a circular arc, twisted or stretched.
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

struct FibreParameters {
  int segments = 100;
  Vec3d start{0, 0, 0}, direction{1, 0, 0};
  double bend = 0, twist = 0, strain = 0;
  bool closed = false;
  int kind = 0;
  bool atRest = false;  ///< laid in the rest shape of its kind
};

class FibreScene final : public Scene {
 public:
  FibreScene(const FibreParameters& p, const Fibre& kind)
      : p_(p), length_(kind.length), rest_(kind.restRotation()), geometry_(make()) {}

  Box box() const override {
    Box box;
    box.lower.fill(std::numeric_limits<double>::infinity());
    box.upper.fill(-std::numeric_limits<double>::infinity());
    for (const Vec3d& x : geometry_.position) {
      const double c[3] = {x.x, x.y, x.z};
      for (std::size_t d = 0; d < 3; ++d) {
        box.lower[d] = std::min(box.lower[d], c[d] - 4.0 * length_);
        box.upper[d] = std::max(box.upper[d], c[d] + 4.0 * length_);
      }
    }
    return box;
  }
  StartRequest asked() const override {
    const int n = bonds();
    return {p_.strain, p_.bend / n, p_.twist / n};
  }
  void fill(State& state) const override {
    fillFibres(state, 1, p_.segments, [&](std::int64_t) { return geometry_; });
  }

 private:
  int bonds() const { return p_.closed ? p_.segments : std::max(1, p_.segments - 1); }

  FibreGeometry make() const {
    const double size = norm(p_.direction);
    const Vec3d t = (1.0 / size) * p_.direction;
    // The fibre bends towards the z axis (or x, when it runs along z).
    const Vec3d hint = std::abs(t.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    const Vec3d across = hint - dot(hint, t) * t;
    const Vec3d up = (1.0 / norm(across)) * across;
    const Vec3d side = cross(up, t);
    const double turn = p_.bend / bonds(), roll = p_.twist / bonds();
    const double chord = length_ * (1.0 + p_.strain);
    FibreGeometry g;
    g.closed = p_.closed;
    g.kind = p_.kind;
    g.position.reserve(static_cast<std::size_t>(p_.segments));
    g.orientation.reserve(static_cast<std::size_t>(p_.segments));
    Vec3d x = p_.start;
    if (p_.atRest) return layAtRest(std::move(g), quaternionFromAxes(t, side, up));
    for (int k = 0; k < p_.segments; ++k) {
      const double angle = k * turn;  // of the tangent; chords lie half a turn further
      const Vec3d e1 = std::cos(angle) * t + std::sin(angle) * up;
      const Vec3d normal = cross(e1, side);
      const Vec3d e2 = std::cos(k * roll) * side + std::sin(k * roll) * normal;
      g.position.push_back(x);
      g.orientation.push_back(quaternionFromAxes(e1, e2, cross(e1, e2)));
      const double along = angle + 0.5 * turn;
      x += chord * (std::cos(along) * t + std::sin(along) * up);
    }
    return g;
  }

  /// Every segment at rest with the one before it, from the first one's frame on.
  FibreGeometry layAtRest(FibreGeometry g, Quatd q) const {
    const Quatd half = rotation(0.5 * rest_);
    Vec3d x = p_.start;
    for (int k = 0; k < p_.segments; ++k) {
      g.position.push_back(x);
      g.orientation.push_back(q);
      x += length_ * axis1(q * half);
      q = (q * half) * half;
    }
    return g;
  }

  FibreParameters p_;
  double length_;
  Vec3d rest_;
  FibreGeometry geometry_;
};

}  // namespace

std::unique_ptr<Scene> makeFibreScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: fibre", use != SceneUse::none, "-scene is not fibre");
  FibreParameters p;
  p.segments =
      static_cast<int>(s.integer("fibre_segments", 100, "number of segments", 1, 100000000));
  if (auto v =
          s.reals("fibre_start", 3, "0,0,0", context.units.length, "centre of the first segment"))
    p.start = {(*v)[0], (*v)[1], (*v)[2]};
  if (auto v = s.reals("fibre_direction", 3, "1,0,0", "", "direction of the first segment"))
    p.direction = {(*v)[0], (*v)[1], (*v)[2]};
  p.bend = s.real("fibre_bend", 0.0, "rad",
                  "angle between the first and the last segment, along a circular arc");
  p.twist = s.real("fibre_twist", 0.0, "rad", "twist between the first and the last segment");
  p.strain = s.real("fibre_strain", 0.0, "", "initial strain of the bonds", {-0.9});
  p.closed = s.flag("fibre_closed", false,
                    "join the last segment to the first (a ring with -fibre_bend "
                    "6.283185307179586, or through a periodic boundary)");
  p.atRest = s.choice("fibre_shape", "arc", {"arc", "rest"},
                      "an arc by the options above, or the rest shape of its kind") == "rest";
  p.kind = readSceneKinds(s, "fibre_kind", context.kinds, 1)[0];
  if (use != SceneUse::start) return nullptr;
  if (!(norm(p.direction) > 0 && std::isfinite(norm(p.direction))))
    throw InputError("-fibre_direction: must not be zero, nor beyond all numbers");
  if (p.atRest && (p.bend != 0 || p.twist != 0 || p.strain != 0))
    throw InputError("-fibre_shape rest: has no -fibre_bend, -fibre_twist or -fibre_strain");
  if (p.closed && p.segments < 3) throw InputError("-fibre_closed: needs three segments at least");
  // Every rank holds the whole fibre until the shares are made.
  requireMemory(context.comm, p.segments, sizeof(Vec3d) + sizeof(Quatd));
  return std::make_unique<FibreScene>(p, context.kinds[p.kind]);
}

}  // namespace nanoweft
