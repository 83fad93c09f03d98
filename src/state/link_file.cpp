#include "nanoweft/state/link_file.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/gather.hpp"

namespace nanoweft {

namespace {

/// Reads a whole dataset; leaves `values` empty when it is not there.
template <class T>
void readWhole(const OpenState& file, const h5::Expected& expected, std::vector<T>& values) {
  const hid_t group = file.links();
  if (h5::find(group, expected.name) == h5::Found::nothing) return;
  const std::string what = std::string("/link/") + expected.name + " ";
  const h5::Shape shape = h5::inspect(group, expected);
  if (!shape.problem.empty()) file.refuse(what + shape.problem);
  if (!shape.written) file.refuse(what + "was never written, or only in part");
  if (shape.rows > 100000000) file.refuse(what + "has more than 1e8 rows");
  const std::string problem = h5::readRows(group, expected, 0, shape.rows, values);
  if (!problem.empty()) file.refuse(what + problem);
}

std::string endOf(const LinkRows& rows, std::size_t k, std::size_t side) {
  return format("link %zu: its end at fibre %lld, segment %lld", k,
                static_cast<long long>(rows.segments[4 * k + 2 * side]),
                static_cast<long long>(rows.segments[4 * k + 2 * side + 1]));
}

/// Where this rank's fibres begin, and the poses of segments by row.
class OwnRows {
 public:
  explicit OwnRows(const State& state) : state_(state) {
    for (int i = 0; i < state.owned(); ++i) place_[key(state.fibre[i], state.chain[2 * i])] = i;
  }
  /// Local index of a segment of this rank, or -1.
  int of(std::int64_t fibre, std::int64_t index) const {
    const auto at = place_.find(key(fibre, index));
    return at == place_.end() || state_.fibre[at->second] != fibre ||
                   state_.chain[2 * at->second] != index
               ? -1
               : at->second;
  }

 private:
  struct Hash {
    std::size_t operator()(const std::pair<std::int64_t, std::int64_t>& k) const {
      return std::hash<std::int64_t>()(k.first * 1000003 + k.second);
    }
  };
  static std::pair<std::int64_t, std::int64_t> key(std::int64_t fibre, std::int64_t index) {
    return {fibre, index};
  }
  const State& state_;
  std::unordered_map<std::pair<std::int64_t, std::int64_t>, int, Hash> place_;
};

/// For each end of each link: its row (one more, so that 0 means unknown) and pose, on all ranks.
struct Ends {
  std::vector<std::int64_t> row;
  std::vector<double> pose;

  Ends(const State& state, const LinkRows& rows)
      : row(2 * rows.count(), 0), pose(8 * row.size(), 0.0) {
    const OwnRows own(state);
    for (std::size_t e = 0; e < row.size(); ++e)
      if (const int i = own.of(rows.segments[2 * e], rows.segments[2 * e + 1]); i >= 0) {
        row[e] = state.row[i] + 1;
        std::copy_n(state.pose + 8 * i, 8, &pose[8 * e]);
      }
    const auto n = static_cast<int>(row.size());
    MPI_Allreduce(MPI_IN_PLACE, row.data(), n, MPI_INT64_T, MPI_SUM, state.comm());
    MPI_Allreduce(MPI_IN_PLACE, pose.data(), 8 * n, MPI_DOUBLE, MPI_SUM, state.comm());
  }
  Vec3d position(std::size_t e) const { return {pose[8 * e], pose[8 * e + 1], pose[8 * e + 2]}; }
  Quatd orientation(std::size_t e) const {
    return {pose[8 * e + 4], pose[8 * e + 5], pose[8 * e + 6], pose[8 * e + 7]};
  }
};

std::string problemOf(const LinkRows& rows, const Ends& ends, const KindNumbers& kinds,
                      std::size_t k) {
  for (std::size_t side = 0; side < 2; ++side)
    if (ends.row[2 * k + side] == 0) return endOf(rows, k, side) + " is not in the file";
  if (ends.row[2 * k] == ends.row[2 * k + 1]) return endOf(rows, k, 0) + " is at both its ends";
  if (!rows.kind.empty() && kinds.of(rows.kind[k]) < 0)
    return format("link %zu: its kind is %d; there are %zu (the first is 0)", k, rows.kind[k],
                  kinds.count());
  if (!rows.broken.empty() && rows.broken[k] != 0 && rows.broken[k] != 1)
    return format("link %zu: its broken is %d; it must be 0 or 1", k, rows.broken[k]);
  if (!rows.length.empty() && !(rows.length[k] > 0 && std::isfinite(rows.length[k])))
    return format("link %zu: its rest_length is %g; it must be positive", k, rows.length[k]);
  for (std::size_t side = 0; side < 2 && !rows.frame.empty(); ++side) {
    const double* q = &rows.frame[8 * k + 4 * side];
    const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(std::abs(norm2 - 1.0) < 1e-9))
      return format("link %zu: its rest_frame is no unit quaternion", k);
  }
  return "";
}

}  // namespace

