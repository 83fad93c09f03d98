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
  // Links that the run makes at its start, between fibres that are close:
  double density = 0;   ///< their number per length of fibre; 0: none
  double distance = 0;  ///< of the two axes at most
};

/// Reads -link_... and -links_... Defaults are the bonds of the first kind. `inFile`: the state
/// that the run starts from has links. Without any, -link_... are refused.
LinkLaw readLinkLaw(Options& options, const UnitSystem& units, const Kinds& kinds, bool inFile);

}  // namespace nanoweft
