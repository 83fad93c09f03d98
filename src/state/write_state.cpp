#include <petscsf.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <optional>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/base/hdf5_driver.hpp"
#include "nanoweft/base/output_file.hpp"
#include "nanoweft/state/dataset_writer.hpp"
#include "nanoweft/state/kind_names.hpp"
#include "nanoweft/state/link_file.hpp"
#include "nanoweft/state/open_state.hpp"
#include "nanoweft/state/output_target.hpp"
#include "nanoweft/state/state_file.hpp"
#include "nanoweft/state/state_format.hpp"
#include "nanoweft/state/state_signature.hpp"

namespace nanoweft {

namespace {

/// Sends rows from where they live to where they stand in order.
class RowOrder {
 public:
  RowOrder(const State& state, const RowBlock& block) : block_(block) {
    PetscLayout layout;
    petsc(PetscLayoutCreate(state.comm(), &layout));
    petsc(PetscLayoutSetLocalSize(layout, static_cast<PetscInt>(block.count)));
    petsc(PetscLayoutSetUp(layout));
    std::vector<PetscInt> rows(state.row, state.row + state.owned());
    petsc(PetscSFCreate(state.comm(), &sf_));
    petsc(
        PetscSFSetGraphLayout(sf_, layout, state.owned(), nullptr, PETSC_COPY_VALUES, rows.data()));
    petsc(PetscSFSetUp(sf_));
    petsc(PetscLayoutDestroy(&layout));
  }
  ~RowOrder() { PetscSFDestroy(&sf_); }
  RowOrder(const RowOrder&) = delete;
  RowOrder& operator=(const RowOrder&) = delete;

  template <class T>
  std::vector<T> operator()(const T* values, int columns) const {
    static_assert(sizeof(T) % 4 == 0);
    MPI_Datatype unit;
    MPI_Type_contiguous(columns * static_cast<int>(sizeof(T) / 4), MPI_INT, &unit);
    MPI_Type_commit(&unit);
    std::vector<T> ordered(static_cast<std::size_t>(block_.count * columns));
    petsc(PetscSFReduceBegin(sf_, unit, values, ordered.data(), MPI_REPLACE));
    petsc(PetscSFReduceEnd(sf_, unit, values, ordered.data(), MPI_REPLACE));
    MPI_Type_free(&unit);
    return ordered;
  }

 private:
  PetscSF sf_ = nullptr;
  RowBlock block_;
};

/// The file while it is written, on rank 0; on the other ranks nothing.
class FileOnRank0 {
 public:
  /// Throws RunError when the place is not this run's to take, or the file cannot be made.
  FileOnRank0(MPI_Comm comm, const std::string& name, const Provenance& run)
      : comm_(comm), name_(name) {
    MPI_Comm_rank(comm, &rank_);
    h5::silence();
    std::string problem;
    if (rank_ == 0) problem = claimTarget(name, run, replaced_);
    if (rank_ == 0 && problem.empty()) problem = output_.emplace(name).problem();
    if (rank_ == 0 && problem.empty()) {
      open_.descriptor = output_->descriptor();
      const h5::Handle access = h5::accessTo(open_);
      h5::Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
      H5Pset_userblock(creation, signatureBytes);
      file_ = h5::Handle(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose);
      if (!file_.valid()) problem = "cannot write " + name + ": " + h5::lastError();
    }
    agree<RunError>(comm, problem);
  }
  FileOnRank0(const FileOnRank0&) = delete;
  FileOnRank0& operator=(const FileOnRank0&) = delete;

