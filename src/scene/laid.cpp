#include "nanoweft/scene/laid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/random.hpp"

namespace nanoweft {

KindMix::KindMix(OptionSection& section, const std::string& scene, const SceneContext& context,
                 MixOptions which)
    : all_(context.kinds), seed_(context.seed) {
  const std::string option = scene + "_kinds";
  const auto names = section.words(option, "kinds of the fibres; the first of -kinds");
  for (const std::string& name : names)
    kinds_.push_back(kindNumber(context.kinds, "-" + option, name));
  if (kinds_.empty()) kinds_.push_back(0);
  if (!which.shares && names.size() > 1)
    throw InputError("-" + option + ": the scene has one fibre, so give one kind");
  if (which.shares) readShares(section, scene);
  if (which.gap)
    gap_ = section.maybeReal(scene + "_gap", "rest distance of the pair law", context.units.length,
                             "distance between the axes of fibres that touch", positive);
}

void KindMix::readShares(OptionSection& section, const std::string& scene) {
  const auto given = section.reals(scene + "_shares", 0, "equal", "",
                                   "shares of the kinds in the number of fibres");
  if (!given) return;
  shares_ = *given;
  const double sum = std::accumulate(shares_.begin(), shares_.end(), 0.0);
  if (shares_.size() != kinds_.size() || std::ranges::min(shares_) < 0 ||
      std::abs(sum - 1.0) > 1e-6)
    throw InputError(format("-%s_shares: needs a share for each of -%s_kinds, which add to 1",
                            scene.c_str(), scene.c_str()));
}

std::shared_ptr<const KindMix> KindMix::given(const SceneContext& context, std::int64_t fibres,
                                              const std::function<int(std::int64_t)>& kindOf) {
  auto mix = std::shared_ptr<KindMix>(new KindMix(context));
  mix->kinds_ = {0};
  for (std::int64_t f = 0; f < fibres; ++f) mix->ofFibre_.push_back(kindOf(f));
  return mix;
}

void KindMix::prepare(const SceneContext& context) {
  for (int a = 0; a < all_.count(); ++a)
    for (int b = 0; b < all_.count(); ++b)
      gaps_.push_back(gap_ ? *gap_ : context.restDistance(a, b));
}

void KindMix::draw(std::int64_t fibres) {
  if (kinds_.size() == 1) return;
  std::vector<std::pair<double, std::int64_t>> lots;
  for (std::int64_t f = 0; f < fibres; ++f)
    lots.emplace_back(uniformPair(seed_, Purpose::sceneKind, f, 0)[0], f);
  std::ranges::sort(lots);
  std::size_t k = 0;
  ofFibre_.resize(lots.size());
  const std::vector<std::int64_t> counts = countsOf(fibres);
  for (std::size_t i = 0; i < kinds_.size(); ++i)
    for (std::int64_t n = 0; n < counts[i]; ++n)
      ofFibre_[static_cast<std::size_t>(lots[k++].second)] = kinds_[i];
}

std::vector<std::int64_t> KindMix::countsOf(std::int64_t fibres) const {
  double sum = 0;
  for (std::size_t i = 0; i < kinds_.size(); ++i) sum += share(i);
  std::vector<std::int64_t> counts;
  std::vector<std::pair<double, std::size_t>> rests;
  std::int64_t left = fibres;
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    const double due = share(i) / sum * static_cast<double>(fibres);
    counts.push_back(static_cast<std::int64_t>(std::floor(due)));
    rests.emplace_back(due - static_cast<double>(counts[i]), i);
    left -= counts[i];
  }
  // What is left goes to the largest remainders.
  std::ranges::sort(rests, std::ranges::greater());
  for (std::size_t i = 0; left > 0; ++i, --left) ++counts[rests[i].second];
  return counts;
}

double KindMix::widest() const {
  double widest = 0;
  for (const int a : kinds_)
    for (const int b : kinds_) widest = std::max(widest, gap(a, b));
  return widest;
}

int KindMix::segments(std::int64_t number, int ofFirst) const {
  const Fibre& own = fibre(number);
  const auto count = static_cast<int>(std::lround(length(ofFirst) / own.length));
  if (count < 2)
    throw InputError(
        format("%d segments of the first kind are too short a fibre for the kind %s, "
               "whose segments are %.3g times as long; take %.0f at least",
               ofFirst, own.kind.c_str(), own.length / length(1),
               std::ceil(1.5 * own.length / length(1))));
  return count;
}

double KindMix::volume(int ofFirst) const {
  double section = 0;
  for (std::size_t k = 0; k < kinds_.size(); ++k)
    section += share(k) * std::numbers::pi * std::pow(all_[kinds_[k]].radius, 2);
  return section * length(ofFirst);
}

double KindMix::shadow(int ofFirst) const {
  double width = 0;
  for (std::size_t k = 0; k < kinds_.size(); ++k) width += share(k) * all_[kinds_[k]].diameter();
  return width * length(ofFirst);
}

