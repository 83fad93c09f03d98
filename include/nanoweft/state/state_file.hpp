/// The state file (HDF5): geometry input, snapshot, checkpoint and final state are one layout.
/// Rows are ordered by (fibre, index) whatever the number of ranks. The layout stands in README.md.
///
/// Every dataset carries HDF5's own Fletcher-32 checksum, so a damaged file is refused on reading.
/// Files are written under a temporary name and renamed when complete.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "nanoweft/base/units.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// What a run keeps besides the particles (energy accounts, clocks of the boundary conditions):
/// attributes of the group /run, by name.
struct RunRecord {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
  std::map<std::string, std::string> texts;
};

struct StateHeader {
  Box box;
  std::int64_t rows = 0, step = 0;
  double time = 0;
  std::string units = "nano";
  bool anyBroken = false;  ///< some bond is broken
  RunRecord run;
};

/// A number for each owned segment, to be written as /field/NAME (float32).
struct SegmentField {
  const char* name;
  std::vector<float> values;
};

struct StateWriteOptions {
  bool forces = false;               ///< write /state/force and /state/torque
  bool mesh = false;                 ///< write /mesh (points and lines) for ParaView
  std::vector<SegmentField> fields;  ///< write them to /field
};

/// Checks the file and reads all but the rows. Throws InputError, with the reason, for a file that
/// is missing, damaged, truncated or not a state file.
StateHeader readStateHeader(MPI_Comm comm, const std::string& file);

/// Reads the rows into the empty `state`, a block of rows to each rank, and wraps positions.
/// Throws InputError, naming the row, for values that make no sense.
void readStateRows(const std::string& file, const StateHeader& header, State& state);

/// Writes the owned points of all ranks. Ghosts are ignored. Throws RunError.
void writeState(const std::string& file, State& state, const UnitSystem& units,
                const RunRecord& run, const StateWriteOptions& what = {});

/// Why the file as a whole cannot be used as a state, or nothing. Not collective.
std::string stateFileProblem(const std::string& file);

}  // namespace nanoweft
