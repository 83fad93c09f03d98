/// A monitor that records rows of numbers through a PETSc viewer chosen by an option:
///
///     -energy_monitor ascii:energy.csv     comma-separated file (or `ascii`: the terminal)
///     -energy_monitor draw                 line graph, live (-draw_pause, -draw_save as in PETSc)
#pragma once

#include <petscdraw.h>
#include <petscviewer.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "nanoweft/base/options.hpp"

namespace nanoweft {

class TableMonitor {
 public:
  /// `columns`: names after `step`; `curves`: which of them a line graph shows, over column
  /// `abscissa`.
  TableMonitor(Options& options, std::string option, const char* help,
               std::vector<std::string> columns, std::size_t abscissa,
               std::vector<std::size_t> curves);
  ~TableMonitor();
  TableMonitor(const TableMonitor&) = delete;
  TableMonitor& operator=(const TableMonitor&) = delete;

  bool wanted() const { return wanted_; }
  /// Where the table goes, empty when not into a file.
  std::string fileName() const;
  /// Throws InputError for a viewer that cannot hold a table, or a file that is there and is none.
  void check(MPI_Comm comm) const;
  /// Throws RunError when some row could not be written. Collective.
  void close();

  /// Opens the viewer. A file that exists is replaced, but in a restart its rows up to
  /// `restartStep` are kept (-1: no restart); `interval`: steps between rows. Collective.
  void open(MPI_Comm comm, std::int64_t restartStep, std::int64_t interval);
  void record(std::int64_t step, const std::vector<double>& values);

 private:
  /// The parts of the option's value, TYPE:FILE.
  std::array<std::string, 2> target() const;
  std::string header() const;

  std::string option_;
  std::vector<std::string> columns_;
  std::size_t abscissa_;
  std::vector<std::size_t> curves_;
  bool wanted_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  PetscViewer viewer_ = nullptr;
  PetscViewerFormat format_ = PETSC_VIEWER_DEFAULT;
  PetscDrawLG graph_ = nullptr;
};

}  // namespace nanoweft
