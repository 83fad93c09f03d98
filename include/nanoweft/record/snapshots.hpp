/// Snapshots: state files NAME_<step>.h5 with points, lines and fields for ParaView, and NAME.xdmf,
/// which lists them all over time.
#pragma once

#include <string>
#include <vector>

#include "nanoweft/base/units.hpp"
#include "nanoweft/state/output_target.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft {

class Snapshots {
 public:
  /// `name`: path without ending; in a restart (`restartStep` >= 0) earlier snapshots stay listed.
  Snapshots(MPI_Comm comm, std::string name, std::int64_t restartStep);
  /// Throws InputError when snapshots of this name would replace what is not this run's.
  static void check(MPI_Comm comm, const std::string& name, const ReplaceRule& rule);
  /// `run`: where the snapshot comes from.
  void write(State& state, const UnitSystem& units, const RunRecord& run,
             std::vector<SegmentField> fields);

 private:
  struct Entry {
    std::string file;
    double time;
    std::int64_t points, lines;
    std::vector<std::string> fields;  // in /field
  };
  void addEntry(const std::string& file);
  void writeIndex() const;

  std::string name_;
  std::vector<Entry> entries_;  // rank 0
};

}  // namespace nanoweft
