/// Scene `file`: segments from a state file (src/manual/file_format.md).
#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

class FileScene final : public Scene {
 public:
  FileScene(MPI_Comm comm, std::string file, Trust trust)
      : file_(std::move(file)), header_(readStateHeader(comm, file_, trust)) {}

  Box box() const override { return header_.box; }
  const StateHeader* header() const override { return &header_; }
  std::string file() const override { return file_; }
  bool shapesRest() const override { return header_.parts.contains("rest_rotation"); }
  void fill(State& state) const override {
    readStateRows(file_, header_, state);
    // A new run starts its own clock.
    state.step = 0;
    state.time = 0;
  }

 private:
  std::string file_;
  StateHeader header_;
};

}  // namespace

std::unique_ptr<Scene> makeFileScene(Options& options, const SceneContext& context, SceneUse use) {
  // What the file holds is part of the results' provenance, its name is not.
  OptionSection s =
      OptionSection(options, "Scene", use != SceneUse::none, "-scene is not file").as(Role::run);
  const std::string file = s.text("scene_file", "", "state file to start from (-scene file)");
  const bool edited = s.flag(
      "scene_file_edited", false,
      "-scene_file was changed on purpose since nanoweft wrote it: do not compare its SHA-256");
  if (use != SceneUse::start) return nullptr;
  if (file.empty()) throw InputError("-scene file needs -scene_file NAME");
  auto scene =
      std::make_unique<FileScene>(context.comm, file, edited ? Trust::edited : Trust::program);
  if (scene->header()->units != context.units.name)
    throw InputError(format("state file %s is in units %s, the run in -units %s", file.c_str(),
                            scene->header()->units.c_str(), context.units.name.c_str()));
  return scene;
}

}  // namespace nanoweft
