#include "nanoweft/record/table_monitor.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "nanoweft/base/error.hpp"
#include "nanoweft/state/output_target.hpp"

namespace nanoweft {

TableMonitor::TableMonitor(Options& options, std::string option, const char* help,
                           std::vector<std::string> columns, std::size_t abscissa,
                           std::vector<std::size_t> curves)
    : option_(std::move(option)),
      columns_(std::move(columns)),
      abscissa_(abscissa),
      curves_(std::move(curves)) {
  OptionSection s(options, "Output");
  s.document(option_, "none", "", help);
  wanted_ = s.given(option_);
}

TableMonitor::~TableMonitor() {
  PetscDrawLGDestroy(&graph_);
  PetscViewerDestroy(&viewer_);
}

std::array<std::string, 2> TableMonitor::target() const {
  char text[PETSC_MAX_PATH_LEN] = "";
  PetscBool found;
  petsc(
      PetscOptionsGetString(nullptr, nullptr, ("-" + option_).c_str(), text, sizeof text, &found));
  std::istringstream parts(text);
  std::array<std::string, 2> result;
  for (std::string& part : result) std::getline(parts, part, ':');
  return result;
}

std::string TableMonitor::fileName() const {
  const auto [type, file] = target();
  return type == "ascii" ? file : "";
}

void TableMonitor::check(MPI_Comm comm) const {
  if (!wanted_) return;
  const auto [type, file] = target();
  if (!type.empty() && type != "ascii" && type != "draw")
    throw InputError(
        format("-%s %s: the viewer must be ascii or draw", option_.c_str(), type.c_str()));
  if (type == "draw" || file.empty()) return;
  makeParentFolder(comm, file);
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string problem;
  if (rank == 0 && std::filesystem::is_directory(file)) {
    problem = format("-%s: %s is a folder", option_.c_str(), file.c_str());
  } else if (rank == 0 && std::filesystem::is_regular_file(file)) {
    std::ifstream old(file);
    std::string line;
    std::getline(old, line);
    if (!line.empty() && line + "\n" != header())
      problem =
          format("will not overwrite %s: it is no table of -%s; remove it or choose another name",
                 file.c_str(), option_.c_str());
  }
  agree<InputError>(comm, problem);
}

void TableMonitor::close() {
  if (!viewer_ || graph_) return;
  FILE* stream = nullptr;
  petsc(PetscViewerASCIIGetPointer(viewer_, &stream));
  agree<RunError>(comm_, stream && std::ferror(stream)
                             ? format("-%s: some rows could not be written (is the disk full?)",
                                      option_.c_str())
                             : "");
}

std::string TableMonitor::header() const {
  std::string line = "step";
  for (const std::string& c : columns_) line += "," + c;
  return line + "\n";
}

void TableMonitor::open(MPI_Comm comm, std::int64_t restartStep, std::int64_t interval) {
  if (!wanted_) return;
  comm_ = comm;
  int rank;
  MPI_Comm_rank(comm, &rank);
  const std::string file = fileName();
  std::string kept = header();
  if (!file.empty()) {
    std::string problem;
    if (rank == 0) {
      if (std::ifstream old(file); old && restartStep >= 0) {
        std::string line;
        std::getline(old, line);
        if (line + "\n" == header())
          while (std::getline(old, line)) {
            const std::int64_t step = std::atoll(line.c_str());
            // The closing row of the earlier piece is none of the whole run's.
            const bool closing = step == restartStep && step % interval != 0;
            if (!line.empty() && step <= restartStep && !closing) kept += line + "\n";
          }
      }
      if (!std::ofstream(file, std::ios::app))
        problem = format("-%s: cannot write %s", option_.c_str(), file.c_str());
    }
    agree<InputError>(comm, problem);
  }
  PetscBool found;
  try {
    petsc(PetscOptionsGetViewer(comm, nullptr, nullptr, ("-" + option_).c_str(), &viewer_, &format_,
                                &found));
  } catch (const PetscFailure& failure) {
    throw InputError(format("-%s: %s", option_.c_str(), failure.what()));
  }
  PetscBool draw;
  petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer_), PETSCVIEWERDRAW, &draw));
  if (!draw) {
    petsc(PetscViewerASCIIPrintf(viewer_, "%s", kept.c_str()));
    petsc(PetscViewerFlush(viewer_));
  } else {
    PetscDraw canvas;
    petsc(PetscViewerDrawGetDraw(viewer_, 0, &canvas));
    petsc(PetscDrawLGCreate(canvas, static_cast<PetscInt>(curves_.size()), &graph_));
    PetscDrawAxis axis;
    petsc(PetscDrawLGGetAxis(graph_, &axis));
    petsc(PetscDrawAxisSetLabels(axis, option_.c_str(), columns_[abscissa_].c_str(), ""));
    std::vector<const char*> names;
    for (std::size_t c : curves_) names.push_back(columns_[c].c_str());
    petsc(PetscDrawLGSetLegend(graph_, names.data()));
  }
}

void TableMonitor::record(std::int64_t step, const std::vector<double>& values) {
  if (!viewer_) return;
  if (graph_) {
    std::vector<PetscReal> x(curves_.size(), values[abscissa_]), y;
    for (std::size_t c : curves_) y.push_back(values[c]);
    petsc(PetscDrawLGAddPoint(graph_, x.data(), y.data()));
    petsc(PetscDrawLGDraw(graph_));
    petsc(PetscDrawLGSave(graph_));
    return;
  }
  std::string line = std::to_string(step);
  for (double v : values) line += format(",%.17g", v);
  petsc(PetscViewerASCIIPrintf(viewer_, "%s\n", line.c_str()));
  petsc(PetscViewerFlush(viewer_));
}

}  // namespace nanoweft
