/// What energy and stress are told apart by: the bonds and the motion of each kind of fibre, the
/// pairs of each two kinds, and links.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "nanoweft/fibre/kinds.hpp"

namespace nanoweft {

/// Numbers of the carriers: first the kinds, then their pairs, last the links.
struct Carriers {
  int kinds = 1;

  int ofKind(int kind) const { return kind; }
  int ofPair(int a, int b) const {
    const int low = std::min(a, b), before = low * kinds - low * (low - 1) / 2;
    return kinds + before + std::max(a, b) - low;
  }
  int links() const { return ofPair(kinds - 1, kinds - 1) + 1; }
  int count() const { return links() + 1; }
};

/// thin, thick, thin_thin_pair, thin_thick_pair, thick_thick_pair, links
inline std::vector<std::string> carrierNames(const Kinds& kinds) {
  std::vector<std::string> names = kinds.names();
  for (int a = 0; a < kinds.count(); ++a)
    for (int b = a; b < kinds.count(); ++b)
      names.push_back(kinds[a].kind + "_" + kinds[b].kind + "_pair");
  names.push_back("links");
  return names;
}

}  // namespace nanoweft
