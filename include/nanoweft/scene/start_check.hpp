/// Looks at the bonds of a start: those far from rest are mostly mistakes, such as another unit or
/// another order of the quaternion's components.
#pragma once

#include <string>
#include <vector>

#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"
#include "nanoweft/scene/scene.hpp"
#include "nanoweft/scene/start_bonds.hpp"

namespace nanoweft {

struct StartContext {
  const UnitSystem& units;
  const Kinds& kinds;
  Box sceneBox;        ///< before -domain_... changed it
  StartRequest asked;  ///< what the scene was told to do to its bonds
  bool fromFile;
  /// A run with these same bonds and this box left the state: large strains are its result.
  bool evolved;
};

/// One kind of departure from rest.
struct StartFinding {
  bool refused;  ///< cannot be meant; else worth a warning
  std::string text;
};

/// To be called when a scene has filled the state, before segments move among ranks. All ranks get
/// the same findings, the most telling first. Collective.
std::vector<StartFinding> lookAtStart(const State& state, const StartContext& context);

/// The bond that is worst in one respect, as all ranks know it.
struct WorstBond {
  double value = -1;
  std::int64_t row = 0, fibre = 0;
  std::int32_t index = 0, next = 0;
  std::int32_t closes = 0;
  std::int32_t bent = 0;  ///< of the two, the segment whose axis is worse
  std::int32_t kind = 0;
  double rest = 0;  ///< length
  Vec3d from, to;
};

// What lies behind a finding, as the end of its sentence, with the remedy. Collective.
std::string strainCause(const StartBonds& bonds, const StartContext& context,
                        const WorstBond& worst);
std::string axisCause(const StartBonds& bonds, const StartContext& context);

}  // namespace nanoweft