LinkRows readLinkRows(const OpenState& file) {
  LinkRows rows;
  readWhole(file, {"segments", 2, true, 2}, rows.segments);
  readWhole(file, {"kind", 1, true}, rows.kind);
  readWhole(file, {"broken", 1, true}, rows.broken);
  readWhole(file, {"rest_length", 1, false}, rows.length);
  readWhole(file, {"rest_frame", 2, false, 4}, rows.frame);
  const std::size_t n = rows.count();
  if (n == 0) file.refuse("/link has no dataset segments with links");
  auto fits = [&](std::size_t size, std::size_t columns) {
    return size == 0 || size == columns * n;
  };
  if (!fits(rows.kind.size(), 1) || !fits(rows.broken.size(), 1) || !fits(rows.length.size(), 1) ||
      !fits(rows.frame.size(), 8))
    file.refuse("the datasets of /link must have one length");
  return rows;
}

std::string setLinks(State& state, const LinkRows& rows, const KindNumbers& kinds) {
  const Ends ends(state, rows);
  const MinimumImage nearest(state.box);
  // The rows of this rank lie in one block.
  const std::int64_t first = state.owned() > 0 ? state.row[0] : 0;
  for (std::size_t k = 0; k < rows.count(); ++k) {
    if (const std::string problem = problemOf(rows, ends, kinds, k); !problem.empty())
      return problem;
    Link link;
    link.id = static_cast<std::int64_t>(k);
    bool here = false;
    for (std::size_t side = 0; side < 2; ++side) {
      link.row[side] = ends.row[2 * k + side] - 1;
      link.fibre[side] = rows.segments[4 * k + 2 * side];
      link.index[side] = static_cast<std::int32_t>(rows.segments[4 * k + 2 * side + 1]);
      here = here || (link.row[side] >= first && link.row[side] < first + state.owned());
    }
    if (!here) continue;
    link.kind = rows.kind.empty() ? 0 : kinds.of(rows.kind[k]);
    link.broken = rows.broken.empty() ? 0 : rows.broken[k];
    const Vec3d chord = nearest(ends.position(2 * k + 1) - ends.position(2 * k));
    link.length = rows.length.empty() ? norm(chord) : rows.length[k];
    if (!(link.length > 0))
      return format("link %zu: its ends are at one place; give rest_length", k);
    const Quatd frame = frameAlong(norm(chord) > 0 ? (1.0 / norm(chord)) * chord : Vec3d{1, 0, 0});
    for (std::size_t side = 0; side < 2; ++side) {
      const double* q = rows.frame.empty() ? nullptr : &rows.frame[8 * k + 4 * side];
      link.frame[side] =
          q ? Quatd{q[0], q[1], q[2], q[3]} : conjugate(ends.orientation(2 * k + side)) * frame;
    }
    state.links.push_back(link);
  }
  state.linked = true;
  return "";
}

void writeLinks(DatasetWriter& writer, const std::function<h5::Handle()>& group,
                const State& state) {
  if (!state.linked) return;
  // The owner of the first end sends a link to rank 0, which writes them all in their order.
  std::unordered_map<std::int64_t, bool> owned;
  for (const Link& link : state.links) owned[link.row[0]] = false;
  for (int i = 0; i < state.owned(); ++i)
    if (const auto at = owned.find(state.row[i]); at != owned.end()) at->second = true;
  Links mine;
  for (const Link& link : state.links)
    if (owned[link.row[0]]) mine.push_back(link);
  Links all = ofAllRanks(mine, state.comm(), false);
  std::ranges::sort(all, {}, &Link::id);
  LinkRows rows;
  for (const Link& l : all) {
    for (std::size_t side = 0; side < 2; ++side) {
      rows.segments.insert(rows.segments.end(), {l.fibre[side], std::int64_t{l.index[side]}});
      const Quatd& q = l.frame[side];
      rows.frame.insert(rows.frame.end(), {q.w, q.x, q.y, q.z});
    }
    rows.kind.push_back(l.kind);
    rows.broken.push_back(static_cast<std::int8_t>(l.broken));
    rows.length.push_back(l.length);
  }
  const h5::Handle links = group();
  writer.write(links, "segments", {2, 2}, rows.segments);
  writer.write(links, "kind", 1, rows.kind);
  if (state.rank() == 0 && !state.linkKinds[0].empty())
    writeKindNames(writer, links, state.linkKinds);
  writer.write(links, "broken", 1, rows.broken);
  writer.write(links, "rest_length", 1, rows.length);
  writer.write(links, "rest_frame", {2, 4}, rows.frame);
}

}  // namespace nanoweft
