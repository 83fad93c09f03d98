#include "nanoweft/record/snapshots.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <sstream>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/record/xml.hpp"
#include "nanoweft/state/output_target.hpp"

namespace nanoweft {

namespace fs = std::filesystem;

namespace {

constexpr const char* indexMark = "<Grid Name=\"fibres\" GridType=\"Collection\"";
constexpr const char* xmlHead = "<?xml version=\"1.0\"?>\n";
/// Bytes of an index that are looked at to learn whose it is.
constexpr std::size_t indexHead = 1 << 20;
constexpr std::int64_t anyStep = std::numeric_limits<std::int64_t>::max();

/// The step in a file name PREFIX<ten digits>.h5, or -1.
std::int64_t stepInName(const std::string& leaf, const std::string& prefix) {
  if (!leaf.starts_with(prefix) || !leaf.ends_with(".h5") || leaf.size() != prefix.size() + 13)
    return -1;
  const std::string number = leaf.substr(prefix.size(), 10);
  return number.find_first_not_of("0123456789") == std::string::npos ? std::stoll(number) : -1;
}

fs::path folderOf(const std::string& name) {
  const fs::path folder = fs::path(name).parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

/// Files NAME_<number>.h5 with numbers above `after` and up to `last`, in order.
std::vector<std::string> numberedFiles(const std::string& name, std::int64_t after,
                                       std::int64_t last) {
  const std::string prefix = fs::path(name).filename().string() + "_";
  std::vector<std::string> files;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folderOf(name), code)) {
    const std::string leaf = entry.path().filename().string();
    const std::int64_t step = stepInName(leaf, prefix);
    if (step > after && step <= last)
      files.push_back((fs::path(name).parent_path() / leaf).string());
  }
  std::ranges::sort(files);
  return files;
}

/// Where a state file comes from; nothing when it is none.
std::optional<Provenance> provenanceIn(const std::string& file) {
  std::error_code code;
  if (!fs::is_regular_file(file, code)) return std::nullopt;
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!f.valid() || H5Lexists(f, "state", H5P_DEFAULT) <= 0) return std::nullopt;
  Provenance result;
  if (H5Lexists(f, "run", H5P_DEFAULT) <= 0) return result;
  h5::Handle run(H5Gopen2(f, "run", H5P_DEFAULT), H5Gclose);
  if (!run.valid()) return result;
  auto text = [&](const char* name) { return h5::readText(run, name).value_or(""); };
  result.program = text("program");
  result.version = text("version");
  result.options = text("options");
  result.input = text("input");
  return result;
}

/// Names of the datasets in a group of a file; none when it has no such group.
std::vector<std::string> namesIn(hid_t file, const char* group) {
  std::vector<std::string> names;
  if (H5Lexists(file, group, H5P_DEFAULT) <= 0) return names;
  h5::Handle g(H5Gopen2(file, group, H5P_DEFAULT), H5Gclose);
  auto note = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  H5Literate(g, H5_INDEX_NAME, H5_ITER_INC, nullptr, note, &names);
  return names;
}

