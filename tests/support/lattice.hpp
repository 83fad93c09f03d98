/// A triangular lattice of single segments, with springs between neighbours.
#pragma once

#include <string>

namespace nanoweft::test {

/// Of n x n nodes at the distance `a`, in rows along x.
struct Lattice {
  static constexpr int n = 8;
  static constexpr double a = 60, rise = a * 0.8660254037844386, area = n * a * n * rise;
};

/// Writes a periodic one with its links. Its nodes are displaced at random by up to `off`, A.
void writeLattice(const std::string& file, double off);

}  // namespace nanoweft::test
