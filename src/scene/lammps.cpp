/// Scene `lammps`: fibres along the chains of atoms that a data file of LAMMPS ties by bonds.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "nanoweft/base/error.hpp"
#include "nanoweft/scene/centre_lines.hpp"
#include "nanoweft/scene/scenes.hpp"

namespace nanoweft {

namespace {

/// A style of atoms: the columns of a line; the type is the third, and three image flags may
/// follow.
struct Style {
  const char *name, *columns;
  std::size_t count, x;
  std::size_t neighbours = 0;  ///< the first of the columns that name both neighbours; 0: none do
};

constexpr Style styles[] = {
    {"angle", "id molecule type x y z", 6, 3},
    {"bond", "id molecule type x y z", 6, 3},
    {"full", "id molecule type charge x y z", 7, 4},
    {"mesont", "id molecule type b1 b2 mass radius length buckling x y z", 12, 9, 3},
    {"molecular", "id molecule type x y z", 6, 3},
};

const Style* styleOf(std::string_view name) {
  const auto at = std::ranges::find(styles, name, &Style::name);
  return at == std::end(styles) ? nullptr : at;
}

struct Atom {
  std::int64_t id;
  int line, type;
  Vec3d x;
  std::array<std::int32_t, 3> image{};
  std::array<std::int64_t, 2> named{};  ///< neighbours that it names
  std::array<int, 2> tied{-1, -1};      ///< places of its neighbours in the list
};

struct Tie {
  int line;
  std::int64_t first, second;  ///< ids
};

/// What is read of a data file, lengths times `scale`. All errors are InputErrors.
class DataFile {
 public:
  DataFile(std::string name, double scale, const Style* style)
      : name_(std::move(name)), scale_(scale), style_(style) {}

  void read(std::string_view text);
  /// Ties the atoms. `box`: with its periodic directions.
  void tie();
  const Box& box() const { return box_; }
  std::int64_t types() const { return counts_.at("types"); }

  /// The atoms of each fibre in order, and of those whether the last is tied to the first: fibres
  /// with two ends in the order of their lower ends, then rings.
  std::vector<std::pair<std::vector<int>, bool>> chains() const;
  /// Counts in `otherwise` the bonds that by their image flags lead elsewhere than to the nearest
  /// image.
  CentreLine lineThrough(const std::vector<int>& chain, bool closed, const Box& box,
                         int& otherwise) const;
  /// The kind of a chain, where kind(type) is that of an atom.
  int kindOf(const std::vector<int>& chain, const std::vector<int>& kinds) const;

 private:
  using Words = std::vector<std::string_view>;
  [[noreturn]] void fail(int line, const std::string& text) const {
    throw InputError(format("%s, line %d: %s", name_.c_str(), line, text.c_str()));
  }
  void begin(const Words& title, std::string_view comment);
  void header(const Words& words);
  void readAtom(const Words& words);
  void readBond(const Words& words);
  void requireCounts() const;
  double number(std::string_view word) const;
  std::int64_t whole(std::string_view word) const;
  int placeOf(std::int64_t id, int line) const;
  void tie(int line, int a, int b);
  void tieNamed(int a);

  std::string name_, section_;
  double scale_;
  const Style* style_;
  int line_ = 0;
  bool flagged_ = false;  ///< atoms have image flags
  std::map<std::string, std::int64_t> counts_{{"atoms", -1}, {"bonds", 0}, {"types", -1}};
  Box box_;
  std::vector<Atom> atoms_;
  std::vector<Tie> bonds_;
  std::unordered_map<std::int64_t, int> places_;
};

double DataFile::number(std::string_view word) const {
  const auto x = numberOf(word);
  if (!x) fail(line_, format("'%s' is not a number", std::string(word).c_str()));
  return *x;
}

std::int64_t DataFile::whole(std::string_view word) const {
  std::int64_t n = 0;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), n);
  if (read.ec != std::errc() || read.ptr != word.data() + word.size())
    fail(line_, format("'%s' is not a whole number", std::string(word).c_str()));
  return n;
}

void DataFile::read(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    // The first line is a title.
    if (++line_ == 1) continue;
    const std::string_view said = line.substr(0, line.find('#'));
    const Words words = wordsOf(said);
    if (words.empty()) continue;
    if (std::isalpha(static_cast<unsigned char>(words[0].front())))
      begin(words, line.substr(said.size()));
    else if (section_.empty())
      header(words);
    else if (section_ == "Atoms")
      readAtom(words);
    else if (section_ == "Bonds")
      readBond(words);
  }
  requireCounts();
}

