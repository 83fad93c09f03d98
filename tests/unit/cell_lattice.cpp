/// Cells of a lattice: a cell's neighbours hold all that is within the range, each once and no
/// more, whichever axis is the longest.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "nanoweft/domain/cell_lattice.hpp"

namespace nanoweft::test {
namespace {

using Lengths = std::array<double, 3>;

Box boxOf(const Lengths& upper, const std::array<bool, 3>& periodic, const Tilt& tilt = {}) {
  Box box;
  box.upper = upper;
  box.periodic = periodic;
  box.tilt = tilt;
  return box;
}

CellLattice latticeOf(const Box& box, double edge, double range) {
  return {box.lower, box.upper, box, edge, range, 1e4};
}

/// Distance of two points, or of their nearest images.
double distance(const Box& box, const Lengths& a, const Lengths& b) {
  double least = INFINITY;
  std::array<int, 3> turns;
  const auto most = [&](int d) { return box.periodic[static_cast<std::size_t>(d)] ? 1 : 0; };
  for (turns[0] = -most(0); turns[0] <= most(0); ++turns[0])
    for (turns[1] = -most(1); turns[1] <= most(1); ++turns[1])
      for (turns[2] = -most(2); turns[2] <= most(2); ++turns[2]) {
        Lengths way;
        for (int d = 0; d < 3; ++d) {
          const auto k = static_cast<std::size_t>(d);
          way[k] = b[k] + turns[k] * box.length(d) - a[k];
        }
        way[static_cast<std::size_t>(box.tilt.along)] +=
            turns[static_cast<std::size_t>(box.tilt.across)] * box.tilt.way;
        least = std::min(least, std::hypot(way[0], way[1], way[2]));
      }
  return least;
}

/// Points all over the box.
std::vector<Lengths> pointsOf(const Box& box) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<Lengths> points(100);
  for (Lengths& x : points)
    for (std::size_t d = 0; d < 3; ++d) x[d] = part(random) * box.upper[d];
  return points;
}

/// Each point finds all within the range in its cell's neighbours, each of which it has once.
void expectAllFound(const Box& box, double edge, double range) {
  const CellLattice lattice = latticeOf(box, edge, range);
  const std::vector<Lengths> points = pointsOf(box);
  std::vector<std::int64_t> around;
  std::size_t within = 0;
  for (const Lengths& a : points) {
    lattice.neighbours(lattice.cellOf(a.data()), around);
    const std::set<std::int64_t> cells(around.begin(), around.end());
    EXPECT_EQ(cells.size(), around.size());
    for (const Lengths& b : points) {
      if (distance(box, a, b) > range) continue;
      ++within;
      EXPECT_TRUE(cells.contains(lattice.cellOf(b.data())))
          << testing::PrintToString(a) << " does not find " << testing::PrintToString(b);
    }
  }
  EXPECT_GT(within, 3 * points.size());
}

const std::vector<Lengths> shapes{{100, 50, 30}, {50, 100, 30}, {30, 100, 50},
                                  {100, 30, 50}, {50, 30, 100}, {30, 50, 100}};

TEST(CellLattice, NeighboursHoldAllWithinTheRange) {
  for (const Lengths& upper : shapes)
    for (int periodic = 0; periodic < 8; ++periodic) {
      SCOPED_TRACE(testing::PrintToString(upper) + ", periodic " + std::to_string(periodic));
      const Box box = boxOf(upper, {(periodic & 1) != 0, (periodic & 2) != 0, (periodic & 4) != 0});
      expectAllFound(box, 10, 12);
      expectAllFound(box, 5, 12);
    }
}

TEST(CellLattice, NeighboursHoldAllWithinTheRangeOfATiltedBox) {
  for (const Lengths& upper : shapes)
    for (int place = 0; place < 3; ++place) {
      SCOPED_TRACE(testing::PrintToString(upper) + ", tilt " + std::to_string(place));
      expectAllFound(boxOf(upper, {true, true, true}, Tilt::ofPair(place, 7)), 5, 12);
    }
}

TEST(CellLattice, NeighboursAreNoMoreThanTheLayersInReach) {
  for (const Lengths& upper : shapes) {
    SCOPED_TRACE(testing::PrintToString(upper));
    const CellLattice open = latticeOf(boxOf(upper, {}), 10, 10),
                      closed = latticeOf(boxOf(upper, {true, true, true}), 10, 10);
    const Lengths corner{1, 1, 1}, inside{15, 15, 15};
    std::vector<std::int64_t> around;
    const auto count = [&](const CellLattice& lattice, const Lengths& x) {
      lattice.neighbours(lattice.cellOf(x.data()), around);
      return around.size();
    };
    EXPECT_EQ(count(open, corner), 8u);
    EXPECT_EQ(count(open, inside), 27u);
    EXPECT_EQ(count(closed, corner), 27u);
    EXPECT_EQ(count(latticeOf(boxOf(upper, {}), 10, 1000), corner), 10u * 5u * 3u);
  }
}

TEST(CellLattice, EachCellIsCountedOnce) {
  for (const Lengths& upper : shapes) {
    const CellLattice lattice = latticeOf(boxOf(upper, {}), 10, 10);
    std::set<std::int64_t> cells;
    for (double x = 5; x < upper[0]; x += 10)
      for (double y = 5; y < upper[1]; y += 10)
        for (double z = 5; z < upper[2]; z += 10)
          cells.insert(lattice.cellOf(Lengths{x, y, z}.data()));
    EXPECT_EQ(cells.size(), 150u);
    EXPECT_EQ(*cells.begin(), 0);
    EXPECT_EQ(*cells.rbegin(), 149);
  }
}

}  // namespace
}  // namespace nanoweft::test