  h5::Handle group(const char* name) const {
    if (rank_ != 0) return {};
    h5::Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    return {H5Gcreate2(file_, name, H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose};
  }

  /// Closes, signs and publishes the file. All groups must be closed. Throws RunError.
  void publish(bool good) { agree<RunError>(comm_, rank_ == 0 ? problemInPublishing(good) : ""); }

 private:
  std::string problemInPublishing(bool good) {
    // HDF5's reason is gone once the file is closed.
    const std::string reason = good ? "" : h5::lastError();
    good = file_.close() && good;
    int failure = open_.failure;
    if (good && failure == 0) failure = signFile(open_.descriptor);
    if (failure != 0) output_->fail(failure);
    if (!output_->problem().empty()) return output_->problem();
    if (!good)
      return "cannot write " + name_ + ": HDF5 failed" +
             (reason.empty() ? "" : " (" + reason + ")");
    const std::string problem = output_->publish(replaced_);
    if (problem.empty()) noteTarget(name_, replaced_);
    return problem;
  }

  MPI_Comm comm_;
  int rank_;
  std::string name_;
  FileIdentity replaced_;
  std::optional<OutputFile> output_;
  h5::OpenFile open_;
  h5::Handle file_;
};

bool writeHead(hid_t group, const State& state, const UnitSystem& units) {
  const auto& [lower, upper, periodic, tilt] = state.box;
  bool good = h5::writeAttribute(group, "format", stateFormatName);
  good &= h5::writeScalar(group, "version", stateFormatVersion);
  good &= h5::writeScalar(group, "step", state.step);
  good &= h5::writeScalar(group, "time", state.time);
  good &= h5::writeAttribute(group, "units", units.name);
  good &= h5::writeAttribute(group, "lower", std::vector<double>(lower.begin(), lower.end()));
  good &= h5::writeAttribute(group, "upper", std::vector<double>(upper.begin(), upper.end()));
  if (tilt) {
    std::vector<double> slides(3);
    slides[static_cast<std::size_t>(tilt.place())] = tilt.way;
    good &= h5::writeAttribute(group, "tilt", slides);
  }
  return h5::writeAttribute(group, "periodic",
                            std::vector<std::int64_t>(periodic.begin(), periodic.end())) &&
         good;
}

bool writeRecord(hid_t group, const RunRecord& run) {
  bool good = true;
  for (const auto& [name, values] : run.reals)
    good &= h5::writeAttribute(group, name.c_str(), values);
  for (const auto& [name, values] : run.integers)
    good &= h5::writeAttribute(group, name.c_str(), values);
  for (const auto& [name, text] : run.texts) good &= h5::writeAttribute(group, name.c_str(), text);
  return good;
}

/// What several groups of the file need, in the order of rows.
struct OrderedRows {
  std::vector<double> position;
  std::vector<std::int32_t> image, bond, chain;
};

void writeKinds(DatasetWriter& writer, hid_t group, const State& state, const RowOrder& ordered) {
  std::vector<std::int32_t> kind(static_cast<std::size_t>(state.owned()));
  for (int i = 0; i < state.owned(); ++i) kind[static_cast<std::size_t>(i)] = state.kind(i);
  writer.write(group, rows::kind.name, 1, ordered(kind.data(), 1));
  if (state.rank() == 0) writeKindNames(writer, group, state.kinds);
}

/// The segments' fields, with each segment's contacts in the order of their partners: which slot
/// one has depends on ranks and threads.
struct SortedContacts {
  SegmentFields fields;
  std::vector<std::int64_t> contact;
  std::vector<double> spring;

