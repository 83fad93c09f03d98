#include "nanoweft/scene/places.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nanoweft {

namespace {

const double rowHeight = std::sqrt(0.75);

}  // namespace

std::vector<Place> hexagonalPlaces(int count) {
  // Along the axes i, at 0 degrees, and j, at 60 degrees.
  constexpr int steps[6][2] = {{-1, 1}, {-1, 0}, {0, -1}, {1, -1}, {1, 0}, {0, 1}};
  std::vector<Place> places;
  auto add = [&](int i, int j) {
    if (static_cast<int>(places.size()) < count) places.push_back({i + 0.5 * j, rowHeight * j});
  };
  add(0, 0);
  for (int ring = 1; static_cast<int>(places.size()) < count; ++ring) {
    int i = ring, j = 0;
    for (const auto& step : steps)
      for (int k = 0; k < ring; ++k, i += step[0], j += step[1]) add(i, j);
  }
  return places;
}

std::vector<Place> roundPlaces(int count) {
  if (count == 1 || count > 5) return hexagonalPlaces(count);
  std::vector<Place> places;
  const double turn = 2.0 * std::numbers::pi / count, radius = 0.5 / std::sin(0.5 * turn);
  for (int k = 0; k < count; ++k)
    places.push_back({radius * std::cos(k * turn), radius * std::sin(k * turn)});
  return places;
}

double widthOf(const std::vector<Place>& places) {
  double farthest = 0;
  for (const Place& p : places) farthest = std::max(farthest, std::hypot(p[0], p[1]));
  return 1.0 + 2.0 * farthest;
}

std::vector<Place> rowPlaces(int wide, int high) {
  std::vector<Place> places;
  for (int j = 0; j < high; ++j)
    for (int i = 0; i < wide; ++i)
      places.push_back({i - 0.5 * (wide - 1) +
                            (j % 2      ? 0.25
                             : high > 1 ? -0.25
                                        : 0.0),
                        rowHeight * (j - 0.5 * (high - 1))});
  return places;
}

}  // namespace nanoweft
