/// The interface of scenes, which make the segments that a run starts from (a weave, one fibre, a
/// state file). A new one is one file, one line in
/// scenes.hpp and one in scene.cpp's table.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/state/memory.hpp"
#include "nanoweft/state/rest.hpp"
#include "nanoweft/state/state.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

/// What a scene may ask for besides its own options.
struct SceneContext {
  const UnitSystem& units;
  const Kinds& kinds;
  MPI_Comm comm;
  std::function<double(int, int)> restDistance;  ///< of two fibres of such kinds that touch
  std::uint64_t seed;                            ///< of all random numbers
};

/// The poses of one fibre's segments.
struct FibreGeometry {
  std::vector<Vec3d> position;
  std::vector<Quatd> orientation;
  bool closed = false;
  int kind = 0;
  std::vector<Vec3d> rest;  ///< rest rotations of the bonds to the successors; empty: the kind's
};

/// How far from rest the options want each bond to be.
struct StartRequest {
  double strain = 0, bend = 0, twist = 0;  ///< angles in radians
};

class Scene {
 public:
  virtual ~Scene() = default;
  /// The box that the scene fits into.
  virtual Box box() const = 0;
  /// Appends the segments to the empty state, a share on each rank, with rows, chains and all.
  virtual void fill(State& state) const = 0;
  virtual StartRequest asked() const { return {}; }
  /// Does it give bonds rest rotations of their own?
  virtual bool shapesRest() const { return false; }
  /// The file that the state comes from, where it comes from one.
  virtual const StateHeader* header() const { return nullptr; }
  virtual std::string file() const { return ""; }
  /// What was laid and how densely in the run's box, a line for the header; may be empty.
  virtual std::string packing(const Box&) const { return ""; }
  /// How much longer the run's box is than `own` where that is periodic, all directions multiplied.
  static double spread(const Box& own, const Box& box) {
    double spread = 1;
    for (int d = 0; d < 3; ++d)
      if (own.periodic[static_cast<std::size_t>(d)]) spread *= box.length(d) / own.length(d);
    return spread;
  }
};

/// What a run wants of one of the scenes.
enum class SceneUse {
  none,     ///< another is chosen: its options must not be given
  options,  ///< a restart: they are those of the run's first piece
  start,    ///< the run starts from it
};

/// The number of the kind of this name, which `where` (an option or a file) gives. Throws
/// InputError.
int kindNumber(const Kinds& kinds, const std::string& where, const std::string& name);

/// The numbers of the kinds that an option names, one for each of `count` families of fibres; the
/// first kind where it is not given. Throws InputError.
std::vector<int> readSceneKinds(OptionSection& section, const std::string& option,
                                const Kinds& kinds, std::size_t count);

/// Reads -scene and the options of the scenes. With a restart, no scene is made.
std::unique_ptr<Scene> readScene(Options& options, const SceneContext& context, bool restarting);

/// The place of a fibre's first segment in the order of all.
struct FibreStart {
  std::int64_t row, fibre;
};

/// Puts a fibre's segments into the points of the state from `i` on.
inline void putFibre(State& state, int i, const FibreStart& start, const FibreGeometry& geometry) {
  const auto segments = static_cast<int>(geometry.position.size());
  for (int k = 0; k < segments; ++k, ++i) {
    const auto at = static_cast<std::size_t>(k);
    state.row[i] = start.row + k;
    state.fibre[i] = start.fibre;
    state.chain[2 * i] = k;
    state.chain[2 * i + 1] = segments;
    state.bond[i] = geometry.closed ? fibreClosed : 0;
    double* x = state.pose + 8 * i;
    x[0] = geometry.position[at].x, x[1] = geometry.position[at].y, x[2] = geometry.position[at].z;
    state.setKind(i, geometry.kind);
    state.setOrientation(i, geometry.orientation[at]);
    if (!geometry.rest.empty()) setRest(state, i, geometry.rest[at]);
    state.box.wrap(x, state.image + 3 * i);
  }
}

/// For scenes that generate fibres: numbers `fibres` fibres of `segments` segments each and appends
/// this rank's share, made by `make(fibre)`.
template <class Make>
void fillFibres(State& state, std::int64_t fibres, int segments, const Make& make) {
  const std::int64_t first = fibres * state.rank() / state.ranks(),
                     last = fibres * (state.rank() + 1) / state.ranks();
  requireMemory(state.comm(), (last - first) * segments, state.memoryOfSegment());
  state.addOwned(static_cast<int>((last - first) * segments));
  int i = 0;
  for (std::int64_t f = first; f < last; ++f, i += segments)
    putFibre(state, i, {f * segments, f}, make(f));
  state.countTotal();
}

}  // namespace nanoweft