/// Rows of a dataset with two dimensions, or -1.
std::int64_t rowsOf(hid_t file, const char* name) {
  h5::Handle set(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
  if (!set.valid()) return -1;
  h5::Handle space(H5Dget_space(set), H5Sclose);
  hsize_t shape[2];
  if (H5Sget_simple_extent_ndims(space) != 2) return -1;
  H5Sget_simple_extent_dims(space, shape, nullptr);
  return static_cast<std::int64_t>(shape[0]);
}

/// Why no index can hold the names of such snapshots, or nothing.
std::string problemOfName(const std::string& name) {
  const std::string leaf = fs::path(name).filename().string();
  if (leaf.empty()) return "is the name of a folder; a file name must follow";
  if (!isXmlText(leaf)) return "has a character that XML cannot hold";
  // Readers of XDMF take FILE:DATASET|SELECTION apart and cut blanks off its beginning.
  if (leaf.find_first_of(":|") != std::string::npos || leaf[0] == ' ')
    return "ParaView's readers cannot open files with ':', '|' or a leading blank in their name";
  return "";
}

std::string beginningOf(int descriptor) {
  std::string text(indexHead, '\0');
  const ssize_t got = ::pread(descriptor, text.data(), text.size(), 0);
  text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return text;
}

/// Why an index with this beginning must not be replaced, or nothing.
std::string problemOfIndex(const std::string& text, const Snapshots::Setting& setting) {
  const std::string file = setting.name + ".xdmf";
  if (text.empty()) return "";
  if (text.find(indexMark) == std::string::npos)
    return "will not replace " + file +
           ": it is no index of snapshots; remove it or choose another name";
  if (setting.rule.overwrite) return "";
  const std::string another =
      "will not replace " + file +
      ": another run wrote it; choose another -snapshot_file (or -overwrite)";
  if (!text.starts_with(xmlHead)) return another;
  const std::string comment = text.substr(std::string(xmlHead).size());
  // Both are compared as an index holds them, since XML cannot hold every character.
  auto held = [](const Provenance& p) {
    std::istringstream lines(xmlCommentIn(xmlComment(p.tableHead())));
    return Provenance::fromTable(lines).value_or(Provenance{});
  };
  Snapshots::Setting ours = setting;
  ours.rule.run = held(setting.rule.run);
  if (setting.checkpoint) ours.checkpoint = held(*setting.checkpoint);
  std::istringstream lines(xmlCommentIn(comment));
  const auto theirs = Provenance::fromTable(lines);
  return theirs && ours.owns(*theirs) ? "" : another;
}

/// Why snapshots that are there forbid a run to write its own, or nothing.
std::string problemOfOthers(const Snapshots::Setting& setting) {
  if (setting.rule.overwrite) return "";
  for (const std::string& file : numberedFiles(setting.name, -1, anyStep))
    if (const auto theirs = provenanceIn(file); theirs && !setting.owns(*theirs))
      return "snapshots of another run are there, such as " + file +
             "; choose another -snapshot_file (or -overwrite)";
  return "";
}

std::string indexProblem(const Snapshots::Setting& setting) {
  const std::string file = setting.name + ".xdmf";
  std::error_code code;
  if (!fs::exists(file, code)) return "";
  if (!fs::is_regular_file(file, code)) return "cannot write " + file + ": it is no regular file";
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return "";
  const std::string text = beginningOf(fd);
  ::close(fd);
  return problemOfIndex(text, setting);
}

/// All ranks get the lines that rank 0 has.
std::vector<std::string> shared(MPI_Comm comm, const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\0';
  auto length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm);
  text.resize(static_cast<std::size_t>(length));
  MPI_Bcast(text.data(), length, MPI_CHAR, 0, comm);
  std::vector<std::string> result;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line, '\0');) result.push_back(line);
  return result;
}

}  // namespace

bool Snapshots::makes(const std::string& name, const std::string& file) {
  if (isSameFile(name + ".xdmf", file)) return true;
  const fs::path target = throughLinks(file);
  return stepInName(target.filename().string(), fs::path(name).filename().string() + "_") >= 0 &&
         isSameFile(folderOf(name).string(), folderOf(target.string()).string());
}

void Snapshots::check(MPI_Comm comm, const Setting& setting) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string problem;
  if (const std::string why = problemOfName(setting.name); !why.empty())
    problem = "-snapshot_file " + printable(setting.name) + ": " + why;
  agree<InputError>(comm, problem);
  makeParentFolder(comm, setting.name);
  std::vector<std::string> files;
  if (rank == 0) {
    problem = problemOfOthers(setting);
    if (problem.empty()) problem = indexProblem(setting);
    files = numberedFiles(setting.name, setting.restartStep, anyStep);
  }
  agree<InputError>(comm, problem);
  // Those that may be replaced; all ranks ask about the same ones.
  for (const std::string& file : shared(comm, files)) refuseForeignTarget(comm, file, setting.rule);
  requireWritable(comm, setting.name + "_0000000000.h5");
  requireWritable(comm, setting.name + ".xdmf");
}

Snapshots::Snapshots(MPI_Comm comm, Setting setting) : comm_(comm), setting_(std::move(setting)) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string problem;
  if (rank == 0) {
    try {
      index_ = std::make_unique<LockedFile>(setting_.name + ".xdmf");
      if (!index_->isDevice())
        problem = problemOfIndex(beginningOf(index_->descriptor()), setting_);
    } catch (const std::exception& failure) {
      problem = failure.what();
    }
  }
  agree<InputError>(comm, problem);
  if (rank != 0 || setting_.restartStep < 0) return;
  for (const std::string& file : numberedFiles(setting_.name, -1, setting_.restartStep))
    if (const auto theirs = provenanceIn(file); theirs && setting_.owns(*theirs)) addEntry(file);
}

void Snapshots::begin() {
  if (setting_.restartStep >= 0) writeIndex();
}

