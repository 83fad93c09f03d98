#include "nanoweft/record/table_monitor.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "nanoweft/base/error.hpp"
#include "nanoweft/state/output_target.hpp"

namespace nanoweft {

namespace {

int rankIn(MPI_Comm comm) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

/// Does `work` and returns why it could not be done, or nothing.
template <class Work>
std::string problemOf(const Work& work) {
  try {
    work();
    return "";
  } catch (const std::exception& failure) {
    return failure.what();
  }
}

std::vector<std::string> split(const std::string& text, char mark) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == mark)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

}  // namespace

TableMonitor::TableMonitor(Options& options, Layout layout) : layout_(std::move(layout)) {
  OptionSection s = OptionSection(options, "Output").as(Role::run);
  s.document(layout_.option, "none", "", layout_.help);
  wanted_ = s.given(layout_.option);
}

TableMonitor::~TableMonitor() {
  PetscDrawLGDestroy(&graph_);
  PetscViewerDestroy(&viewer_);
}

TableMonitor::Target TableMonitor::target() const {
  char text[2 * PETSC_MAX_PATH_LEN] = "";
  PetscBool found;
  petsc(PetscOptionsGetString(nullptr, nullptr, ("-" + layout_.option).c_str(), text, sizeof text,
                              &found));
  const std::string given = "-" + layout_.option + " " + text;
  // type[:name[:format[:mode]]]
  auto parts = split(text, ':');
  if (parts[0] == "draw") return {Target::graph, ""};
  if (!parts[0].empty() && parts[0] != "ascii")
    throw InputError(given + ": the viewer must be ascii or draw, as in ascii:" +
                     (parts.size() == 1 ? parts[0] : "FILE.csv"));
  const std::size_t count = parts.size();
  parts.resize(std::max<std::size_t>(count, 4));
  const std::string &name = parts[1], &shape = parts[2], &mode = parts[3];
  if (count > 4 || (!shape.empty() && shape != "default"))
    throw InputError(given + ": expected ascii:FILE.csv, with no ':' in the name");
  if (!mode.empty() && mode != "write")
    throw InputError(given + ": a table can be opened by write, not by " + mode);
  if (name.ends_with(".gz"))
    throw InputError(given + ": tables are not compressed; choose a name without .gz");
  if (name.empty() || name == "stdout" || name == "/dev/stdout") return {};
  if (name == "stderr" || name == "/dev/stderr") return {Target::errors, ""};
  return {Target::table, name};
}

std::string TableMonitor::fileName() const {
  return wanted_ ? target().file : "";
}

std::string TableMonitor::columnLine() const {
  std::string line = "step";
  for (const std::string& c : layout_.columns) line += "," + c;
  return line;
}

std::string TableMonitor::refusal(const TableHead& head, const TableRun& run) const {
  const std::string will = "will not replace " + target().file + ": ",
                    none = "it is no table of -" + layout_.option,
                    orOverwrite = "; remove it, choose another name or give -overwrite";
  const bool ours = head.provenance && head.provenance->program == run.provenance.program,
             same = head.columns == columnLine(), table = !ours || !head.stretches.empty();
  if (ours && table && same && run.owns(*head.provenance)) return "";
  if ((ours || same) && run.overwrite) return "";
  if (ours && table && !same) return will + none + " with the columns of this run" + orOverwrite;
  if (!same || !table) return will + none + "; remove it or choose another name";
  const std::string why = ours ? differenceOfRuns(*head.provenance, run.provenance) : "";
  return will + "another run wrote it" + (why.empty() ? "" : " (" + why + ")") + orOverwrite;
}

void TableMonitor::check(MPI_Comm comm, const TableRun& run) const {
  if (!wanted_) return;
  const std::string file = target().file;
  if (file.empty()) return;
  makeParentFolder(comm, file);
  std::string problem;
  struct stat there;
  // Only a regular file is opened: to open a FIFO would wait for its other end.
  if (rankIn(comm) == 0 && ::stat(file.c_str(), &there) == 0) {
    if (S_ISREG(there.st_mode) && there.st_size > 0) {
      if (const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); fd >= 0) {
        problem = refusal(readTableHead(fd), run);
        ::close(fd);
      }
    } else if (!S_ISREG(there.st_mode) && !S_ISCHR(there.st_mode)) {
      problem = format("-%s: cannot write %s: it is %s", layout_.option.c_str(), file.c_str(),
                       S_ISDIR(there.st_mode) ? "a folder" : "no regular file");
    }
  }
  agree<InputError>(comm, problem);
}

