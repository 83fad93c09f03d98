/// A monitor writes rows of numbers where an option says, in PETSc's syntax of viewers:
///
///     -energy_monitor ascii:energy.csv     comma-separated file (or `ascii`: the terminal)
///     -energy_monitor draw                 line graph, live (-draw_pause, -draw_save as in PETSc)
///
/// nanoweft writes the files itself, through LockedFile, so that no row is lost.
#pragma once

#include <petscdraw.h>
#include <petscviewer.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nanoweft/base/locked_file.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/record/table_file.hpp"

namespace nanoweft {

/// What a table needs to know of the run that it belongs to.
struct TableRun {
  Provenance provenance;
  std::optional<Provenance>
      checkpoint;          ///< of the restart's checkpoint; its time step may be another one
  bool overwrite = false;  ///< tables of other runs may be replaced
  bool restart = false;
  bool ends = false;  ///< no step will be made
  std::int64_t step = 0;
  std::int64_t interval = 1;  ///< steps between rows

  bool owns(const Provenance& result) const {
    return result.sameRun(provenance) || (checkpoint && result.sameRun(*checkpoint));
  }
};

class TableMonitor {
 public:
  struct Layout {
    std::string option;
    const char* help;
    std::vector<std::string> columns;  ///< names after `step`
    std::size_t abscissa;              ///< column that a line graph is drawn over
    std::vector<std::size_t> curves;   ///< columns that it shows
  };
  TableMonitor(Options& options, Layout layout);
  ~TableMonitor();
  TableMonitor(const TableMonitor&) = delete;
  TableMonitor& operator=(const TableMonitor&) = delete;

  bool wanted() const { return wanted_; }
  const std::string& option() const { return layout_.option; }
  /// Where the table goes, empty when not into a file. Throws InputError for a viewer that cannot
  /// hold a table.
  std::string fileName() const;
  /// Throws InputError for such a viewer and for a file that must not be replaced. Changes nothing.
  /// Collective.
  void check(MPI_Comm comm, const TableRun& run) const;

  /// Takes the file for this run alone and looks at what there is: a restart goes on with the rows
  /// up to its step. Throws InputError when they are not whole. Collective.
  void claim(MPI_Comm comm, const TableRun& run);
  /// Begins or goes on with the table; `claim` must have been called. Throws InputError.
  /// Collective.
  void open();
  /// A table that holds no row yet.
  bool isNew() const { return wanted_ && last_ < 0; }
  /// What the user should know of the opened table, or nothing; on rank 0.
  const std::string& notice() const { return notice_; }

  /// Adds a row unless the table already has that of this step. Throws RunError. Collective.
  void record(std::int64_t step, const std::vector<double>& values);
  /// Returns when all rows are on the disk. Throws RunError. Collective.
  void sync();

 private:
  /// The parts of the option's value.
  struct Target {
    enum Kind { terminal, errors, graph, table } kind = terminal;
    std::string file;
  };
  Target target() const;
  std::string columnLine() const;
  /// Why the content of a file must not be replaced or gone on with.
  std::string refusal(const TableHead& head, const TableRun& run) const;
  void read(const TableRun& run);
  void openViewer();

  Layout layout_;
  bool wanted_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  PetscViewer viewer_ = nullptr;
  PetscViewerFormat format_ = PETSC_VIEWER_DEFAULT;
  PetscDrawLG graph_ = nullptr;

  // On rank 0, of a table in a file.
  std::unique_ptr<LockedFile> file_;
  TableHead head_;
  std::int64_t keptBegin_ = 0, keptEnd_ = 0;  ///< rows of the old content that stay, bytes
  std::string notice_;

  std::int64_t last_ = -1;  ///< step of the last row
};

}  // namespace nanoweft
