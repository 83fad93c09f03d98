#include "nanoweft/scene/scene.hpp"

#include <algorithm>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

struct Entry {
  const char* name;
  MakeScene* make;
};

// One line registers a scene.
// clang-format off
constexpr Entry scenes[] = {
    {"weave", makeWeaveScene},
    {"fibre", makeFibreScene},
    {"bundle", makeBundleScene},
    {"ring", makeRingScene},
    {"racket", makeRacketScene},
    {"helix", makeHelixScene},
    {"rope", makeRopeScene},
    {"film", makeFilmScene},
    {"network", makeNetworkScene},
    {"array", makeArrayScene},
    {"braid", makeBraidScene},
    {"knit", makeKnitScene},
    {"text", makeTextScene},
    {"lammps", makeLammpsScene},
    {"file", makeFileScene},
};
// clang-format on

}  // namespace

int kindNumber(const Kinds& kinds, const std::string& where, const std::string& name) {
  const auto known = kinds.names();
  const auto at = std::ranges::find(known, name);
  if (at == known.end())
    throw InputError(format("%s: '%s' is not among -kinds", where.c_str(), name.c_str()));
  return static_cast<int>(at - known.begin());
}

std::vector<int> readSceneKinds(OptionSection& section, const std::string& option,
                                const Kinds& kinds, std::size_t count) {
  const auto names = section.words(
      option, count > 1 ? "kinds of the fibres along x and along y; the first of -kinds"
                        : "kind of the fibre; the first of -kinds");
  std::vector<int> numbers(count, 0);
  if (names.empty()) return numbers;
  if (names.size() != count)
    throw InputError(format("-%s: needs %zu name%s", option.c_str(), count, count > 1 ? "s" : ""));
  for (std::size_t k = 0; k < count; ++k) numbers[k] = kindNumber(kinds, "-" + option, names[k]);
  return numbers;
}

std::unique_ptr<Scene> readScene(Options& options, const SceneContext& context, bool restarting) {
  std::vector<std::string> names;
  for (const Entry& e : scenes) names.push_back(e.name);
  OptionSection s(options, "Scene");
  const std::string chosen = s.choice("scene", "weave", names, "where the fibres come from");
  std::unique_ptr<Scene> result;
  for (const Entry& e : scenes) {
    const SceneUse use = chosen != e.name ? SceneUse::none
                         : restarting     ? SceneUse::options
                                          : SceneUse::start;
    auto scene = e.make(options, context, use);
    if (scene) result = std::move(scene);
  }
  return result;
}

}  // namespace nanoweft