/// Reads the table that is in the file and notes which of its rows this run keeps.
void TableMonitor::read(const TableRun& run) {
  const std::string& name = file_->name();
  TableHead old;
  if (!file_->isDevice() && file_->size() > 0) {
    old = readTableHead(file_->descriptor());
    if (const std::string why = refusal(old, run); !why.empty()) throw std::runtime_error(why);
  }
  head_.provenance = run.provenance;
  head_.columns = columnLine();
  head_.stretches = {{run.interval, run.step}};
  if (!run.restart || file_->isDevice()) return;
  const bool goesOn = old.provenance && run.owns(*old.provenance) && !old.stretches.empty() &&
                      old.columns == head_.columns;
  if (!goesOn) {
    notice_ = format(
        "warning: there are no earlier rows of this run in %s; its table begins at step %lld",
        name.c_str(), static_cast<long long>(run.step));
    return;
  }
  const TableRows rows = checkTableRows(file_->descriptor(), old, run.step, run.ends);
  if (!rows.problem.empty())
    throw std::runtime_error(name + ", " + rows.problem +
                             "; restore the table, or give the monitor another name");
  if (rows.last < 0) return;
  while (old.stretches.back().begin >= run.step && old.stretches.size() > 1)
    old.stretches.pop_back();
  if (old.stretches.back().begin == run.step)
    old.stretches.back().interval = run.interval;
  else if (old.stretches.back().interval != run.interval)
    old.stretches.push_back({run.interval, run.step});
  head_.stretches = old.stretches;
  keptBegin_ = old.end;
  keptEnd_ = rows.end;
  last_ = rows.last;
}

void TableMonitor::claim(MPI_Comm comm, const TableRun& run) {
  if (!wanted_) return;
  comm_ = comm;
  const Target where = target();
  if (where.kind != Target::table) return;
  std::string problem;
  if (rankIn(comm) == 0)
    problem = problemOf([&] {
      file_ = std::make_unique<LockedFile>(where.file);
      read(run);
    });
  agree<InputError>(comm, problem.empty() ? "" : "-" + layout_.option + ": " + problem);
  MPI_Bcast(&last_, 1, MPI_INT64_T, 0, comm);
}

void TableMonitor::open() {
  if (!wanted_) return;
  if (target().kind != Target::table) return openViewer();
  std::string problem;
  if (file_) problem = problemOf([&] { file_->replace(head_.text(), keptBegin_, keptEnd_); });
  agree<InputError>(comm_, problem.empty() ? "" : "-" + layout_.option + ": " + problem);
}

void TableMonitor::openViewer() {
  const Target::Kind kind = target().kind;
  if (kind != Target::graph) {
    auto get = kind == Target::errors ? PetscViewerASCIIGetStderr : PetscViewerASCIIGetStdout;
    petsc(get(comm_, &viewer_));
    petsc(PetscObjectReference(reinterpret_cast<PetscObject>(viewer_)));
    petsc(PetscViewerASCIIPrintf(viewer_, "%s\n", columnLine().c_str()));
    return;
  }
  PetscBool found;
  try {
    petsc(PetscOptionsGetViewer(comm_, nullptr, nullptr, ("-" + layout_.option).c_str(), &viewer_,
                                &format_, &found));
  } catch (const PetscFailure& failure) {
    throw InputError(format("-%s: %s", layout_.option.c_str(), failure.what()));
  }
  PetscDraw canvas;
  petsc(PetscViewerDrawGetDraw(viewer_, 0, &canvas));
  petsc(PetscDrawLGCreate(canvas, static_cast<PetscInt>(layout_.curves.size()), &graph_));
  PetscDrawAxis axis;
  petsc(PetscDrawLGGetAxis(graph_, &axis));
  petsc(PetscDrawAxisSetLabels(axis, layout_.option.c_str(),
                               layout_.columns[layout_.abscissa].c_str(), ""));
  std::vector<const char*> names;
  for (std::size_t c : layout_.curves) names.push_back(layout_.columns[c].c_str());
  petsc(PetscDrawLGSetLegend(graph_, names.data()));
}

void TableMonitor::record(std::int64_t step, const std::vector<double>& values) {
  if (!wanted_ || step <= last_) return;
  last_ = step;
  if (graph_) {
    std::vector<PetscReal> x(layout_.curves.size(), values[layout_.abscissa]), y;
    for (std::size_t c : layout_.curves) y.push_back(values[c]);
    petsc(PetscDrawLGAddPoint(graph_, x.data(), y.data()));
    petsc(PetscDrawLGDraw(graph_));
    petsc(PetscDrawLGSave(graph_));
    return;
  }
  std::string line = std::to_string(step);
  for (double v : values) line += format(",%.17g", v);
  std::string problem;
  if (viewer_) {
    petsc(PetscViewerASCIIPrintf(viewer_, "%s\n", line.c_str()));
    petsc(PetscViewerFlush(viewer_));
    FILE* stream = nullptr;
    petsc(PetscViewerASCIIGetPointer(viewer_, &stream));
    if (stream && std::ferror(stream)) problem = "a row could not be written";
  } else if (file_) {
    problem = problemOf([&] { file_->append(line + "\n"); });
  }
  agree<RunError>(comm_, problem.empty() ? "" : "-" + layout_.option + ": " + problem);
}

void TableMonitor::sync() {
  if (!wanted_ || viewer_) return;
  const std::string problem = file_ ? problemOf([&] { file_->sync(); }) : "";
  agree<RunError>(comm_, problem.empty() ? "" : "-" + layout_.option + ": " + problem);
}

}  // namespace nanoweft
