/// What links are made of: their law, and when they break.
#pragma once

#include <limits>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"

namespace nanoweft {

struct LinkLaw {
  /// Its rest length is each link's own.
  EvmBond bond;
  bool spring = false;  ///< of its bond the stretching alone: the ends are free to turn
  double breakStrain = std::numeric_limits<double>::infinity(),
         breakForce = std::numeric_limits<double>::infinity();
};

/// Reads -link_... Defaults are the bonds of the first kind. `linked`: the run has links; without
/// them the options are refused.
LinkLaw readLinkLaw(Options& options, const UnitSystem& units, const Kinds& kinds, bool linked);

}  // namespace nanoweft
