#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/state/kind_names.hpp"
#include "nanoweft/state/link_file.hpp"
#include "nanoweft/state/memory.hpp"
#include "nanoweft/state/open_state.hpp"
#include "nanoweft/state/rest.hpp"
#include "nanoweft/state/state_file.hpp"
#include "nanoweft/state/state_format.hpp"
#include "nanoweft/state/state_read.hpp"

namespace nanoweft {

namespace {

/// What `work` throws as InputError, for `agree`.
std::string problemIn(const std::function<void()>& work) {
  try {
    work();
    return "";
  } catch (const InputError& problem) {
    return problem.what();
  }
}

/// Names of the datasets in a group that something was written to.
std::set<std::string> namesOfParts(hid_t group) {
  std::set<std::string> names;
  auto note = [](hid_t g, const char* name, const H5L_info_t*, void* out) -> herr_t {
    h5::Handle set(H5Dopen2(g, name, H5P_DEFAULT), H5Dclose);
    H5D_space_status_t status = H5D_SPACE_STATUS_NOT_ALLOCATED;
    if (set.valid()) H5Dget_space_status(set, &status);
    if (status != H5D_SPACE_STATUS_NOT_ALLOCATED)
      static_cast<std::set<std::string>*>(out)->insert(name);
    return 0;
  };
  H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, note, &names);
  return names;
}

/// Says which names of a group are none of those that are known, if any.
void noteStrange(hid_t group, const std::string& path, const std::set<std::string>& known,
                 std::vector<std::string>& strange) {
  std::set<std::string> names;
  auto note = [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
    static_cast<std::set<std::string>*>(out)->insert(name);
    return 0;
  };
  H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, note, &names);
  auto list = [](const std::set<std::string>& of) {
    return listOf(std::vector<std::string>(of.begin(), of.end()));
  };
  std::erase_if(names, [&](const std::string& name) { return known.contains(name); });
  if (!names.empty())
    strange.push_back(format("in %s of the state file nobody reads %s; known are %s", path.c_str(),
                             list(names).c_str(), list(known).c_str()));
}

/// What in the file nobody reads. One misspelt name, and a start at rest passes for one that moves.
std::vector<std::string> strangeParts(const OpenState& file) {
  std::set<std::string> known;
  for (const auto& row : {rows::position, rows::orientation, rows::fibre, rows::index, rows::image,
                          rows::bondBroken, rows::fibreClosed, rows::kind})
    known.insert(row.name);
  for (const Field& f : fields)
    if (readByName(f) || f.stored == Stored::withForces) known.insert(f.name);
  std::vector<std::string> strange;
  noteStrange(file.file(), "/", {"state", "link", "run", "mesh", "field"}, strange);
  noteStrange(file.segments(), "/state", known, strange);
  if (file.hasLinks())
    noteStrange(file.links(), "/link", {"segments", "kind", "broken", "rest_length", "rest_frame"},
                strange);
  return strange;
}

/// Reads rows of a dataset of /state; leaves `values` empty when it is missing.
template <class T>
void readRows(const OpenState& file, const h5::Expected& expected, const RowBlock& block,
              std::vector<T>& values) {
  if (h5::find(file.segments(), expected.name) == h5::Found::nothing) return;
  const std::string problem =
      h5::readRows(file.segments(), expected, block.begin, block.count, values);
  if (!problem.empty()) file.refuse(std::string("/state/") + expected.name + " " + problem);
}

/// The attributes of /run.
RunRecord readRecord(const OpenState& file) {
  std::vector<std::string> names;
  auto visit = [](hid_t, const char* name, const H5A_info_t*, void* out) -> herr_t {
    static_cast<std::vector<std::string>*>(out)->emplace_back(name);
    return 0;
  };
  H5Aiterate2(file.record(), H5_INDEX_NAME, H5_ITER_INC, nullptr, visit, &names);
  RunRecord record;
  for (const std::string& name : names) {
    const h5::Handle attribute(H5Aopen(file.record(), name.c_str(), H5P_DEFAULT), H5Aclose);
    const h5::Handle type(H5Aget_type(attribute), H5Tclose);
    const H5T_class_t kind = H5Tget_class(type);
    // A copy of what was read, or a refusal.
    auto keep = [&](auto& place, const auto& value) {
      if (!value) file.refuse("the attribute " + name + " of /run cannot be read");
      place[name] = *value;
    };
    if (kind == H5T_FLOAT) keep(record.reals, h5::readReals(file.record(), name.c_str()));
    if (kind == H5T_INTEGER) keep(record.integers, h5::readIntegers(file.record(), name.c_str()));
    if (kind == H5T_STRING) keep(record.texts, h5::readText(file.record(), name.c_str()));
  }
  return record;
}

