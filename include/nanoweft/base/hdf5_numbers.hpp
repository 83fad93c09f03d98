/// Reads datasets of numbers from HDF5 files that anyone may have made. A dataset that is not as
/// expected gives a problem in words, never a wrong number.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "nanoweft/base/hdf5.hpp"

namespace nanoweft::h5 {

/// What a dataset must be.
struct Expected {
  const char* name;
  int columns;    ///< 1: one dimension
  bool whole;     ///< whole numbers
  int depth = 0;  ///< of a third dimension; 0: there is none

  int dimensions() const { return depth ? 3 : columns == 1 ? 1 : 2; }
  int perRow() const { return columns * std::max(depth, 1); }
};

/// What a link of a group leads to.
enum class Found { nothing, group, dataset, other, deadLink, otherFile };
Found find(hid_t group, const char* name);

struct Shape {
  std::string problem;  ///< "must ..." or "is ..."; empty when all is well
  std::int64_t rows = 0;
  /// Every element has been written; otherwise HDF5 would give zeros for what is not there.
  bool written = true;
};

/// Looks at kind, type, shape, filters and storage of a dataset that is there.
Shape inspect(hid_t group, const Expected& expected);

/// Reads rows from `begin` on of a dataset that `inspect` found in order. Returns a problem:
/// damage, fractions for whole numbers, values that T cannot hold.
template <class T>
std::string readRows(hid_t group, const Expected& expected, std::int64_t begin, std::int64_t count,
                     std::vector<T>& values);

}  // namespace nanoweft::h5
