/// What links are made of: their law, and when they break.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/kinds.hpp"

namespace nanoweft {

struct LinkLaw {
  std::string kind;  ///< its name; empty where links are of one kind without name
  /// Its rest length is each link's own.
  EvmBond bond;
  bool spring = false;  ///< of its bond the stretching alone: the ends are free to turn
  double breakStrain = std::numeric_limits<double>::infinity(),
         breakForce = std::numeric_limits<double>::infinity();
  // Links that the run makes at its start, between fibres that are close:
  double density = 0;   ///< their number per length of fibre; 0: none
  double distance = 0;  ///< of the two axes at most
};

/// The laws of the kinds of links, by their numbers; at least one.
using LinkLaws = std::vector<LinkLaw>;

/// The names of the kinds; one empty name where -link_kinds was not given.
std::vector<std::string> namesOf(const LinkLaws& laws);

/// Reads -link_kinds, and -link_... and -links_... of each kind: with its name as prefix, else
/// those meant for all. Defaults are the bonds of the first kind of fibre. `inFile`: the state that
/// the run starts from has links. Without any, -link_... are refused.
LinkLaws readLinkLaws(Options& options, const UnitSystem& units, const Kinds& kinds, bool inFile);

}  // namespace nanoweft