void DataFile::begin(const Words& title, std::string_view comment) {
  // Those of several words are left.
  section_ = title.size() == 1 ? title[0] : "left";
  if (section_ != "Atoms") return;
  const Words words = wordsOf(comment.empty() ? comment : comment.substr(1));
  const Style* said = words.empty() ? nullptr : styleOf(words[0]);
  if (said && style_ && said != style_)
    fail(line_, format("the atoms are of the style %s, but -lammps_style says %s", said->name,
                       style_->name));
  if (said) style_ = said;
  if (!style_)
    fail(line_,
         format("%s; atoms in chains are of the style angle, bond, full, mesont or molecular: "
                "write `Atoms # full`, or give -lammps_style",
                words.empty() ? "nothing says of which style the atoms are"
                              : format("atoms of the style '%s' cannot be read",
                                       std::string(words[0]).c_str())
                                    .c_str()));
}

void DataFile::header(const Words& words) {
  const std::size_t n = words.size();
  if (n == 2 && (words[1] == "atoms" || words[1] == "bonds")) {
    counts_[std::string(words[1])] = whole(words[0]);
  } else if (n == 3 && words[1] == "atom" && words[2] == "types") {
    counts_["types"] = whole(words[0]);
  } else if (n == 4 && words[2].size() == 3 && words[2].ends_with("lo")) {
    const auto d = static_cast<std::size_t>(words[2][0] - 'x');
    if (d > 2) return;
    box_.lower[d] = scale_ * number(words[0]), box_.upper[d] = scale_ * number(words[1]);
    if (!(box_.lower[d] < box_.upper[d])) fail(line_, "the box has no extent");
  } else if (n == 6 && words[3] == "xy") {
    for (int pair = 0; pair < 3; ++pair) {
      const double way = scale_ * number(words[static_cast<std::size_t>(pair)]);
      if (way == 0) continue;
      if (box_.tilt) fail(line_, "the box is tilted by more than one of xy, xz and yz");
      box_.tilt = Tilt::ofPair(pair, way);
    }
  } else if (words.back() == "avec" || words.back() == "bvec" || words.back() == "cvec") {
    fail(line_,
         "the box of a general triclinic file cannot be read; xlo xhi, ... and xy xz yz can");
  }
}

void DataFile::readAtom(const Words& words) {
  const std::size_t n = style_->count;
  if (words.size() != n && words.size() != n + 3)
    fail(line_, format("an atom of the style %s has %zu columns (%s), or three image flags more, "
                       "not %zu",
                       style_->name, n, style_->columns, words.size()));
  Atom atom{whole(words[0]), line_, static_cast<int>(whole(words[2])), {}};
  if (atom.id < 1) fail(line_, "the id of an atom is below 1");
  if (atom.type < 1 || atom.type > types())
    fail(line_, format("the type of an atom is %d, but the header has %lld atom types", atom.type,
                       static_cast<long long>(std::max<std::int64_t>(0, types()))));
  const std::size_t x = style_->x;
  atom.x = {scale_ * number(words[x]), scale_ * number(words[x + 1]),
            scale_ * number(words[x + 2])};
  flagged_ = flagged_ || words.size() > n;
  for (std::size_t d = 0; d < words.size() - n; ++d)
    atom.image[d] = static_cast<std::int32_t>(whole(words[n + d]));
  for (std::size_t k = 0; k < 2 && style_->neighbours; ++k)
    atom.named[k] = whole(words[style_->neighbours + k]);
  if (!places_.emplace(atom.id, static_cast<int>(atoms_.size())).second)
    fail(line_, format("the atom %lld comes twice", static_cast<long long>(atom.id)));
  atoms_.push_back(atom);
}

void DataFile::readBond(const Words& words) {
  if (words.size() != 4)
    fail(line_, format("a bond has 4 columns (id type atom atom), not %zu", words.size()));
  bonds_.push_back({line_, whole(words[2]), whole(words[3])});
}

void DataFile::requireCounts() const {
  const std::pair<const char*, std::size_t> found[] = {{"atoms", atoms_.size()},
                                                       {"bonds", bonds_.size()}};
  for (const auto& [what, count] : found) {
    const std::int64_t said = counts_.at(what);
    if (said < 0) throw InputError(name_ + ": its header does not say how many atoms there are");
    if (said != static_cast<std::int64_t>(count))
      throw InputError(format("%s: its header says %lld %s, but it has %zu", name_.c_str(),
                              static_cast<long long>(said), what, count));
  }
  if (atoms_.empty()) throw InputError(name_ + ": holds no atoms");
  for (std::size_t d = 0; d < 3; ++d)
    if (!(box_.lower[d] < box_.upper[d]))
      throw InputError(
          format("%s: its header has no `%clo %chi`", name_.c_str(), "xyz"[d], "xyz"[d]));
}

