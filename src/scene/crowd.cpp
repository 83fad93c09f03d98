#include "nanoweft/scene/crowd.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/pieces.hpp"

namespace nanoweft {

std::vector<LaidPiece> piecesOf(const Line& line, std::int64_t fibre, int kind) {
  const std::vector<Vec3d> axis = directionsOf(line);
  const double length = norm(line.points[1] - line.points[0]);
  std::vector<LaidPiece> pieces;
  for (std::size_t k = 0; k < axis.size(); ++k)
    pieces.push_back({line.points[k], axis[k], 0.5 * length, fibre, static_cast<int>(k), kind});
  return pieces;
}

Crowd::Crowd(const Box& box, double reach) : nearest_(box) {
  for (std::size_t d = 0; d < 3; ++d) {
    const double length = box.length(static_cast<int>(d));
    count_[d] =
        box.periodic[d] ? std::max<std::int64_t>(1, std::llround(std::floor(length / reach))) : 0;
    lower_[d] = box.lower[d];
    width_[d] = box.periodic[d] ? length / static_cast<double>(count_[d]) : reach;
  }
}

Crowd::Cell Crowd::cellOf(const Vec3d& x) const {
  const double c[3] = {x.x, x.y, x.z};
  Cell cell;
  for (std::size_t d = 0; d < 3; ++d)
    cell[d] = static_cast<std::int64_t>(std::floor((c[d] - lower_[d]) / width_[d]));
  return cell;
}

std::uint64_t Crowd::keyOf(Cell cell) const {
  std::uint64_t key = 0;
  for (std::size_t d = 0; d < 3; ++d) {
    if (count_[d] > 0) cell[d] = (cell[d] % count_[d] + count_[d]) % count_[d];
    key = key << 21 | (static_cast<std::uint64_t>(cell[d]) & 0x1fffff);
  }
  return key;
}

void Crowd::add(const LaidPiece& piece) {
  cells_[keyOf(cellOf(piece.centre))].push_back(static_cast<int>(pieces_.size()));
  pieces_.push_back(piece);
}

void Crowd::shrink(std::size_t size) {
  for (; pieces_.size() > size; pieces_.pop_back())
    cells_[keyOf(cellOf(pieces_.back().centre))].pop_back();
}

int neighboursApart(double gap, double length) {
  // Within so many places a bent fibre may come near itself: half a circle as wide as the gap,
  // twice.
  return static_cast<int>(std::ceil(3.2 * gap / length));
}

bool crowded(const Crowd& crowd, const LaidPiece& piece, const KindMix& mix) {
  return crowd.near(piece.centre, [&](const LaidPiece& other, const Vec3d& d) {
    const double gap = mix.gap(piece.kind, other.kind);
    if (other.fibre == piece.fibre &&
        std::abs(piece.index - other.index) <= neighboursApart(gap, 2.0 * piece.half))
      return false;
    return distanceOfPieces(d, piece.axis, other.axis, {piece.half, other.half}) < gap;
  });
}

double tightest(const std::vector<Line>& lines, const Clearance& clearance) {
  constexpr double far = 1.5;
  double longest = 0;
  for (const Line& line : lines) longest = std::max(longest, norm(line.points[1] - line.points[0]));
  const double gap = clearance.gap;
  Crowd crowd(clearance.box, far * gap + longest);
  double least = far;
  for (std::size_t f = 0; f < lines.size(); ++f) {
    const auto fibre = static_cast<std::int64_t>(f);
    const auto pieces = piecesOf(lines[f], fibre, 0);
    for (const LaidPiece& piece : pieces) crowd.add(piece);
    const auto count = static_cast<int>(pieces.size());
    const int few = neighboursApart(gap, 2.0 * pieces[0].half);
    for (const LaidPiece& piece : pieces)
      crowd.near(piece.centre, [&](const LaidPiece& other, const Vec3d& d) {
        if (clearance.group > 1 && other.fibre / clearance.group == fibre / clearance.group)
          return false;
        const int between = std::abs(piece.index - other.index);
        if (other.fibre == fibre && (between <= few || (lines[f].closed && count - between <= few)))
          return false;
        const double distance =
            distanceOfPieces(d, piece.axis, other.axis, {piece.half, other.half});
        least = std::min(least, distance / gap);
        return false;
      });
  }
  return least;
}

int pointsToLookAt(double length, double chord, double lines, const std::string& option) {
  constexpr double most = 4e6;  // minutes
  const double points = std::floor(length / chord) + 3;
  if (lines * points > most)
    throw InputError(
        format("%s: the fibres of a repeat would have %.3g segments, too many to look "
               "for overlaps; at most %g",
               option.c_str(), lines * points, most));
  return static_cast<int>(points);
}

double scaleToFit(const std::function<std::vector<Line>(double)>& make, const Clearance& clearance,
                  const std::string& option) {
  // Between a scale that is too small and one that is large enough.
  double small = 0, large = 0, scale = 1;
  for (int trial = 0; trial < 60 && scale < 20; ++trial) {
    const double found = tightest(make(scale), clearance);
    if (found >= 1.0 && found <= 1.01) return scale;
    (found < 1.0 ? small : large) = scale;
    scale = large == 0 ? 1.25 * small : small == 0 ? 0.8 * large : 0.5 * (small + large);
  }
  throw InputError(option + ": the fibres would run through each other");
}

}  // namespace nanoweft