void Snapshots::addEntry(const std::string& file) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!f.valid() || H5Lexists(f, "mesh", H5P_DEFAULT) <= 0) return;
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  const auto time = h5::readReals(group, "time");
  const std::int64_t points = rowsOf(f, "mesh/points"), lines = rowsOf(f, "mesh/lines");
  if (!time || time->empty() || points < 0 || lines < 0) return;
  const std::string name = fs::path(file).filename().string();
  std::erase_if(entries_, [&](const Entry& e) { return e.file == name; });
  entries_.push_back({name, (*time)[0], points, lines, namesIn(f, "field"),
                      H5Lexists(group, "kind", H5P_DEFAULT) > 0});
}

void Snapshots::write(State& state, const UnitSystem& units, const RunRecord& run,
                      std::vector<SegmentField> fields) {
  const std::string file =
      format("%s_%010lld.h5", setting_.name.c_str(), static_cast<long long>(state.step));
  StateWriteOptions what;
  what.mesh = true;
  what.fields = std::move(fields);
  writeState(file, state, units, run, what);
  if (state.rank() == 0) addEntry(file);
  writeIndex();
}

void Snapshots::warnOfOthers() const {
  // Without -overwrite the run would not have begun among them.
  if (!index_ || !setting_.rule.overwrite) return;
  std::vector<std::string> others = numberedFiles(setting_.name, setting_.restartStep, anyStep);
  std::erase_if(others, [&](const std::string& file) {
    const auto theirs = provenanceIn(file);
    return !theirs || setting_.owns(*theirs);
  });
  if (others.empty()) return;
  PetscPrintf(PETSC_COMM_SELF,
              "warning: snapshots of another run are still there, since -overwrite replaces those "
              "of the same steps alone: %s%s (%zu of them; %s.xdmf lists this run's own)\n",
              others.front().c_str(), others.size() > 1 ? (" to " + others.back()).c_str() : "",
              others.size(), setting_.name.c_str());
}

void Snapshots::writeIndex() {
  std::string problem;
  if (index_) {
    try {
      index_->replace(indexText());
    } catch (const std::exception& failure) {
      problem = failure.what();
    }
  }
  agree<RunError>(comm_, problem);
}

std::string Snapshots::indexText() const {
  std::ostringstream out;
  out << xmlHead << xmlComment(setting_.rule.run.tableHead())
      << "<Xdmf Version=\"3.0\">\n<Domain>\n"
      << indexMark << " CollectionType=\"Temporal\">\n";
  auto item = [&](const Entry& e, const std::string& dataset, std::int64_t rows, int columns,
                  const char* type, int bytes) {
    return format(
        "<DataItem Format=\"HDF\" NumberType=\"%s\" Precision=\"%d\" "
        "Dimensions=\"%lld%s\">%s:%s</DataItem>",
        type, bytes, static_cast<long long>(rows),
        columns > 1 ? format(" %d", columns).c_str() : "", xmlEscaped(e.file).c_str(),
        xmlEscaped(dataset).c_str());
  };
  for (const Entry& e : entries_) {
    out << format("<Grid Name=\"%s\">\n<Time Value=\"%.17g\"/>\n", xmlEscaped(e.file).c_str(),
                  e.time)
        << format(
               "<Topology TopologyType=\"Polyline\" NodesPerElement=\"2\" "
               "NumberOfElements=\"%lld\">",
               static_cast<long long>(e.lines))
        << item(e, "/mesh/lines", e.lines, 2, "Int", 4)
        << "</Topology>\n<Geometry GeometryType=\"XYZ\">"
        << item(e, "/mesh/points", e.points, 3, "Float", 4) << "</Geometry>\n";
    auto attribute = [&](const std::string& group, const std::string& name, const char* kind,
                         int columns, const char* type, int bytes) {
      out << format("<Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">",
                    xmlEscaped(name).c_str(), kind)
          << item(e, group + name, e.points, columns, type, bytes) << "</Attribute>\n";
    };
    attribute("/state/", "velocity", "Vector", 3, "Float", 8);
    attribute("/state/", "fibre", "Scalar", 1, "Int", 8);
    attribute("/state/", "group", "Scalar", 1, "Int", 4);
    attribute("/state/", "bond_broken", "Scalar", 1, "Char", 1);
    if (e.kinds) attribute("/state/", "kind", "Scalar", 1, "Int", 4);
    for (const std::string& name : e.fields) attribute("/field/", name, "Scalar", 1, "Float", 4);
    out << "</Grid>\n";
  }
  out << "</Grid>\n</Domain>\n</Xdmf>\n";
  return out.str();
}

}  // namespace nanoweft
