/// Snapshots: state files NAME_<step>.h5 with points, lines and fields for ParaView, and NAME.xdmf,
/// which lists them all over time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/locked_file.hpp"
#include "nanoweft/base/provenance.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/state/output_target.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

class Snapshots {
 public:
  struct Setting {
    std::string name;                      ///< path without ending
    ReplaceRule rule;                      ///< what the run may replace
    std::optional<Provenance> checkpoint;  ///< of what a restart goes on from
    std::int64_t restartStep = -1;         ///< -1: the run is no restart

    bool owns(const Provenance& result) const {
      return result.sameRun(rule.run) || (checkpoint && result.sameRun(*checkpoint));
    }
  };

  /// Throws InputError for a name that no index can hold, and when snapshots of this name would
  /// stand among files that another run has written. Changes nothing. Collective.
  static void check(MPI_Comm comm, const Setting& setting);

  /// Takes the index for this run alone; a restart finds the snapshots of its run up to its step.
  /// Throws InputError. Collective.
  Snapshots(MPI_Comm comm, Setting setting);
  /// A restart makes the index anew. Throws RunError. Collective.
  void begin();
  /// Writes a snapshot and adds it to the index. `run`: what the file says of the run in /run.
  /// Throws RunError. Collective.
  void write(State& state, const UnitSystem& units, const RunRecord& run,
             std::vector<SegmentField> fields);
  /// Warns of snapshots of another run that stand beside those written here. On rank 0 alone.
  void warnOfOthers() const;

  /// Could `file` be one of the files that snapshots of this name make?
  static bool makes(const std::string& name, const std::string& file);

 private:
  struct Entry {
    std::string file;
    double time;
    std::int64_t points, lines;
    std::vector<std::string> fields;  // in /field
    bool kinds;                       // it has /state/kind
  };
  void addEntry(const std::string& file);
  std::string indexText() const;
  void writeIndex();

  MPI_Comm comm_;
  Setting setting_;
  // On rank 0.
  std::unique_ptr<LockedFile> index_;
  std::vector<Entry> entries_;
};

}  // namespace nanoweft