/// The header of a file that `checkState` found in order.
StateHeader readHeader(const OpenState& file) {
  const hid_t group = file.segments();
  StateHeader header;
  const auto lower = h5::readReals(group, "lower"), upper = h5::readReals(group, "upper");
  const auto periodic = h5::readIntegers(group, "periodic");
  const auto units = h5::readText(group, "units");
  header.rows = h5::inspect(group, rows::position).rows;
  if (!lower || !upper || !periodic || !units || header.rows < 1)
    file.refuse("it has changed while it was read");
  for (std::size_t d = 0; d < 3; ++d) {
    header.box.lower[d] = (*lower)[d];
    header.box.upper[d] = (*upper)[d];
    header.box.periodic[d] = (*periodic)[d] != 0;
  }
  if (const auto tilt = h5::readReals(group, "tilt"))
    for (int pair = 0; pair < 3; ++pair)
      if (const double way = tilt->at(static_cast<std::size_t>(pair)); way != 0)
        header.box.tilt = Tilt::ofPair(pair, way);
  header.units = *units;
  header.parts = namesOfParts(group);
  if (header.parts.contains(rows::kind.name)) header.kinds = readKindNames(file, kindsOfFibres);
  if (auto step = h5::readIntegers(group, "step"); step && !step->empty()) {
    header.step = (*step)[0];
    header.parts.insert("step");
  }
  if (auto time = h5::readReals(group, "time"); time && !time->empty()) {
    header.time = (*time)[0];
    header.parts.insert("time");
  }
  if (file.hasLinks()) {
    header.parts.insert("link");
    header.linkKinds = readKindNames(file, kindsOfLinks);
  }
  if (file.hasRecord())
    header.run = readRecord(file);
  else
    header.strange = strangeParts(file);
  header.identity = file.identity();
  return header;
}

/// First row of the fibre that holds each of this rank's rows, and that fibre's number of segments.
/// A fibre may span the blocks of several ranks.
struct Chains {
  std::vector<std::int64_t> start, length;
};

Chains findChains(MPI_Comm comm, int rank, int ranks, std::int64_t total, const RowBlock& block,
                  const std::vector<std::int64_t>& index) {
  // Every rank's first and last row where a fibre starts (index 0), or -1: two numbers a rank.
  std::int64_t mine[2] = {-1, -1};
  for (std::int64_t k = 0; k < block.count; ++k)
    if (index[static_cast<std::size_t>(k)] == 0) {
      if (mine[0] < 0) mine[0] = block.begin + k;
      mine[1] = block.begin + k;
    }
  std::vector<std::int64_t> all(2 * static_cast<std::size_t>(ranks));
  MPI_Allgather(mine, 2, MPI_INT64_T, all.data(), 2, MPI_INT64_T, comm);
  std::int64_t before = 0, after = total;
  for (int r = 0; r < rank; ++r)
    if (all[2 * static_cast<std::size_t>(r) + 1] >= 0)
      before = all[2 * static_cast<std::size_t>(r) + 1];
  for (int r = ranks - 1; r > rank; --r)
    if (all[2 * static_cast<std::size_t>(r)] >= 0) after = all[2 * static_cast<std::size_t>(r)];
  Chains chains;
  const auto n = static_cast<std::size_t>(block.count);
  chains.start.resize(n);
  chains.length.resize(n);
  std::int64_t start = before;
  for (std::size_t k = 0; k < n; ++k) {
    if (index[k] == 0) start = block.begin + static_cast<std::int64_t>(k);
    chains.start[k] = start;
  }
  std::int64_t end = after;
  for (std::size_t k = n; k-- > 0;) {
    chains.length[k] = end - chains.start[k];
    if (index[k] == 0) end = block.begin + static_cast<std::int64_t>(k);
  }
  return chains;
}