int DataFile::placeOf(std::int64_t id, int line) const {
  const auto at = places_.find(id);
  if (at == places_.end()) fail(line, format("there is no atom %lld", static_cast<long long>(id)));
  return at->second;
}

void DataFile::tie(int line, int a, int b) {
  for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
    Atom& atom = atoms_[static_cast<std::size_t>(one)];
    const auto id = static_cast<long long>(atom.id);
    if (one == other) fail(line, format("the atom %lld is tied to itself", id));
    if (atom.tied[0] == other || atom.tied[1] == other)
      fail(line, format("the atoms %lld and %lld are tied twice", id,
                        static_cast<long long>(atoms_[static_cast<std::size_t>(other)].id)));
    if (atom.tied[1] >= 0)
      fail(line, format("the atom %lld has a third bond, but fibres have no branches", id));
    atom.tied[atom.tied[0] < 0 ? 0 : 1] = other;
  }
}

/// Ties an atom to those that it names, which must name it, too.
void DataFile::tieNamed(int a) {
  const Atom& atom = atoms_[static_cast<std::size_t>(a)];
  if (atom.named[0] > 0 && atom.named[0] == atom.named[1])
    fail(atom.line, "both neighbours of the atom are the same");
  for (const std::int64_t id : atom.named) {
    if (id < 1) continue;  // an end
    const int b = placeOf(id, atom.line);
    const auto& back = atoms_[static_cast<std::size_t>(b)].named;
    if (back[0] != atom.id && back[1] != atom.id)
      fail(atom.line, format("the atom %lld names %lld as its neighbour, which does not name it",
                             static_cast<long long>(atom.id), static_cast<long long>(id)));
    if (atom.id <= id) tie(atom.line, a, b);
  }
}

void DataFile::tie() {
  if (style_->neighbours && !bonds_.empty())
    throw InputError(name_ +
                     ": atoms of the style mesont name their neighbours, and have no Bonds");
  for (const Tie& bond : bonds_)
    tie(bond.line, placeOf(bond.first, bond.line), placeOf(bond.second, bond.line));
  for (int a = 0; a < static_cast<int>(atoms_.size()) && style_->neighbours; ++a) tieNamed(a);
  for (const Atom& atom : atoms_)
    if (atom.tied[0] < 0)
      fail(atom.line, format("the atom %lld has no bond, but a fibre needs two atoms at least",
                             static_cast<long long>(atom.id)));
}

std::vector<std::pair<std::vector<int>, bool>> DataFile::chains() const {
  std::vector<int> order(atoms_.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<int>(k);
  auto atom = [&](int k) -> const Atom& { return atoms_[static_cast<std::size_t>(k)]; };
  std::ranges::sort(order, {}, [&](int k) { return atom(k).id; });
  std::vector<std::pair<std::vector<int>, bool>> chains;
  std::vector<bool> taken(atoms_.size(), false);
  for (const bool closed : {false, true})
    for (const int start : order) {
      if (taken[static_cast<std::size_t>(start)] || (!closed && atom(start).tied[1] >= 0)) continue;
      auto way = atom(start).tied;
      if (closed && atom(way[1]).id < atom(way[0]).id) std::swap(way[0], way[1]);
      std::vector<int> chain{start};
      for (int before = start, at = way[0]; at >= 0 && at != start;) {
        chain.push_back(at);
        const auto& tied = atom(at).tied;
        before = std::exchange(at, tied[0] == before ? tied[1] : tied[0]);
      }
      for (const int k : chain) taken[static_cast<std::size_t>(k)] = true;
      chains.emplace_back(std::move(chain), closed);
    }
  return chains;
}

CentreLine DataFile::lineThrough(const std::vector<int>& chain, bool closed, const Box& box,
                                 int& otherwise) const {
  const MinimumImage nearest(box);
  auto atom = [&](std::size_t k) -> const Atom& {
    return atoms_[static_cast<std::size_t>(chain[k % chain.size()])];
  };
  auto placed = [&](const Atom& a) {
    const double x[3] = {a.x.x, a.x.y, a.x.z};
    return box.unwrapped(x, a.image.data());
  };
  CentreLine line;
  line.closed = closed;
  Vec3d x = placed(atom(0));
  for (std::size_t k = 0; k < chain.size(); ++k) {
    line.points.push_back(x);
    if (k + 1 == chain.size() && !closed) break;
    const Vec3d said = placed(atom(k + 1)) - placed(atom(k)), way = nearest(said);
    if (flagged_ && !closed && norm(said - way) > 1e-6 * norm(said)) ++otherwise;
    if (norm(way) == 0)
      fail(atom(k + 1).line,
           format("the atoms %lld and %lld, which are tied, lie at one place",
                  static_cast<long long>(atom(k).id), static_cast<long long>(atom(k + 1).id)));
    x += way;
  }
  // What is left is round-off: the line closes after a whole number of boxes.
  const Vec3d round = x - line.points[0];
  if (closed) line.round = round - nearest(round);
  return line;
}

int DataFile::kindOf(const std::vector<int>& chain, const std::vector<int>& kinds) const {
  auto kind = [&](int place) {
    return kinds[static_cast<std::size_t>(atoms_[static_cast<std::size_t>(place)].type - 1)];
  };
  for (const int place : chain)
    if (kind(place) != kind(chain[0])) {
      const Atom& atom = atoms_[static_cast<std::size_t>(place)];
      fail(
          atom.line,
          format("the atom %lld is of another kind (-lammps_kinds) than the atom %lld of its fibre",
                 static_cast<long long>(atom.id),
                 static_cast<long long>(atoms_[static_cast<std::size_t>(chain[0])].id)));
    }
  return kind(chain[0]);
}

/// The kind of each type of atoms.
std::vector<int> kindsOfTypes(const Kinds& known, const std::vector<std::string>& names,
                              std::int64_t types) {
  std::vector<int> kinds(static_cast<std::size_t>(types), 0);
  if (names.empty()) return kinds;
  if (names.size() != 1 && names.size() != kinds.size())
    throw InputError(format("-lammps_kinds: needs one name, or one for each of the %zu atom types",
                            kinds.size()));
  for (std::size_t k = 0; k < kinds.size(); ++k)
    kinds[k] = kindNumber(known, "-lammps_kinds", names[std::min(k, names.size() - 1)]);
  return kinds;
}

}  // namespace