bool readShaped(OptionSection& section, const std::string& scene) {
  return section.choice(scene + "_rest", "straight", {"straight", "shaped"},
                        "shape of the fibres at rest: that of their kind, or as they lie") ==
         "shaped";
}

namespace {

class LaidScene final : public Scene {
 public:
  LaidScene(const SceneContext& context, Laying laying)
      : laying_(std::move(laying)), units_(context.units) {
    requireCountable();
    box_ = laying_.box ? *laying_.box : around(context);
    volume_ = volumeOf(laying_);
  }

  Box box() const override { return box_; }
  bool shapesRest() const override { return laying_.shaped; }
  std::string file() const override { return laying_.file; }
  std::string packing(const Box& box) const override {
    const double space = laying_.space * spread(box_, box);
    std::string text = format("scene %s: %lld fibres", laying_.name.c_str(),
                              static_cast<long long>(laying_.fibres));
    if (space > 0)
      text += format(", volume fraction %.4g, %.4g fibres a %s^3", volume_ / space,
                     static_cast<double>(laying_.fibres) / space, units_.length);
    return text + (laying_.also.empty() ? "" : ", " + laying_.also) +
           (laying_.warning.empty() ? "" : "\n  warning: " + laying_.warning);
  }

  void fill(State& state) const override {
    const FibreShare share = shareOf(state.rank(), state.ranks());
    requireMemory(state.comm(), share.segments, state.memoryOfSegment());
    state.addOwned(static_cast<int>(share.segments));
    int i = 0;
    for (std::int64_t f = share.first, row = share.row; f < share.last; ++f) {
      const FibreGeometry g = make(f);
      putFibre(state, i, {row, f}, g);
      i += static_cast<int>(g.position.size()), row += static_cast<int>(g.position.size());
    }
    state.countTotal();
  }

 private:
  struct FibreShare {
    std::int64_t first, last, row = 0, segments = 0;
  };

  /// The fibres of a rank, and how many segments are before and in them.
  FibreShare shareOf(int rank, int ranks) const {
    FibreShare share{laying_.fibres * rank / ranks, laying_.fibres * (rank + 1) / ranks};
    for (std::int64_t f = 0; f < share.last; ++f)
      (f < share.first ? share.row : share.segments) += laying_.segments(f);
    return share;
  }

  FibreGeometry make(std::int64_t f) const {
    FibreGeometry g = geometryOf(laying_.line(f), laying_.shaped);
    g.kind = laying_.mix->of(f);
    return g;
  }

  void requireCountable() const {
    std::int64_t total = 0;
    for (std::int64_t f = 0; f < laying_.fibres; ++f) total += laying_.segments(f);
    if (total > std::numeric_limits<std::int32_t>::max())
      throw InputError("-scene " + laying_.name + ": more than 2^31 - 1 segments");
  }

  /// The box around all fibres, of which each rank makes its share.
  Box around(const SceneContext& context) const {
    int rank, ranks;
    MPI_Comm_rank(context.comm, &rank);
    MPI_Comm_size(context.comm, &ranks);
    const FibreShare share = shareOf(rank, ranks);
    const double margin = 4.0 * context.kinds.longest();
    std::array<double, 6> most;
    most.fill(-std::numeric_limits<double>::infinity());
    for (std::int64_t f = share.first; f < share.last; ++f)
      for (const Vec3d& x : laying_.line(f).points) {
        const double sides[6] = {x.x, x.y, x.z, -x.x, -x.y, -x.z};
        for (std::size_t d = 0; d < 6; ++d) most[d] = std::max(most[d], sides[d]);
      }
    MPI_Allreduce(MPI_IN_PLACE, most.data(), 6, MPI_DOUBLE, MPI_MAX, context.comm);
    Box box;
    for (std::size_t d = 0; d < 3; ++d)
      box.lower[d] = -most[d + 3] - margin, box.upper[d] = most[d] + margin;
    return box;
  }

  Laying laying_;
  const UnitSystem& units_;
  Box box_;
  double volume_ = 0;
};

}  // namespace

double volumeOf(const Laying& laying) {
  double volume = 0;
  for (std::int64_t f = 0; f < laying.fibres; ++f) {
    const Fibre& fibre = laying.mix->fibre(f);
    volume += std::numbers::pi * fibre.radius * fibre.radius * fibre.length * laying.segments(f);
  }
  return volume;
}

double shadowOf(const Laying& laying) {
  double shadow = 0;
  for (std::int64_t f = 0; f < laying.fibres; ++f) {
    const Fibre& fibre = laying.mix->fibre(f);
    shadow += fibre.diameter() * fibre.length * laying.segments(f);
  }
  return shadow;
}

std::unique_ptr<Scene> layScene(const SceneContext& context, Laying laying) {
  return std::make_unique<LaidScene>(context, std::move(laying));
}

}  // namespace nanoweft
