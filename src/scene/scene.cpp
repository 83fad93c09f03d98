#include "nanoweft/scene/scene.hpp"

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

struct Entry {
  const char* name;
  std::unique_ptr<Scene> (*make)(Options&, const SceneContext&, SceneUse);
};

// One line registers a scene.
constexpr Entry scenes[] = {
    {"weave", makeWeaveScene},
    {"fibre", makeFibreScene},
    {"file", makeFileScene},
};

}  // namespace

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
