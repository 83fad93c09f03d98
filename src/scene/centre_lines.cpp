#include "nanoweft/scene/centre_lines.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

std::string readSceneText(MPI_Comm comm, const std::string& scene, const std::string& file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string text, problem;
  if (rank == 0) {
    const std::string what = "-" + scene + "_file " + file;
    std::ifstream in(file);
    std::ostringstream all;
    if (!in || !(all << in.rdbuf())) problem = what + ": cannot be read, or is empty";
    text = all.str();
    if (text.size() > 2000000000u) problem = what + ": larger than 2 GB";
  }
  agree<InputError>(comm, problem);
  auto size = static_cast<int>(text.size());
  MPI_Bcast(&size, 1, MPI_INT, 0, comm);
  text.resize(static_cast<std::size_t>(size));
  MPI_Bcast(text.data(), size, MPI_CHAR, 0, comm);
  return text;
}

std::vector<std::string_view> wordsOf(std::string_view line) {
  constexpr const char* blanks = " \t\r\v\f";
  std::vector<std::string_view> words;
  for (;;) {
    const auto begin = line.find_first_not_of(blanks);
    if (begin == line.npos) return words;
    line.remove_prefix(begin);
    words.push_back(line.substr(0, line.find_first_of(blanks)));
    line.remove_prefix(words.back().size());
  }
}

std::optional<double> numberOf(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double x = 0;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), x);
  if (read.ec != std::errc() || read.ptr != word.data() + word.size() || !std::isfinite(x))
    return std::nullopt;
  return x;
}

namespace {

/// A smooth curve through the points. The parameter is length along the straight pieces between
/// them, from the first point on.
class Smooth {
 public:
  explicit Smooth(const CentreLine& line) : line_(line) {
    const std::size_t pieces = line.points.size() - (line.closed ? 0 : 1);
    for (std::size_t k = 0; k < pieces; ++k)
      until_.push_back((k > 0 ? until_.back() : 0.0) + norm(point(k, 1) - point(k, 0)));
  }

  double length() const { return until_.back(); }

  Vec3d operator()(double u) const {
    const double rounds = line_.closed ? std::floor(u / length()) : 0.0;
    u -= length() * rounds;
    const auto at = std::min<std::size_t>(
        static_cast<std::size_t>(std::ranges::upper_bound(until_, u) - until_.begin()),
        until_.size() - 1);
    const double begin = at > 0 ? until_[at - 1] : 0.0, s = (u - begin) / (until_[at] - begin);
    return after(rounds, within(at, s));
  }

 private:
  /// The place so many rounds on.
  Vec3d after(double rounds, const Vec3d& x) const {
    return norm(line_.round) > 0 ? x + rounds * line_.round : x;
  }

  /// The place at the share s of a piece.
  Vec3d within(std::size_t piece, double s) const {
    const Vec3d a = point(piece, 0), b = point(piece, 1);
    const double length = norm(b - a);
    const Vec3d ta = length * slope(piece, 0), tb = length * slope(piece, 1);
    // Beyond the ends the curve goes straight on.
    if (s < 0) return a + s * ta;
    if (s > 1) return b + (s - 1.0) * tb;
    const double s2 = s * s, s3 = s2 * s;
    return (2 * s3 - 3 * s2 + 1) * a + (s3 - 2 * s2 + s) * ta + (3 * s2 - 2 * s3) * b +
           (s3 - s2) * tb;
  }

  /// Change of place with the parameter at the point so many places from the k-th: that of the
  /// parabola through it and its two neighbours, or through the last three points. Pieces of any
  /// lengths may follow each other: the curve runs back only where the points do.
  Vec3d slope(std::size_t k, int places) const {
    const auto last = static_cast<std::int64_t>(line_.points.size()) - 1;
    const std::int64_t i = static_cast<std::int64_t>(k) + places;
    const bool first = !line_.closed && i == 0, final = !line_.closed && i == last;
    const int middle = first && last > 1 ? places + 1 : final && last > 1 ? places - 1 : places;
    const Vec3d before = point(k, middle - 1), at = point(k, middle), after = point(k, middle + 1);
    const double ahead = norm(after - at), behind = norm(at - before);
    const Vec3d along = (1.0 / ahead) * (after - at), past = (1.0 / behind) * (at - before);
    const Vec3d there = (1.0 / (ahead + behind)) * (ahead * past + behind * along);
    if (middle == places) return there;
    return 2.0 * (first ? past : along) - there;
  }

  /// The point so many places from the k-th; beyond the ends on the line of the last two.
  Vec3d point(std::size_t k, int places) const {
    const auto& points = line_.points;
    const auto n = static_cast<std::int64_t>(points.size());
    const std::int64_t i = static_cast<std::int64_t>(k) + places;
    if (line_.closed) {
      const std::int64_t inside = (i % n + n) % n;
      return after(static_cast<double>((i - inside) / n), points[static_cast<std::size_t>(inside)]);
    }
    if (i < 0) return 2.0 * points[0] - points[1];
    if (i >= n) return 2.0 * points[points.size() - 1] - points[points.size() - 2];
    return points[static_cast<std::size_t>(i)];
  }

  const CentreLine& line_;
  std::vector<double> until_;  ///< the parameter at the end of each piece
};

/// Length of a curve, and the parameter in the middle of it.
struct Measure {
  double length, middle;
};

Measure measured(const Smooth& curve, double T) {
  constexpr int parts = 20;
  const int pieces = std::max(100, static_cast<int>(parts * curve.length() / T));
  std::vector<double> until{0.0};
  for (int k = 0; k < pieces; ++k)
    until.push_back(until.back() + norm(curve(curve.length() * (k + 1) / pieces) -
                                        curve(curve.length() * k / pieces)));
  const double half = 0.5 * until.back();
  const auto above = std::ranges::upper_bound(until, half);
  const double share = (half - above[-1]) / (above[0] - above[-1]);
  const auto place = static_cast<double>(above - until.begin() - 1) + share;
  return {until.back(), curve.length() * place / pieces};
}

}  // namespace

Laying layOnCentreLines(Laying laying, const std::vector<CentreLine>& lines) {
  auto laid = std::make_shared<std::vector<Line>>();
  for (const CentreLine& line : lines) {
    const auto f = static_cast<std::int64_t>(laid->size());
    double T = laying.mix->fibre(f).length;
    const Smooth curve(line);
    const auto [length, middle] = measured(curve, T);
    const auto segments = static_cast<int>(std::lround(length / T));
    if (const int least = line.closed ? 3 : 2; segments < least)
      throw InputError(format("%s: fibre %lld is %.4g long, which is less than %d segments of %.4g",
                              laying.file.c_str(), static_cast<long long>(f), length, least, T));
    if (line.closed)
      laid->push_back({walkAround(curve, curve.length(), segments, T), true, line.round});
    else
      laid->push_back(
          {walk([&, from = middle](double u) { return curve(from + u); }, T, segments)});
  }
  auto line = [=](std::int64_t f) -> const Line& { return (*laid)[static_cast<std::size_t>(f)]; };
  laying.fibres = static_cast<std::int64_t>(laid->size());
  laying.segments = [=](std::int64_t f) { return static_cast<int>(line(f).points.size()); };
  laying.line = line;
  laying.also = "from " + laying.file;
  return laying;
}

}  // namespace nanoweft