  explicit SortedContacts(const State& state) : fields(state) {
    if (!state.contact) return;
    constexpr auto slots = static_cast<std::size_t>(contactSlots);
    const auto n = static_cast<std::size_t>(state.owned());
    std::array<std::size_t, slots> order;
    // Not null where this rank has no segments: all ranks write a field, or none does.
    contact.reserve(slots * std::max<std::size_t>(n, 1));
    spring.reserve(3 * slots * std::max<std::size_t>(n, 1));
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t* const partner = state.contact + slots * i;
      std::iota(order.begin(), order.end(), 0);
      // Empty slots, which are 0, go last.
      std::ranges::sort(order, {},
                        [&](std::size_t k) { return static_cast<std::uint64_t>(partner[k]) - 1; });
      for (const std::size_t k : order) {
        contact.push_back(partner[k]);
        const double* s = state.spring + 3 * (slots * i + k);
        spring.insert(spring.end(), s, s + 3);
      }
    }
    fields.contact = contact.data();
    fields.spring = spring.data();
  }
};

void writeSegments(DatasetWriter& writer, hid_t group, const State& state, const RowOrder& ordered,
                   const OrderedRows& rows, bool forces) {
  const auto n = static_cast<std::size_t>(state.owned());
  std::vector<double> orientation(4 * n);
  std::vector<std::int64_t> index(n);
  for (std::size_t k = 0; k < n; ++k) {
    std::copy_n(state.pose + 8 * k + 4, 4, &orientation[4 * k]);
    index[k] = state.chain[2 * k];
  }
  const auto fibre = ordered(state.fibre, 1);
  std::vector<std::int8_t> broken(rows.bond.size());
  std::vector<std::int64_t> closed;
  for (std::size_t k = 0; k < rows.bond.size(); ++k) {
    broken[k] = (rows.bond[k] & nextBroken) != 0;
    if ((rows.bond[k] & fibreClosed) && rows.chain[2 * k] == 0) closed.push_back(fibre[k]);
  }
  std::int64_t closedFibres = static_cast<std::int64_t>(closed.size());
  MPI_Allreduce(MPI_IN_PLACE, &closedFibres, 1, MPI_INT64_T, MPI_SUM, state.comm());

  writer.write(group, "position", 3, rows.position);
  writer.write(group, "image", 3, rows.image);
  writer.write(group, "orientation", 4, ordered(orientation.data(), 4));
  writer.write(group, "fibre", 1, fibre);
  writer.write(group, "index", 1, ordered(index.data(), 1));
  const SortedContacts contacts(state);
  auto writeFields = [&](Stored which) {
    for (const Field& f : fields)
      f.visit(contacts.fields, [&](const auto* values) {
        if (f.stored == which && values)
          writer.write(group, f.name, f.components, ordered(values, f.components));
      });
  };
  writeFields(Stored::always);
  if (state.kinds.size() > 1) writeKinds(writer, group, state, ordered);
  writer.write(group, "bond_broken", 1, broken);
  if (closedFibres > 0) writer.write(group, "fibre_closed", 1, closed);
  if (forces) writeFields(Stored::withForces);
  writeFields(Stored::extra);
}

/// Points and lines for ParaView. `first`: the first row of this rank's.
void writeMesh(DatasetWriter& writer, hid_t group, const Box& box, std::int64_t first,
               const OrderedRows& rows) {
  std::vector<float> points(rows.position.size());
  for (std::size_t k = 0; k < points.size(); k += 3) {
    const Vec3d at = box.unwrapped(&rows.position[k], &rows.image[k]);
    points[k] = static_cast<float>(at.x);
    points[k + 1] = static_cast<float>(at.y);
    points[k + 2] = static_cast<float>(at.z);
  }
  std::vector<std::int32_t> lines;
  for (std::size_t k = 0; k < rows.bond.size(); ++k) {
    // Bonds that close a ring through the periodic boundary would be drawn across the box, so a
    // line joins neighbours along the fibre only.
    if ((rows.bond[k] & nextBroken) || rows.chain[2 * k] + 1 >= rows.chain[2 * k + 1]) continue;
    const auto row = static_cast<std::int32_t>(first + static_cast<std::int64_t>(k));
    lines.insert(lines.end(), {row, row + 1});
  }
  writer.write(group, "points", 3, points);
  writer.write(group, "lines", 2, lines);
}

}  // namespace

void writeState(const std::string& name, State& state, const UnitSystem& units,
                const RunRecord& run, const StateWriteOptions& what) {
  const MPI_Comm comm = state.comm();
  const bool first = state.rank() == 0;
  FileOnRank0 file(comm, name, provenanceOf(run));
  const RowBlock block = RowBlock::ofChunks(state.total(), state.rank(), state.ranks());
  const RowOrder ordered(state, block);
  DatasetWriter writer(comm);
  {
    const auto n = static_cast<std::size_t>(state.owned());
    std::vector<double> position(3 * n);
    for (std::size_t k = 0; k < n; ++k) std::copy_n(state.pose + 8 * k, 3, &position[3 * k]);
    const OrderedRows rows{ordered(position.data(), 3), ordered(state.image, 3),
                           ordered(state.bond, 1), ordered(state.chain, 2)};
    const h5::Handle segments = file.group("state");
    if (first) writer.note(writeHead(segments, state, units));
    writeSegments(writer, segments, state, ordered, rows, what.forces);
    if (!run.reals.empty() || !run.integers.empty() || !run.texts.empty()) {
      const h5::Handle record = file.group("run");
      if (first) writer.note(writeRecord(record, run));
    }
    if (!what.fields.empty()) {
      const h5::Handle fields = file.group("field");
      for (const SegmentField& field : what.fields)
        writer.write(fields, field.name, 1, ordered(field.values.data(), 1));
    }
    writeLinks(
        writer, [&] { return file.group("link"); }, state);
    if (what.mesh) writeMesh(writer, file.group("mesh"), state.box, block.begin, rows);
  }
  file.publish(writer.good());
}

}  // namespace nanoweft