/// Is /state/fibre_closed a mask of True and False instead? (h5py writes those as an enumeration.)
bool isMask(hid_t segments) {
  h5::Handle set(H5Dopen2(segments, rows::fibreClosed.name, H5P_DEFAULT), H5Dclose);
  h5::Handle type(H5Dget_type(set), H5Tclose);
  return H5Tget_class(type) == H5T_ENUM;
}

/// What is wrong with the sorted ids of the closed fibres, or nothing.
std::string closedProblem(const std::vector<std::int64_t>& closed, bool mask) {
  const std::string wanted = "; fibre_closed lists the ids of the closed fibres";
  if (mask) return "/state/fibre_closed is a mask of True and False" + wanted;
  const auto twice = std::ranges::adjacent_find(closed);
  if (twice == closed.end()) return "";
  // Twice 0 or 1 and nothing else.
  if (closed.front() >= 0 && closed.back() <= 1)
    return "/state/fibre_closed looks like a mask of 0 and 1" + wanted;
  return format("/state/fibre_closed names the fibre %lld twice", static_cast<long long>(*twice));
}

/// Images count along periodic directions alone. Where the file's box (`own`) is periodic and the
/// run's box is open, a segment is put where its fibre runs on without a jump, maybe outside.
void settleImages(const Box& own, const Box& box, double* x, std::int32_t* image) {
  for (std::size_t d = 0; d < 3; ++d) {
    if (box.periodic[d]) continue;
    if (own.periodic[d]) x[d] += image[d] * own.length(static_cast<int>(d));
    image[d] = 0;
  }
}

/// The rows of one rank as they stand in the file, but for fields by their names.
struct RawRows {
  std::int64_t first;
  std::vector<double> position, orientation;
  std::vector<std::int64_t> fibre, index, closed;
  std::vector<std::int32_t> image, kind;
  std::vector<std::int8_t> broken;

  RawRows(const OpenState& file, const RowBlock& block) : first(block.begin) {
    readRows(file, rows::position, block, position);
    readRows(file, rows::orientation, block, orientation);
    readRows(file, rows::fibre, block, fibre);
    readRows(file, rows::index, block, index);
    readRows(file, rows::image, block, image);
    readRows(file, rows::bondBroken, block, broken);
    readRows(file, rows::kind, block, kind);
    if (h5::find(file.segments(), rows::fibreClosed.name) == h5::Found::nothing) return;
    // Every rank reads the whole list of closed fibres.
    readRows(file, rows::fibreClosed,
             RowBlock(h5::inspect(file.segments(), rows::fibreClosed).rows, 0, 1), closed);
    std::ranges::sort(closed);
    const std::string problem = closedProblem(closed, isMask(file.segments()));
    if (!problem.empty()) file.refuse(problem);
  }
  std::string name(std::size_t k) const {
    return format("row %lld (fibre %lld, index %lld)",
                  static_cast<long long>(first + static_cast<std::int64_t>(k)),
                  static_cast<long long>(fibre[k]), static_cast<long long>(index[k]));
  }
};

/// Reads the fields that the file has by their names, as far as the state has them; they are
/// checked all the same.
void readFields(const OpenState& file, const RowBlock& block, const RawRows& raw, State& state) {
  for (const Field& f : fields)
    if (readByName(f))
      f.visit(state, [&]<class T>(T* field) {
        std::vector<T> values;
        const h5::Expected expected = expectedOf(file, f);
        readRows(file, expected, block, values);
        const auto bad = std::ranges::find_if_not(
            values, [](T x) { return std::isfinite(static_cast<double>(x)); });
        if (bad != values.end())
          file.refuse(
              raw.name(static_cast<std::size_t>((bad - values.begin()) / expected.columns)) +
              ": its " + f.name + " is not a finite number");
        if (!field) return;
        for (auto row = values.begin(); row < values.end(); row += expected.columns)
          field = std::fill_n(std::copy_n(row, expected.columns, field),
                              f.components - expected.columns, T{0});
      });
}