std::unique_ptr<Scene> makeLammpsScene(Options& options, const SceneContext& context,
                                       SceneUse use) {
  OptionSection s(options, "Scene: lammps", use != SceneUse::none, "-scene is not lammps");
  const std::string name = s.as(Role::run).text(
      "lammps_file", "", "data file of LAMMPS, whose bonds tie atoms in chains");
  std::vector<std::string> choices{"comment"};
  for (const Style& style : styles) choices.push_back(style.name);
  const std::string style = s.choice("lammps_style", "comment", choices,
                                     "style of the atoms; as the comment behind Atoms says");
  const double scale = s.real("lammps_scale", 1.0, "", "unit of length of the file", positive);
  const auto periodic = s.flags3("lammps_periodic", "1,1,1", "is the file's box periodic?");
  const auto names =
      s.words("lammps_kinds", "kind of all atoms, or one for each atom type; the first of -kinds");
  const bool shaped = readShaped(s, "lammps");
  if (use != SceneUse::start) return nullptr;
  if (name.empty()) throw InputError("-scene lammps needs -lammps_file NAME");
  DataFile file(name, scale, styleOf(style));
  file.read(readSceneText(context.comm, "lammps", name));
  file.tie();
  Box box = file.box();
  box.periodic = periodic.value_or(std::array{true, true, true});
  if (box.tilt && !(box.periodic[static_cast<std::size_t>(box.tilt.along)] &&
                    box.periodic[static_cast<std::size_t>(box.tilt.across)]))
    throw InputError(name + ": its box is tilted along directions that -lammps_periodic opens");
  const std::vector<int> ofTypes = kindsOfTypes(context.kinds, names, file.types());
  std::vector<CentreLine> lines;
  std::vector<int> kinds;
  int otherwise = 0;
  for (const auto& [chain, closed] : file.chains()) {
    lines.push_back(file.lineThrough(chain, closed, box, otherwise));
    kinds.push_back(file.kindOf(chain, ofTypes));
  }
  Laying laying{"lammps",
                KindMix::given(context, static_cast<std::int64_t>(lines.size()),
                               [&](std::int64_t f) { return kinds[static_cast<std::size_t>(f)]; })};
  laying.box = box;
  if (box.periodic == std::array{true, true, true})
    laying.space = box.length(0) * box.length(1) * box.length(2);
  laying.shaped = shaped;
  laying.file = name;
  if (otherwise > 0)
    laying.warning = format(
        "%d bonds lead to the nearest images of their atoms, as in LAMMPS, and by their image "
        "flags "
        "elsewhere; if those are longer than half the box, open it (-lammps_periodic 0,0,0)",
        otherwise);
  return layScene(context, layOnCentreLines(std::move(laying), lines));
}

}  // namespace nanoweft
