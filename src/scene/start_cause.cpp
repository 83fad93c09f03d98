/// Why a start is far from rest: hypotheses, each tried on all bonds.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/start_check.hpp"

namespace nanoweft {

namespace {

constexpr double fitting = 0.05;  ///< strain of a bond that fits

std::int64_t sumOver(MPI_Comm comm, std::int64_t count) {
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT64_T, MPI_SUM, comm);
  return count;
}

/// The directions in which the bond runs through the boundary of a box that is periodic all around;
/// empty when it does not fit there either.
std::string directionsThrough(const Box& box, const WorstBond& worst, double length) {
  Box all = box;
  all.periodic = {true, true, true};
  const Vec3d raw = worst.to - worst.from, d = MinimumImage(all)(raw);
  if (std::abs(norm(d) / length - 1.0) > fitting) return "";
  const double difference[3] = {raw.x - d.x, raw.y - d.y, raw.z - d.z};
  std::string names;
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(difference[k]) > 0.5 * box.length(static_cast<int>(k))) {
      if (!names.empty()) names += " and ";
      names += "xyz"[k];
    }
  return names;
}

/// The length that most bonds have.
struct CommonLength {
  double length;
  std::int64_t count, bonds;
};

/// Of the bonds of one kind; `rest`: their rest length.
CommonLength commonLength(const StartBonds& bonds, int kind, double rest) {
  // Counted by logarithm: whole numbers are the same on any number of ranks.
  constexpr double perBin = 0.005, widest = 31.0;
  constexpr auto bins = static_cast<std::size_t>(2 * widest / perBin);
  const State& s = bonds.state();
  const MinimumImage nearest(s.box);
  auto binOf = [&](double r) {
    const double place = (std::log(r / rest) + widest) / perBin;
    return static_cast<std::size_t>(std::clamp(place, 1.0, static_cast<double>(bins) - 2.0));
  };
  std::vector<std::int64_t> count(bins, 0);
  bonds.forEach([&](const StartBond& b) {
    if (s.kind(b.i) == kind) ++count[binOf(norm(nearest(b.to - b.from)))];
  });
  MPI_Allreduce(MPI_IN_PLACE, count.data(), static_cast<int>(bins), MPI_INT64_T, MPI_SUM, s.comm());
  CommonLength common{0, -1, 0};
  std::size_t best = 1;
  for (std::size_t k = 1; k + 1 < bins; ++k) {
    common.bonds += count[k];
    if (const std::int64_t around = count[k - 1] + count[k] + count[k + 1]; around > common.count)
      common.count = around, best = k;
  }
  double ends[2] = {-std::numeric_limits<double>::infinity(), 0};  // of the negative and the length
  bonds.forEach([&](const StartBond& b) {
    const double r = norm(nearest(b.to - b.from));
    if (s.kind(b.i) != kind) return;
    if (const auto k = binOf(r); k + 1 < best || k > best + 1) return;
    ends[0] = std::max(ends[0], -r);
    ends[1] = std::max(ends[1], r);
  });
  MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPI_DOUBLE, MPI_MAX, s.comm());
  common.length = 0.5 * (ends[1] - ends[0]);
  return common;
}

/// What a spacing of `ratio` segment lengths says about the unit of the positions, or nothing.
std::string unitBehind(double ratio, bool si) {
  struct Unit {
    double ratio;
    const char* text;
  };
  static constexpr Unit nano[] = {
      {0.1, "T/10 apart: are the positions in nm? Here they are in A"},
      {1e-4, "T/10000 apart: are the positions in um? Here they are in A"},
      {1e-10, "1e-10 T apart: are the positions in m? Here they are in A"},
      {10, "10 T apart: were the positions turned from nm into A twice?"}};
  static constexpr Unit metric[] = {
      {1e3, "1000 T apart: are the positions in mm? Here they are in m"},
      {1e6, "1e6 T apart: are the positions in um? Here they are in m"},
      {1e9, "1e9 T apart: are the positions in nm? Here they are in m"},
      {1e10, "1e10 T apart: are the positions in A? Here they are in m"}};
  for (const Unit& u : si ? metric : nano)
    if (std::abs(ratio / u.ratio - 1.0) < 0.03) return u.text;
  return "";
}

std::string closingCause(const StartContext& c, const WorstBond& worst) {
  std::string text = "the fibre is closed, but its last segment does not lie beside its first: ";
  if (c.fromFile)
    return text + format(
                      "take %lld out of fibre_closed, which lists the ids of closed fibres (it is "
                      "no mask)",
                      static_cast<long long>(worst.fibre));
  return text +
         "leave out -fibre_closed, make a ring by -fibre_bend 6.283185307179586, or close it "
         "through a periodic boundary whose box holds just its segments";
}

}  // namespace