/// Looks at the values that a rank has read, and names the row of the first that makes no sense.
class RowCheck {
 public:
  RowCheck(const RawRows& raw, const Box& box) : raw_(raw), box_(box) {}

  /// `previous`: (fibre, index) of the last row before this rank's, index -1 for none.
  std::string problem(std::int64_t fibre, std::int64_t index) const {
    for (std::size_t k = 0; k < raw_.fibre.size(); ++k) {
      const bool continues = index >= 0 && raw_.fibre[k] == fibre && raw_.index[k] == index + 1;
      const bool starts = raw_.index[k] == 0 && (index < 0 || raw_.fibre[k] > fibre);
      if (!continues && !starts)
        return raw_.name(k) +
               ": rows must be ordered by fibre, and index must count 0, 1, 2, ... along each";
      fibre = raw_.fibre[k], index = raw_.index[k];
      if (const std::string text = valuesOf(k); !text.empty()) return raw_.name(k) + text;
    }
    return "";
  }

 private:
  std::string valuesOf(std::size_t k) const {
    const double* q = &raw_.orientation[4 * k];
    const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(std::abs(norm2 - 1.0) < 2e-3))
      return format(": its orientation is not a unit quaternion (norm %g)", std::sqrt(norm2));
    const double* x = &raw_.position[3 * k];
    if (!std::all_of(x, x + 3, [](double at) { return std::isfinite(at); }))
      return ": its position is not a finite number";
    if (!raw_.broken.empty() && raw_.broken[k] != 0 && raw_.broken[k] != 1)
      return format(": its bond_broken is %d; it must be 0 or 1", raw_.broken[k]);
    for (int d = 0; d < 3; ++d) {
      const std::size_t at = 3 * k + static_cast<std::size_t>(d);
      // Wraps are counted in 32 bits.
      if (box_.periodic[static_cast<std::size_t>(d)] &&
          std::abs((x[d] - box_.lower[static_cast<std::size_t>(d)]) / box_.length(d)) +
                  (raw_.image.empty() ? 0.0 : std::abs(static_cast<double>(raw_.image[at]))) >
              1e9)
        return ": it lies more than 1e9 periods from the box";
    }
    return "";
  }

  const RawRows& raw_;
  const Box& box_;
};

/// What the row before a rank's first says; index -1: there is none.
struct LastRow {
  std::int64_t fibre = 0, index = -1, kind = 0;
};

LastRow lastBefore(const State& state, const RawRows& raw) {
  LastRow last;
  if (!raw.fibre.empty())
    last = {raw.fibre.back(), raw.index.back(), raw.kind.empty() ? 0 : raw.kind.back()};
  std::vector<LastRow> lasts(static_cast<std::size_t>(state.ranks()));
  MPI_Allgather(&last, 3, MPI_INT64_T, lasts.data(), 3, MPI_INT64_T, state.comm());
  LastRow previous;
  for (int r = 0; r < state.rank(); ++r)
    if (const LastRow& l = lasts[static_cast<std::size_t>(r)]; l.index >= 0) previous = l;
  return previous;
}

/// Which of the closed fibres no rank has, or that are too short. Collective.
std::string problemOfClosed(MPI_Comm comm, const RawRows& raw, const Chains& chains) {
  std::vector<std::int64_t> length(raw.closed.size(), 0);
  for (std::size_t k = 0; k < raw.fibre.size(); ++k)
    if (const auto at = std::ranges::lower_bound(raw.closed, raw.fibre[k]);
        at != raw.closed.end() && *at == raw.fibre[k])
      length[static_cast<std::size_t>(at - raw.closed.begin())] = chains.length[k];
  MPI_Allreduce(MPI_IN_PLACE, length.data(), static_cast<int>(length.size()), MPI_INT64_T, MPI_MAX,
                comm);
  for (std::size_t k = 0; k < length.size(); ++k) {
    const auto fibre = static_cast<long long>(raw.closed[k]);
    if (length[k] == 0)
      return format("fibre_closed names the fibre %lld, which it does not have", fibre);
    if (length[k] < 3)
      return format(
          "fibre_closed names the fibre %lld of %lld segments; a closed fibre needs three", fibre,
          static_cast<long long>(length[k]));
  }
  return "";
}

