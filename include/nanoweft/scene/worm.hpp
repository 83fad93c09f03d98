/// Fibres that are grown at random, bond after bond, where they overlap nothing that lies already.
#pragma once

#include <functional>
#include <optional>

#include "nanoweft/base/random.hpp"
#include "nanoweft/scene/crowd.hpp"

namespace nanoweft {

/// A straight or worm-like fibre to be grown.
struct Worm {
  std::int64_t fibre;
  int kind, segments;
  double length;                 ///< of a segment
  double persistence;            ///< 0: straight
  std::optional<double> height;  ///< in the plane at this z
  std::uint64_t seed;
};

/// Times that a fibre is begun anew before it is given up.
inline constexpr int wormTrials = 2000;

/// A place in the box for the fibre's first segment and a direction, by lot; then segment after
/// segment, each turned against the one before it by lot. Where none fits, it is begun anew; after
/// many trials a worm-like fibre instead loses its last few and grows another way. Draws belong to
/// the fibre, the trial and their number in it. Leaves the fibre's pieces in the crowd. Empty: no
/// trial came to its end. `taken(piece)`: must not lie there.
std::optional<Line> growWorm(Crowd& crowd, const Box& box, const Worm& worm,
                             const std::function<bool(const LaidPiece&)>& taken);

/// Reads -NAME_persistence. Throws InputError below twelve segments.
double readPersistence(OptionSection& section, const std::string& scene,
                       const SceneContext& context);

/// What to say of worm-like fibres that are, as they lie, at least a tenth more or less flexible
/// than asked for, and more than by chance; else empty. Those that all lie flat count as such.
std::string persistenceWarning(const std::string& scene, const std::vector<Line>& lines,
                               const KindMix& mix, double persistence, const char* unit);

}  // namespace nanoweft
