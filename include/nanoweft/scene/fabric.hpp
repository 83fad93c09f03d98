/// Weaves beyond the plain one of single fibres: other patterns, tows of filaments, several layers.
#pragma once

#include <array>
#include <memory>

#include "nanoweft/scene/scene.hpp"

namespace nanoweft {

struct FabricParameters {
  enum Pattern { plain, twill, satin, basket } pattern = plain;
  std::array<int, 2> floats{};         ///< -weave_float
  std::array<int, 2> filaments{1, 1};  ///< of a tow, side by side and above each other
  int layers = 1;
  std::array<int, 2> count{}, kinds{0, 0};  ///< of tows along x and along y
  int segments = 0;
  double pitch = 0, gap = 0;  ///< pitch 0: as the segments allow
  bool periodic = false, shaped = false;

  /// Is it another weave than the plain one of single fibres?
  bool asked() const { return pattern != plain || filaments[0] * filaments[1] * layers > 1; }
  /// Does tow i along x lie above tow j along y?
  bool over(int i, int j) const;
  /// Tows after which the pattern comes again.
  int repeat() const;
};

/// The options -weave_pattern, -weave_float, -weave_filaments, -weave_layers. Throws InputError.
FabricParameters readFabric(OptionSection& section);

std::unique_ptr<Scene> makeFabric(const FabricParameters& parameters, const SceneContext& context);

}  // namespace nanoweft
