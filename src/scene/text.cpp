/// Scene `text`: fibres along the centre lines of a text file. Three numbers a line are a point; an
/// empty line ends a fibre; a line with one word before the points is the fibre's kind; # begins a
/// comment. A fibre that ends where it begins is closed. Fibres are laid a segment length at a time
/// on smooth curves through the points (Catmull and Rom).
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/laid.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

struct TextFibre {
  std::string kind;
  std::vector<Vec3d> points;
  bool closed = false;
};

/// The text of a file, which the first rank reads. Throws InputError. Collective.
std::string readText(MPI_Comm comm, const std::string& file) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  std::string text, problem;
  if (rank == 0) {
    std::ifstream in(file);
    std::ostringstream all;
    if (!in || !(all << in.rdbuf()))
      problem = "-text_file " + file + ": cannot be read, or is empty";
    text = all.str();
    if (text.size() > 2000000000u) problem = "-text_file " + file + ": larger than 2 GB";
  }
  agree<InputError>(comm, problem);
  auto size = static_cast<int>(text.size());
  MPI_Bcast(&size, 1, MPI_INT, 0, comm);
  text.resize(static_cast<std::size_t>(size));
  MPI_Bcast(text.data(), size, MPI_CHAR, 0, comm);
  return text;
}

/// Reads three numbers, or one word into `kind`. False: neither.
bool readLine(const std::string& line, double scale, TextFibre& fibre) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  if (words.size() == 1 && fibre.points.empty() && fibre.kind.empty()) {
    fibre.kind = words[0];
    return true;
  }
  if (words.size() != 3) return false;
  double x[3];
  for (std::size_t d = 0; d < 3; ++d) {
    std::size_t read = 0;
    try {
      x[d] = scale * std::stod(words[d], &read);
    } catch (const std::exception&) {
      return false;
    }
    if (read != words[d].size() || !std::isfinite(x[d])) return false;
  }
  const Vec3d point{x[0], x[1], x[2]};
  if (fibre.points.empty() || norm(point - fibre.points.back()) > 0) fibre.points.push_back(point);
  return true;
}

std::vector<TextFibre> parse(const std::string& text, const std::string& file, double scale) {
  std::vector<TextFibre> fibres;
  TextFibre fibre;
  int number = 0;
  auto finish = [&] {
    if (fibre.points.empty() && fibre.kind.empty()) return;
    if (fibre.points.size() < 2)
      throw InputError(format("%s, line %d: the fibre that ends here has fewer than two points",
                              file.c_str(), number));
    fibre.closed = fibre.points.size() > 3 && norm(fibre.points.front() - fibre.points.back()) == 0;
    if (fibre.closed) fibre.points.pop_back();
    fibres.push_back(std::move(fibre));
    fibre = {};
  };
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    ++number;
    const bool comment = line.find('#') != std::string::npos;
    line.resize(std::min(line.size(), line.find('#')));
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      if (!comment) finish();
    } else if (!readLine(line, scale, fibre)) {
      throw InputError(
          format("%s, line %d: needs three numbers, or the name of a kind before a "
                 "fibre's first point",
                 file.c_str(), number));
    }
  }
  finish();
  if (fibres.empty()) throw InputError(file + ": holds no points");
  return fibres;
}

/// A smooth curve through the points. The parameter is length along the straight pieces between
/// them, from the first point on.
class Smooth {
 public:
  explicit Smooth(const TextFibre& fibre) : points_(fibre.points), closed_(fibre.closed) {
    const std::size_t pieces = points_.size() - (closed_ ? 0 : 1);
    for (std::size_t k = 0; k < pieces; ++k)
      until_.push_back((k > 0 ? until_.back() : 0.0) + norm(point(k, 1) - points_[k]));
  }

  double length() const { return until_.back(); }

