/// Fibres along centre lines from a file, whose points need not be a segment apart.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nanoweft/scene/laid.hpp"

namespace nanoweft {

struct CentreLine {
  std::vector<Vec3d> points = {};
  bool closed = false;   ///< the first point comes after the last
  Vec3d round{0, 0, 0};  ///< displacement after one round of a line that closes through the box
};

/// The text of the file that the option -NAME_file gives, which the first rank reads. Throws
/// InputError. Collective.
std::string readSceneText(MPI_Comm comm, const std::string& scene, const std::string& file);

/// The words between blanks.
std::vector<std::string_view> wordsOf(std::string_view line);

/// The finite number that a word is, or nothing.
std::optional<double> numberOf(std::string_view word);

/// Fibres laid a segment length at a time on smooth curves (Catmull and Rom) through the points of
/// the lines, each from its middle on, as many segments as come nearest to its length. `laying`
/// has the name, the file and the kinds. Throws InputError for a line shorter than two segments, or
/// closed than three.
Laying layOnCentreLines(Laying laying, const std::vector<CentreLine>& lines);

}  // namespace nanoweft
