/// The state file (HDF5): geometry input, snapshot, checkpoint and final state are one layout.
/// Rows are ordered by (fibre, index) whatever the number of ranks. src/manual/file_format.md has
/// the layout.
///
/// The SHA-256 of the whole file stands in its HDF5 user block, so a damaged file is refused on
/// reading; a file without it is one that a person made. Datasets carry HDF5's Fletcher-32 besides.
/// Files become visible under their name when they are complete.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "nanoweft/base/output_file.hpp"
#include "nanoweft/base/provenance.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft {

/// What a run keeps besides the particles (energy accounts, clocks of the boundary conditions):
/// attributes of the group /run, by name.
struct RunRecord {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
  std::map<std::string, std::string> texts;
  std::string source;  ///< file that it was read from; empty: none

  /// An attribute that a run cannot go on without. Throws InputError, naming file and attribute,
  /// when it is missing or has not `count` numbers.
  const std::vector<double>& needReals(const std::string& name, std::size_t count) const;
  const std::vector<std::int64_t>& needIntegers(const std::string& name, std::size_t count) const;
};

struct StateHeader {
  Box box;
  std::int64_t rows = 0, step = 0;
  double time = 0;
  std::string units = "nano";
  bool anyBroken = false;  ///< some bond is broken
  RunRecord run;
  std::string digest;     ///< SHA-256 of the whole file, as sha256sum prints it
  FileIdentity identity;  ///< of the file that was looked at
  /// Names behind the numbers of /state/kind, and of /link/kind; empty: none are given.
  std::vector<std::string> kinds, linkKinds;
  std::set<std::string> parts;  ///< names of what /state holds: datasets with content, step, time
  /// Of a file made by hand: what in it nobody reads, in words for people.
  std::vector<std::string> strange;
};

/// Whose hand a state file may come from.
enum class Trust {
  program,  ///< nanoweft's own files must be as nanoweft wrote them; others are made by hand
  edited,   ///< a person says that the file was changed on purpose: its digest is not compared
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
/// is missing, damaged, truncated or not a state file. Collective.
StateHeader readStateHeader(MPI_Comm comm, const std::string& file, Trust trust = Trust::program);

/// Reads the rows into the empty `state`, a block of rows to each rank, and wraps positions. Kinds
/// are those of State::kinds by their names. Throws InputError, naming the row, for values that
/// make no sense; the state is of no use then.
void readStateRows(const std::string& file, const StateHeader& header, State& state);

/// Writes the owned points of all ranks; rank 0 alone touches the file. Ghosts are ignored. Throws
/// RunError, with nothing changed, when the file cannot be written or its place has been taken
/// since `refuseForeignTarget` looked. `run.texts` holds the provenance. Collective.
void writeState(const std::string& file, State& state, const UnitSystem& units,
                const RunRecord& run, const StateWriteOptions& what = {});

/// Names of what /state holds at least in a run's file of a state with such fields: datasets, and
/// the attributes step and time.
std::vector<std::string> partsOfState(const ExtraFields& extras);

/// Why the file as a whole cannot be used as a state, or nothing. Not collective.
std::string stateFileProblem(const std::string& file, Trust trust = Trust::program);

// Keys of RunRecord::texts.
inline constexpr const char* programText = "program";
inline constexpr const char* versionText = "version";
inline constexpr const char* optionsText = "options";
inline constexpr const char* inputText = "input";
inline constexpr const char* purposeText = "purpose";
// What a file is for: the values of that text.
inline constexpr const char* checkpointPurpose = "checkpoint";
inline constexpr const char* finalPurpose = "final";
inline constexpr const char* snapshotPurpose = "snapshot";

/// The texts of a record that says where a file comes from, and back.
std::map<std::string, std::string> provenanceTexts(const Provenance& run,
                                                   const std::string& purpose);
Provenance provenanceOf(const RunRecord& record);

}  // namespace nanoweft