std::string strainCause(const StartBonds& bonds, const StartContext& c, const WorstBond& worst) {
  const Box& box = bonds.state().box;
  const double length = c.kinds[worst.kind].length;
  if (const std::string d = directionsThrough(c.sceneBox, worst, length); !d.empty()) {
    bool changed = false;
    for (std::size_t k = 0; k < 3; ++k)
      changed = changed || (d.find("xyz"[k]) != std::string::npos && box.periodic[k]);
    if (changed)
      return "it fits through the boundary along " + d +
             " of the scene's own box, which -domain_lower or -domain_upper have changed: leave "
             "the "
             "box as it is";
    const std::string what = worst.closes ? "the fibre closes" : "it runs on";
    return what + " through the boundary along " + d + ", which is open: keep that periodic (" +
           "-domain_periodic), or cut the fibre there (" +
           (c.fromFile ? worst.closes ? "take it out of fibre_closed or set bond_broken"
                                      : "set bond_broken, or give positions that do not jump"
                       : "a scene that is not periodic") +
           ")";
  }
  const CommonLength common = commonLength(bonds, worst.kind, length);
  const double ratio = common.length / length;
  if (10 * common.count >= 9 * common.bonds && std::abs(ratio - 1.0) > fitting) {
    if (const std::string unit = unitBehind(ratio, c.units.name == "si"); !unit.empty())
      return "segments of the length T lie " + unit;
    return format(
        "segments lie %.5g %s apart everywhere, but are %.5g long: give "
        "-fibre_segment_length %.5g, or lay them that far apart",
        common.length, c.units.length, length, common.length);
  }
  if (worst.closes) return closingCause(c, worst);
  return "lay neighbours along a fibre one segment length apart, in the order of index";
}

namespace {

/// Other ways to read an orientation.
enum Reading { againstChain, scalarLast, bodyY, bodyZ, inverse, readings };

Vec3d axisBy(Reading reading, const Quatd& q) {
  switch (reading) {
    case againstChain:
      return -axis1(q);
    case scalarLast:
      return axis1(Quatd{q.z, q.w, q.x, q.y});
    case bodyY:
      return axis2(q);
    case bodyZ:
      return axis3(q);
    default:
      return axis1(Quatd{q.w, -q.x, -q.y, -q.z});
  }
}

}  // namespace

std::string axisCause(const StartBonds& bonds, const StartContext& c) {
  if (!c.fromFile)
    return "the line turns back within a segment: round its corners, or cut it into shorter "
           "segments";
  const State& s = bonds.state();
  const MinimumImage nearest(s.box);
  std::array<std::int64_t, readings> fits{};
  std::int64_t all = 0, off = 0;
  bonds.forEach([&](const StartBond& b) {
    const Vec3d d = nearest(b.to - b.from);
    // Within 15 degrees, as between a curved fibre's tangent and chord.
    auto along = [&](const Vec3d& e) { return dot(e, d) >= 0.966 * norm(d); };
    const bool good = along(axis1(b.first)) && along(axis1(b.second));
    ++all;
    if (!good) ++off;
    for (int r = 0; r < readings; ++r) {
      const auto reading = static_cast<Reading>(r);
      // Single fibres may run the wrong way; a wrong convention holds for all.
      if (reading == againstChain && good) continue;
      if (along(axisBy(reading, b.first)) && along(axisBy(reading, b.second)))
        ++fits[static_cast<std::size_t>(r)];
    }
  });
  all = sumOver(s.comm(), all), off = sumOver(s.comm(), off);
  MPI_Allreduce(MPI_IN_PLACE, fits.data(), readings, MPI_INT64_T, MPI_SUM, s.comm());
  auto mostly = [&](Reading r) { return 10 * fits[r] >= 9 * (r == againstChain ? off : all); };
  const char* turn =
      c.fromFile ? "index the fibre the other way or turn the axes" : "turn the axes";
  if (mostly(scalarLast) && mostly(againstChain))
    return std::string(
               "the axes point against the chain: either the orientations are in the order "
               "x, y, z, w, and nanoweft wants w, x, y, z, or ") +
           turn;
  if (mostly(scalarLast)) return "the orientations look like x, y, z, w; nanoweft wants w, x, y, z";
  if (mostly(againstChain)) return std::string("the axes point against the chain: ") + turn;
  if (mostly(bodyZ) || mostly(bodyY))
    return std::string("the body ") + (mostly(bodyZ) ? "z" : "y") +
           " axis runs along the chain; nanoweft wants the body x axis there";
  if (mostly(inverse))
    return "the orientations look like those from space to body; nanoweft wants those from body to "
           "space";
  return "the orientation (w, x, y, z) must turn the x axis into the direction of the chain";
}

}  // namespace nanoweft
