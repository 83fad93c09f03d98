/// Scene `text`: fibres along the centre lines of a text file. Three numbers a line are a point; an
/// empty line ends a fibre; a line with one word before the points is the fibre's kind; # begins a
/// comment. A fibre that ends where it begins is closed.
#include <algorithm>
#include <sstream>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/centre_lines.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

struct TextFibre {
  std::string kind;
  CentreLine line;
};

/// Reads three numbers, or one word into `kind`. False: neither.
bool readLine(const std::string& text, double scale, TextFibre& fibre) {
  const auto words = wordsOf(text);
  auto& points = fibre.line.points;
  if (words.size() == 1 && points.empty() && fibre.kind.empty()) {
    fibre.kind = words[0];
    return true;
  }
  if (words.size() != 3) return false;
  const auto x = numberOf(words[0]), y = numberOf(words[1]), z = numberOf(words[2]);
  if (!x || !y || !z) return false;
  const Vec3d point{scale * *x, scale * *y, scale * *z};
  if (points.empty() || norm(point - points.back()) > 0) points.push_back(point);
  return true;
}

/// Points that differ by so little of the length of a piece are meant to be the same.
constexpr double roundOff = 1e-6;

std::vector<TextFibre> parse(const std::string& text, const std::string& file, double scale) {
  std::vector<TextFibre> fibres;
  TextFibre fibre;
  int number = 0;
  auto finish = [&] {
    auto& points = fibre.line.points;
    if (points.empty() && fibre.kind.empty()) return;
    if (points.size() < 2)
      throw InputError(format("%s, line %d: the fibre that ends here has fewer than two points",
                              file.c_str(), number));
    fibre.line.closed = points.size() > 3 && norm(points.front() - points.back()) <=
                                                 roundOff * norm(points[1] - points.front());
    if (fibre.line.closed) points.pop_back();
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

}  // namespace

std::unique_ptr<Scene> makeTextScene(Options& options, const SceneContext& context, SceneUse use) {
  OptionSection s(options, "Scene: text", use != SceneUse::none, "-scene is not text");
  const std::string file = s.as(Role::run).text(
      "text_file", "",
      "points on the fibres' centre lines: three columns, an empty line between fibres");
  const double scale = s.real("text_scale", 1.0, "", "unit of length of the file", positive);
  auto mix = std::make_shared<KindMix>(s, "text", context, MixOptions{.gap = false});
  const bool shaped = readShaped(s, "text");
  if (use != SceneUse::start) return nullptr;
  if (file.empty()) throw InputError("-scene text needs -text_file NAME");
  mix->prepare(context);
  const auto fibres = parse(readSceneText(context.comm, "text", file), file, scale);
  mix->draw(static_cast<std::int64_t>(fibres.size()));
  std::vector<int> kinds;
  std::vector<CentreLine> lines;
  for (const TextFibre& fibre : fibres) {
    kinds.push_back(fibre.kind.empty() ? mix->of(static_cast<std::int64_t>(kinds.size()))
                                       : kindNumber(context.kinds, file, fibre.kind));
    lines.push_back(fibre.line);
  }
  mix->assign(std::move(kinds));
  Laying laying{"text", mix};
  laying.shaped = shaped;
  laying.file = file;
  return layScene(context, layOnCentreLines(std::move(laying), lines));
}

}  // namespace nanoweft