/// What is wrong with the rest rotations of a rank's rows, or nothing.
std::string problemOfRest(const RawRows& raw, const State& state) {
  if (!state.rest) return "";
  for (std::size_t k = 0; k < raw.fibre.size(); ++k) {
    const double* turn = state.rest + 3 * k;
    if (const double angle = norm(Vec3d{turn[0], turn[1], turn[2]}); angle > std::numbers::pi)
      return raw.name(k) +
             format(": its rest_rotation is a turn by %g rad; pi is the largest", angle);
  }
  return "";
}

/// What is wrong with the kinds of a rank's rows, or nothing.
std::string problemOfKinds(const RawRows& raw, const KindNumbers& numbers, LastRow before) {
  for (std::size_t k = 0; k < raw.kind.size(); ++k) {
    if (numbers.of(raw.kind[k]) < 0)
      return raw.name(k) + format(": its kind is %d; there are %zu (the first is 0)", raw.kind[k],
                                  numbers.count());
    if (before.index >= 0 && raw.fibre[k] == before.fibre && raw.kind[k] != before.kind)
      return raw.name(k) + ": it is of another kind than the segment before it on its fibre";
    before = {raw.fibre[k], raw.index[k], raw.kind[k]};
  }
  return "";
}

/// Where a fibre has got to: its last segment, and which image of it follows on.
struct FibreEnd {
  double position[3] = {};
  std::int64_t image[3] = {}, fibre = 0, index = -1;  ///< index -1: there is none
};

/// Gives rows without images those by which each segment is next to the one before it on its
/// fibre; fibres start in the image of their first segment. Rank by rank.
void followFibres(MPI_Comm comm, int rank, int ranks, const Box& box, RawRows& raw) {
  FibreEnd end;
  if (rank > 0) MPI_Recv(&end, sizeof end, MPI_BYTE, rank - 1, 0, comm, MPI_STATUS_IGNORE);
  const MinimumImage nearest(box);
  const auto along = static_cast<std::size_t>(box.tilt.along),
             across = static_cast<std::size_t>(box.tilt.across);
  raw.image.assign(raw.position.size(), 0);
  for (std::size_t k = 0; k < raw.fibre.size(); ++k) {
    const double* x = &raw.position[3 * k];
    if (end.index < 0 || raw.fibre[k] != end.fibre) {
      std::fill_n(end.image, 3, 0);
    } else {
      const Vec3d before{end.position[0], end.position[1], end.position[2]}, here{x[0], x[1], x[2]};
      // From this segment to its image beside the one before: whole periods.
      const Vec3d way = nearest(here - before) - (here - before);
      std::array<double, 3> periods{way.x, way.y, way.z};
      if (box.tilt)
        periods[along] -= std::round(periods[across] / box.length(box.tilt.across)) * box.tilt.way;
      for (int d = 0; d < 3; ++d)
        if (box.periodic[static_cast<std::size_t>(d)])
          end.image[d] += std::llround(periods[static_cast<std::size_t>(d)] / box.length(d));
    }
    std::copy_n(x, 3, end.position);
    end.fibre = raw.fibre[k], end.index = raw.index[k];
    for (std::size_t d = 0; d < 3; ++d)
      raw.image[3 * k + d] = static_cast<std::int32_t>(end.image[d]);
  }
  if (rank + 1 < ranks) MPI_Send(&end, sizeof end, MPI_BYTE, rank + 1, 0, comm);
}

void fill(State& state, const Box& own, const RawRows& raw, const Chains& chains) {
  for (std::size_t k = 0; k < raw.fibre.size(); ++k) {
    const int i = static_cast<int>(k);
    state.row[k] = raw.first + i;
    state.fibre[k] = raw.fibre[k];
    state.chain[2 * k] = static_cast<std::int32_t>(raw.index[k]);
    state.chain[2 * k + 1] = static_cast<std::int32_t>(chains.length[k]);
    std::copy_n(&raw.position[3 * k], 3, state.pose + 8 * k);
    const double* q = &raw.orientation[4 * k];
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    // Our own states come back with their bits; only foreign ones need normalising.
    const double scale = std::abs(norm - 1.0) < 1e-12 ? 1.0 : 1.0 / norm;
    state.setOrientation(i, {scale * q[0], scale * q[1], scale * q[2], scale * q[3]});
    if (!raw.image.empty()) std::copy_n(&raw.image[3 * k], 3, state.image + 3 * k);
    if (std::ranges::binary_search(raw.closed, raw.fibre[k])) state.bond[k] |= fibreClosed;
    if (!raw.broken.empty() && raw.broken[k]) state.bond[k] |= nextBroken;
    if (state.rest) {
      const double* turn = state.rest + 3 * k;
      setRest(state, i, {turn[0], turn[1], turn[2]});
    }
    settleImages(own, state.box, state.pose + 8 * k, state.image + 3 * k);
    state.box.wrap(state.pose + 8 * k, state.image + 3 * k);
  }
}

}  // namespace

