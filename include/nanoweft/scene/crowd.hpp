/// Segments that have been laid, in cells: does another one fit among them, and how close do they
/// lie?
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "nanoweft/scene/laid.hpp"
#include "nanoweft/state/box.hpp"

namespace nanoweft {

/// A laid segment.
struct LaidPiece {
  Vec3d centre, axis;
  double half;  ///< of its length
  std::int64_t fibre;
  int index, kind;
};

/// The segments of a fibre on a line.
std::vector<LaidPiece> piecesOf(const Line& line, std::int64_t fibre, int kind);

class Crowd {
 public:
  /// `reach`: within which centres are asked for.
  Crowd(const Box& box, double reach);

  void add(const LaidPiece& piece);
  std::size_t size() const { return pieces_.size(); }

  /// Takes back the latest until so many are left.
  void shrink(std::size_t size);

  /// Calls visit(piece, d) for the pieces whose centres may be within reach of `x`, at `d` from it,
  /// until one call gives true, which is then the answer.
  template <class Visit>
  bool near(const Vec3d& x, const Visit& visit) const {
    const Cell at = cellOf(x);
    for (int around = 0; around < 27; ++around) {
      const auto cell = cells_.find(
          keyOf({at[0] + around / 9 - 1, at[1] + around / 3 % 3 - 1, at[2] + around % 3 - 1}));
      if (cell == cells_.end()) continue;
      for (const int i : cell->second) {
        const LaidPiece& piece = pieces_[static_cast<std::size_t>(i)];
        if (visit(piece, nearest_(piece.centre - x))) return true;
      }
    }
    return false;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cellOf(const Vec3d& x) const;
  std::uint64_t keyOf(Cell cell) const;

  std::array<double, 3> lower_, width_;
  std::array<std::int64_t, 3> count_;  ///< of cells, in periodic directions; else 0
  MinimumImage nearest_;
  std::vector<LaidPiece> pieces_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

/// Segments of one fibre so few places apart are not looked at.
int neighboursApart(double gap, double length);

/// Is the piece nearer than its gap to another fibre's, or to a part of its own that is not next?
bool crowded(const Crowd& crowd, const LaidPiece& piece, const KindMix& mix);

/// What must keep apart, and how far.
struct Clearance {
  double gap;              ///< between axes
  std::int64_t group = 1;  ///< of so many lines, one after another, that are not looked at
  Box box = {};
};

/// The least distance between the axes of segments of `lines`, over the gap; at most one and a
/// half.
double tightest(const std::vector<Line>& lines, const Clearance& clearance);

/// How many points a line of this length has, and three more. Throws InputError, which begins with
/// `option`, where `lines` of them have more than scaleToFit can look at.
int pointsToLookAt(double length, double chord, double lines, const std::string& option);

/// The scale at which the nearest of what `make(scale)` lays are a gap apart, or up to a hundredth
/// more. Throws InputError, which begins with `option`, where no scale serves.
double scaleToFit(const std::function<std::vector<Line>(double)>& make, const Clearance& clearance,
                  const std::string& option);

}  // namespace nanoweft
