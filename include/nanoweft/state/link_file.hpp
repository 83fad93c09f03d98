/// The group /link of a state file:
///
///     segments     int64 [L,2,2]    (fibre, index) of each link's two ends
///     kind         int32 [L]        optional, 0; its attribute `kinds` names them
///     broken       int8 [L]         optional, 0
///     rest_length  float64 [L]      optional: as long as it is in the file
///     rest_frame   float64 [L,2,4]  optional: unit quaternions from each end's segment to the
///     link's
///                                   frame; by default both ends are at rest as they are
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/state/dataset_writer.hpp"
#include "nanoweft/state/kind_names.hpp"
#include "nanoweft/state/open_state.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// Numbers of the group as they stand in the file; read by every rank.
struct LinkRows {
  std::vector<std::int64_t> segments;  ///< [4]: fibre and index of both ends
  std::vector<std::int32_t> kind;
  std::vector<std::int8_t> broken;
  std::vector<double> length, frame;

  std::size_t count() const { return segments.size() / 4; }
};

/// Throws InputError for a group that cannot be used. Not collective.
LinkRows readLinkRows(const OpenState& file);

/// Gives the state its links once its rows are read, in blocks of rows in their order. Returns what
/// is wrong, on all ranks alike, or nothing. Collective.
std::string setLinks(State& state, const LinkRows& rows, const KindNumbers& kinds);

/// Writes the group, or nothing for a state without links; `group` makes it on rank 0. Collective.
void writeLinks(DatasetWriter& writer, const std::function<h5::Handle()>& group,
                const State& state);

}  // namespace nanoweft