  Vec3d operator()(double u) const {
    if (closed_) u -= length() * std::floor(u / length());
    const auto at = std::min<std::size_t>(
        static_cast<std::size_t>(std::ranges::upper_bound(until_, u) - until_.begin()),
        until_.size() - 1);
    const double begin = at > 0 ? until_[at - 1] : 0.0, s = (u - begin) / (until_[at] - begin);
    const Vec3d a = points_[at], b = point(at, 1);
    // Beyond the ends the curve goes straight on.
    if (s < 0 || s > 1) return a + s * (b - a);
    const Vec3d before = point(at, -1), after = point(at, 2);
    const Vec3d ta = 0.5 * (b - before), tb = 0.5 * (after - a);
    const double s2 = s * s, s3 = s2 * s;
    return (2 * s3 - 3 * s2 + 1) * a + (s3 - 2 * s2 + s) * ta + (3 * s2 - 2 * s3) * b +
           (s3 - s2) * tb;
  }

 private:
  /// The point so many places from the k-th; beyond the ends on the line of the last two.
  Vec3d point(std::size_t k, int places) const {
    const auto n = static_cast<std::int64_t>(points_.size());
    const std::int64_t i = static_cast<std::int64_t>(k) + places;
    if (closed_) return points_[static_cast<std::size_t>((i % n + n) % n)];
    if (i < 0) return 2.0 * points_[0] - points_[1];
    if (i >= n) return 2.0 * points_[points_.size() - 1] - points_[points_.size() - 2];
    return points_[static_cast<std::size_t>(i)];
  }

  std::vector<Vec3d> points_;
  std::vector<double> until_;  ///< the parameter at the end of each piece
  bool closed_;
};

Line layOn(const Smooth& curve, bool closed, double T) {
  double length = 0;
  constexpr int parts = 20;
  const int pieces = std::max(100, static_cast<int>(parts * curve.length() / T));
  for (int k = 0; k < pieces; ++k)
    length += norm(curve(curve.length() * (k + 1) / pieces) - curve(curve.length() * k / pieces));
  const int segments = std::max(closed ? 3 : 2, static_cast<int>(std::lround(length / T)));
  if (closed) return {walkAround(curve, curve.length(), segments, T), true};
  const double middle = 0.5 * curve.length();
  return {walk([&](double u) { return curve(middle + u); }, T, segments)};
}

}  // namespace

std::unique_ptr<Scene> makeTextScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: text", use != SceneUse::none, "-scene is not text");
  const std::string file = s.as(Role::run).text(
      "text_file", "",
      "points on the fibres' centre lines: three columns, an empty line between fibres");
  const double scale = s.real("text_scale", 1.0, "", "unit of length of the file", positive);
  auto mix = std::make_shared<KindMix>(s, "text", context);
  const bool shaped = readShaped(s, "text");
  if (use != SceneUse::start) return nullptr;
  if (file.empty()) throw InputError("-scene text needs -text_file NAME");
  mix->prepare(context);
  const auto fibres = parse(readText(context.comm, file), file, scale);
  mix->draw(static_cast<std::int64_t>(fibres.size()));
  const auto known = context.kinds.names();
  std::vector<int> kinds;
  auto lines = std::make_shared<std::vector<Line>>();
  for (const TextFibre& fibre : fibres) {
    const auto at = std::ranges::find(known, fibre.kind);
    if (!fibre.kind.empty() && at == known.end())
      throw InputError(file + ": '" + fibre.kind + "' is not among -kinds");
    kinds.push_back(fibre.kind.empty() ? mix->of(static_cast<std::int64_t>(kinds.size()))
                                       : static_cast<int>(at - known.begin()));
    lines->push_back(layOn(Smooth(fibre), fibre.closed, context.kinds[kinds.back()].length));
  }
  mix->assign(std::move(kinds));
  Laying laying{"text", mix, static_cast<std::int64_t>(lines->size())};
  auto line = [=](std::int64_t f) -> const Line& { return (*lines)[static_cast<std::size_t>(f)]; };
  laying.segments = [=](std::int64_t f) { return static_cast<int>(line(f).points.size()); };
  laying.line = line;
  laying.also = format("from %s", file.c_str());
  laying.shaped = shaped;
  laying.file = file;
  return layScene(context, std::move(laying));
}

}  // namespace nanoweft
