#include "nanoweft/record/snapshots.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"

namespace nanoweft {

namespace fs = std::filesystem;

namespace {

/// Files NAME_<number>.h5 with numbers up to `last`, in order.
std::vector<std::string> numberedFiles(const std::string& name, std::int64_t last) {
  const fs::path path(name);
  const fs::path folder = path.parent_path().empty() ? fs::path(".") : path.parent_path();
  const std::string prefix = path.filename().string() + "_";
  std::vector<std::string> files;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const std::string file = entry.path().filename().string();
    if (!file.starts_with(prefix) || !file.ends_with(".h5")) continue;
    const std::string number = file.substr(prefix.size(), file.size() - prefix.size() - 3);
    if (number.size() != 10 || number.find_first_not_of("0123456789") != std::string::npos)
      continue;
    if (std::stoll(number) <= last) files.push_back((folder / file).string());
  }
  std::ranges::sort(files);
  return files;
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

constexpr const char* indexMark = "<Grid Name=\"fibres\" GridType=\"Collection\"";

}  // namespace

void Snapshots::check(MPI_Comm comm, const std::string& name, const ReplaceRule& rule) {
  makeParentFolder(comm, name);
  int rank;
  MPI_Comm_rank(comm, &rank);
  // All ranks ask about the same files, in the order that rank 0 finds.
  std::string list;
  if (rank == 0)
    for (const std::string& file : numberedFiles(name, std::numeric_limits<std::int64_t>::max()))
      list += file + "\n";
  auto length = static_cast<int>(list.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm);
  list.resize(static_cast<std::size_t>(length));
  MPI_Bcast(list.data(), length, MPI_CHAR, 0, comm);
  std::istringstream files(list);
  for (std::string file; std::getline(files, file);) refuseForeignTarget(comm, file, rule);
  requireWritable(comm, name + "_0000000000.h5");
  requireWritable(comm, name + ".xdmf");
  std::string problem;
  if (std::ifstream index(name + ".xdmf"); rank == 0 && index) {
    std::ostringstream text;
    text << index.rdbuf();
    if (text.str().find(indexMark) == std::string::npos)
      problem = "will not overwrite " + name +
                ".xdmf: it is no index of snapshots; remove it or choose another name";
  }
  agree<InputError>(comm, problem);
}

Snapshots::Snapshots(MPI_Comm comm, std::string name, std::int64_t restartStep)
    : name_(std::move(name)) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  if (rank == 0)
    for (const std::string& file : numberedFiles(name_, restartStep)) addEntry(file);
}

void Snapshots::addEntry(const std::string& file) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!f.valid() || H5Lexists(f, "mesh", H5P_DEFAULT) <= 0) return;
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  const auto time = h5::readReals(group, "time");
  hsize_t points[2], lines[2];
  h5::Handle p(H5Dopen2(f, "mesh/points", H5P_DEFAULT), H5Dclose),
      l(H5Dopen2(f, "mesh/lines", H5P_DEFAULT), H5Dclose);
  h5::Handle ps(H5Dget_space(p), H5Sclose), ls(H5Dget_space(l), H5Sclose);
  H5Sget_simple_extent_dims(ps, points, nullptr);
  H5Sget_simple_extent_dims(ls, lines, nullptr);
  const std::string name = fs::path(file).filename().string();
  std::erase_if(entries_, [&](const Entry& e) { return e.file == name; });
  entries_.push_back({name, time ? (*time)[0] : 0.0, static_cast<std::int64_t>(points[0]),
                      static_cast<std::int64_t>(lines[0]), namesIn(f, "field")});
}

void Snapshots::write(State& state, const UnitSystem& units, const RunRecord& run,
                      std::vector<SegmentField> fields) {
  const std::string file =
      format("%s_%010lld.h5", name_.c_str(), static_cast<long long>(state.step));
  StateWriteOptions what;
  what.mesh = true;
  what.fields = std::move(fields);
  writeState(file, state, units, run, what);
  std::string problem;
  if (state.rank() == 0) {
    addEntry(file);
    try {
      writeIndex();
    } catch (const std::exception& failure) {
      problem = failure.what();
    }
  }
  agree<RunError>(state.comm(), problem);
}

void Snapshots::writeIndex() const {
  const std::string index = name_ + ".xdmf", temporary = index + ".tmp";
  {
    std::ofstream out(temporary);
    out << "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
        << indexMark << " CollectionType=\"Temporal\">\n";
    auto item = [&](const Entry& e, const char* dataset, std::int64_t rows, int columns,
                    const char* type, int bytes) {
      return format(
          "<DataItem Format=\"HDF\" NumberType=\"%s\" Precision=\"%d\" "
          "Dimensions=\"%lld%s\">%s:%s</DataItem>",
          type, bytes, static_cast<long long>(rows),
          columns > 1 ? format(" %d", columns).c_str() : "", e.file.c_str(), dataset);
    };
    for (const Entry& e : entries_) {
      out << format("<Grid Name=\"%s\">\n<Time Value=\"%.17g\"/>\n", e.file.c_str(), e.time)
          << format(
                 "<Topology TopologyType=\"Polyline\" NodesPerElement=\"2\" "
                 "NumberOfElements=\"%lld\">",
                 static_cast<long long>(e.lines))
          << item(e, "/mesh/lines", e.lines, 2, "Int", 4)
          << "</Topology>\n<Geometry GeometryType=\"XYZ\">"
          << item(e, "/mesh/points", e.points, 3, "Float", 4) << "</Geometry>\n";
      auto attribute = [&](const std::string& group, const std::string& name, const char* kind,
                           int columns, const char* type, int bytes) {
        out << format("<Attribute Name=\"%s\" AttributeType=\"%s\" Center=\"Node\">", name.c_str(),
                      kind)
            << item(e, (group + name).c_str(), e.points, columns, type, bytes) << "</Attribute>\n";
      };
      attribute("/state/", "velocity", "Vector", 3, "Float", 8);
      attribute("/state/", "fibre", "Scalar", 1, "Int", 8);
      attribute("/state/", "group", "Scalar", 1, "Int", 4);
      attribute("/state/", "bond_broken", "Scalar", 1, "Char", 1);
      for (const std::string& name : e.fields) attribute("/field/", name, "Scalar", 1, "Float", 4);
      out << "</Grid>\n";
    }
    out << "</Grid>\n</Domain>\n</Xdmf>\n";
    if (!out.flush()) throw RunError("cannot write " + temporary);
  }
  if (std::rename(temporary.c_str(), index.c_str()) != 0) throw RunError("cannot write " + index);
}

}  // namespace nanoweft
