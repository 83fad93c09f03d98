/// The scenes. Each reads its own options, and makes a scene where the run starts from it.
#pragma once

#include "nanoweft/scene/scene.hpp"

namespace nanoweft {

using MakeScene = std::unique_ptr<Scene>(Options& options, const SceneContext& context,
                                         SceneUse use);

MakeScene makeWeaveScene;
MakeScene makeFibreScene;
MakeScene makeBundleScene;
MakeScene makeRingScene;
MakeScene makeRacketScene;
MakeScene makeHelixScene;
MakeScene makeRopeScene;
MakeScene makeFilmScene;
MakeScene makeNetworkScene;
MakeScene makeArrayScene;
MakeScene makeBraidScene;
MakeScene makeKnitScene;
MakeScene makeTextScene;
MakeScene makeLammpsScene;
MakeScene makeFileScene;

}  // namespace nanoweft