StateHeader readStateHeader(MPI_Comm comm, const std::string& name, Trust trust) {
  int rank, ranks;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::string digest(64, ' ');
  agree<InputError>(comm,
                    rank == 0 ? problemIn([&] { digest = checkState(name, trust).digest; }) : "");
  MPI_Bcast(digest.data(), static_cast<int>(digest.size()), MPI_CHAR, 0, comm);
  // Small and read-only: every rank reads it by itself.
  StateHeader header;
  int broken = 0;
  agree<InputError>(comm, problemIn([&] {
                      OpenState file(name);
                      file.openGroups();
                      header = readHeader(file);
                      std::vector<std::int8_t> bonds;
                      readRows(file, rows::bondBroken, RowBlock(header.rows, rank, ranks), bonds);
                      broken = std::ranges::any_of(bonds, [](std::int8_t b) { return b != 0; });
                    }));
  MPI_Allreduce(MPI_IN_PLACE, &broken, 1, MPI_INT, MPI_MAX, comm);
  header.anyBroken = broken != 0;
  header.digest = digest;
  header.run.source = name;
  return header;
}

void readStateRows(const std::string& name, const StateHeader& header, State& state) {
  const MPI_Comm comm = state.comm();
  const RowBlock block(header.rows, state.rank(), state.ranks());
  requireMemory(comm, block.count, state.memoryOfSegment());
  std::optional<RawRows> raw;
  std::optional<LinkRows> links;
  agree<InputError>(comm, problemIn([&] {
                      OpenState file(name);
                      if (file.identity() != header.identity)
                        file.refuse("it was replaced while it was read");
                      file.openGroups();
                      raw.emplace(file, block);
                      if (file.hasLinks()) links = readLinkRows(file);
                      state.addOwned(static_cast<int>(block.count));
                      readFields(file, block, *raw, state);
                    }));
  const LastRow before = lastBefore(state, *raw);
  const std::string what = "state file " + name + " cannot be used: ";
  auto agreeOn = [&](const std::string& problem) {
    agree<InputError>(comm, problem.empty() ? "" : what + problem);
  };
  agreeOn(RowCheck(*raw, state.box).problem(before.fibre, before.index));
  const Chains chains =
      findChains(comm, state.rank(), state.ranks(), header.rows, block, raw->index);
  agreeOn(problemOfClosed(comm, *raw, chains));
  const KindNumbers numbers(kindsOfFibres, header.kinds, state.kinds);
  if (!header.parts.contains(rows::kind.name) && state.kinds.size() > 1)
    agreeOn("it has no /state/kind, and the run has the kinds " + listOf(state.kinds));
  agreeOn(numbers.problem());
  agreeOn(problemOfKinds(*raw, numbers, before));
  agreeOn(problemOfRest(*raw, state));
  for (std::size_t k = 0; k < raw->kind.size(); ++k)
    state.setKind(static_cast<int>(k), numbers.of(raw->kind[k]));
  if (!header.parts.contains(rows::image.name))
    followFibres(comm, state.rank(), state.ranks(), header.box, *raw);
  fill(state, header.box, *raw, chains);
  state.countTotal();
  if (links) {
    const KindNumbers kinds(kindsOfLinks, header.linkKinds, state.linkKinds);
    agreeOn(kinds.problem());
    agreeOn(setLinks(state, *links, kinds));
  }
  state.step = header.step;
  state.time = header.time;
}

}  // namespace nanoweft
