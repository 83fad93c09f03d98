/// Scenes that lay fibres along centre lines, and what their options have in common.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/scene/line.hpp"
#include "nanoweft/scene/scene.hpp"

namespace nanoweft {

/// Which options a scene has of those of a KindMix.
struct MixOptions {
  bool gap = true;     ///< it chooses where its fibres lie, and so how far apart
  bool shares = true;  ///< it has more than one fibre
};

/// Which fibre is of which kind, and how far apart two fibres lie that touch:
/// -NAME_kinds, -NAME_shares, -NAME_gap.
class KindMix {
 public:
  KindMix(OptionSection& section, const std::string& scene, const SceneContext& context,
          MixOptions which = {});
  /// Each fibre of the kind that `kindOf` says, without options; it has no gaps.
  static std::shared_ptr<const KindMix> given(const SceneContext& context, std::int64_t fibres,
                                              const std::function<int(std::int64_t)>& kindOf);
  /// Looks up the gaps, which it may only do until the pair laws are handed on.
  void prepare(const SceneContext& context);

  /// Gives so many fibres their kinds: of each kind its share, rounded, which ones by lot.
  void draw(std::int64_t fibres);
  int of(std::int64_t fibre) const {
    return ofFibre_.empty() ? kinds_[0] : ofFibre_[static_cast<std::size_t>(fibre)];
  }
  const Fibre& fibre(std::int64_t number) const { return all_[of(number)]; }
  const Kinds& all() const { return all_; }

  double gap(int a, int b) const { return gaps_[static_cast<std::size_t>(a * all_.count() + b)]; }
  double widest() const;  ///< gap of two of the kinds that it mixes

  /// Segments of a fibre that is as long as so many segments of the first kind.
  int segments(std::int64_t fibre, int ofFirst) const;
  /// Mean volume of a fibre as long as so many segments of the first kind.
  double volume(int ofFirst) const;
  double shadow(int ofFirst) const;  ///< likewise its length times its diameter
  void assign(std::vector<int> ofFibre) { ofFibre_ = std::move(ofFibre); }
  double length(int ofFirst) const { return ofFirst * all_[kinds_[0]].length; }

 private:
  /// How many of so many fibres each kind has: its share, rounded down, and one more of those with
  /// the largest remainders.
  std::vector<std::int64_t> countsOf(std::int64_t fibres) const;
  void readShares(OptionSection& section, const std::string& scene);
  explicit KindMix(const SceneContext& context) : all_(context.kinds), seed_(context.seed) {}
  double share(std::size_t kind) const {
    return shares_.empty() ? 1.0 / static_cast<double>(kinds_.size()) : shares_[kind];
  }

  const Kinds& all_;
  std::uint64_t seed_;
  std::vector<int> kinds_;
  std::vector<double> shares_;  ///< empty: equal ones
  std::optional<double> gap_;
  std::vector<double> gaps_;  ///< of each two kinds
  std::vector<int> ofFibre_;
};

/// -NAME_rest: are bonds at rest as the scene lays them?
bool readShaped(OptionSection& section, const std::string& scene);

/// What a scene lays, fibre by fibre. The functions must give the same on all ranks.
struct Laying {
  std::string name;
  std::shared_ptr<const KindMix> mix;
  std::int64_t fibres = 0;
  std::function<int(std::int64_t)> segments = {};
  std::function<Line(std::int64_t)> line = {};
  std::optional<Box> box = {};  ///< empty: open, around all fibres
  double space = 0;             ///< volume of which they fill a fraction; 0: not stated
  std::string also = {};        ///< to be said besides
  std::string warning = {};     ///< of what may have been meant otherwise
  bool shaped = false;
  std::string file = {};  ///< that it comes from
};

/// Lays each fibre on the rank that owns it at the start. Throws InputError for more than 2^31 - 1
/// segments. Collective.
std::unique_ptr<Scene> layScene(const SceneContext& context, Laying laying);

/// Section of a tube by the mean of its radii and the thickness of its wall, or of the cylinder
/// where the wall leaves no hole.
inline double tubeSection(double radius, double wall) {
  const double inner = std::max(0.0, radius - 0.5 * wall), outer = radius + 0.5 * wall;
  return std::numbers::pi * (outer * outer - inner * inner);
}

/// Volume of all its fibres, each a cylinder of its radius.
double volumeOf(const Laying& laying);
/// Sum of their lengths times their diameters.
double shadowOf(const Laying& laying);

}  // namespace nanoweft
