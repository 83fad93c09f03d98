/// Changing a state file as an outsider would, before a run starts from it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "nanoweft/base/vec.hpp"

namespace nanoweft::test {

/// Sets /state/NAME (rows of `columns` numbers) of a state file, whether it has one or not.
void setDataset(const std::string& file, const std::string& name, const std::vector<double>& values,
                int columns);
/// Gives the file a group /link: fibre and index of both ends of each link.
using LinkEnds = std::array<std::int64_t, 4>;
void setLinks(const std::string& file, const std::vector<LinkEnds>& links);
/// Gives these links kinds: a number each, and names with commas between them (empty: no names).
void setLinkKinds(const std::string& file, const std::vector<std::int32_t>& kinds,
                  const std::string& names);
/// Puts the digest of the changed file where nanoweft's was, so that it passes for nanoweft's own.
/// A file that never had one stays as it is.
void signAgain(const std::string& file);
/// Gives every segment the velocity `v(row, position)` and the angular velocity `w(row, position)`.
using VectorField = std::function<Vec3d(std::size_t row, const Vec3d& position)>;
void setMotion(const std::string& file, const VectorField& v, const VectorField& w);
/// Stops every segment.
void stopMotion(const std::string& file);
/// Turns all motion around, so that time runs back.
void reverseMotion(const std::string& file);

/// Rows of three numbers as vectors, rows of four as quaternions.
std::vector<Vec3d> readVectors(const std::string& file, const std::string& name);
std::vector<Quatd> readOrientations(const std::string& file);

}  // namespace nanoweft::test
