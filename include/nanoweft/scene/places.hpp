/// Places of fibres across a bundle, in units of the distance between neighbours.
#pragma once

#include <array>
#include <vector>

namespace nanoweft {

using Place = std::array<double, 2>;

/// Hexagonal packing from the middle outwards: a spiral of hexagons.
std::vector<Place> hexagonalPlaces(int count);

/// Around the axis: up to five on a circle, more in hexagons.
std::vector<Place> roundPlaces(int count);

/// How wide a strand is that has its fibres in these places, fibres a distance thick.
double widthOf(const std::vector<Place>& places);

/// Rows above each other, each half a distance beside the one below.
std::vector<Place> rowPlaces(int wide, int high);

}  // namespace nanoweft
