#include "nanoweft/base/options.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numeric>
#include <sstream>
#include <string_view>
#include <utility>

#include "nanoweft/base/canonical.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/petsc_names.hpp"

namespace nanoweft {

namespace {

/// The suffixes of options whose first part is the user's (boundary.cpp).
constexpr std::string_view boundarySuffixes[] = {"_region",   "_group", "_fix",   "_fix_rotation",
                                                 "_velocity", "_ramp",  "_force", "_torque",
                                                 "_spin",     "_axis",  "_centre"};

int editDistance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i) + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int substituted = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// Beyond it, and below its inverse, products of a few numbers have no place in a double.
constexpr double mostReal = 1e60;

double parseReal(const std::string& name, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value))
    throw InputError(format("-%s '%s': expected a number", name.c_str(), text.c_str()));
  if (value != 0 && (std::abs(value) > mostReal || std::abs(value) < 1.0 / mostReal))
    throw InputError(format("-%s %s: numbers here are 0 or from %g to %g in size", name.c_str(),
                            text.c_str(), 1.0 / mostReal, mostReal));
  return value;
}

long parseInteger(const std::string& name, const std::string& text, long lower, long upper) {
  const double real = parseReal(name, text);  // so that 1e6 may be written for a step count
  if (real != std::floor(real))
    throw InputError(format("-%s '%s': expected a whole number", name.c_str(), text.c_str()));
  if (std::abs(real) > 9e15)
    throw InputError(
        format("-%s %s: must be from %ld to %ld", name.c_str(), text.c_str(), lower, upper));
  const auto value = static_cast<long>(real);
  if (value < lower || value > upper)
    throw InputError(format("-%s %ld: must be from %ld to %ld", name.c_str(), value, lower, upper));
  return value;
}

bool parseFlag(const std::string& name, std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  if (text.empty() || text == "1" || text == "true" || text == "yes" || text == "on") return true;
  if (text == "0" || text == "false" || text == "no" || text == "off") return false;
  throw InputError(format("-%s '%s': expected true or false (1 or 0)", name.c_str(), text.c_str()));
}

std::vector<std::string> split(const std::string& text, char separator = ',') {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

void checkBounds(const std::string& name, double value, const Bounds& bounds) {
  const bool low = bounds.openLower ? !(value > bounds.lower) : !(value >= bounds.lower);
  if (!low && value <= bounds.upper) return;
  std::string range;
  if (std::isfinite(bounds.lower))
    range = format("%s %g", bounds.openLower ? "above" : "at least", bounds.lower);
  if (std::isfinite(bounds.upper))
    range += format("%sat most %g", range.empty() ? "" : " and ", bounds.upper);
  throw InputError(format("-%s %g: must be %s", name.c_str(), value, range.c_str()));
}

std::string shownReal(double value) {
  return format("%.10g", value);
}

std::vector<double> parseReals(const std::string& name, const std::string& text, int count) {
  const auto parts = split(text);
  if (count > 0 && static_cast<int>(parts.size()) != count)
    throw InputError(format("-%s '%s': expected %d numbers separated by commas", name.c_str(),
                            text.c_str(), count));
  std::vector<double> numbers;
  for (const std::string& part : parts) numbers.push_back(parseReal(name, part));
  return numbers;
}

std::array<bool, 3> parseFlags3(const std::string& name, const std::string& text) {
  const auto parts = split(text);
  if (parts.size() != 3 || std::ranges::any_of(parts, &std::string::empty))
    throw InputError(format("-%s '%s': expected three of 0 and 1 separated by commas", name.c_str(),
                            text.c_str()));
  return {parseFlag(name, parts[0]), parseFlag(name, parts[1]), parseFlag(name, parts[2])};
}

/// The default that -help shows, where it is a value and no description ("of the preset").
template <class Parse>
auto shownValue(const std::string& shown, const Parse& parse)
    -> std::optional<decltype(parse(shown, shown))> {
  try {
    return parse("", shown);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// The name that differs least, in at most a quarter of the word's letters: short words are alike
/// by chance.
std::string nearest(const std::vector<std::string>& names, const std::string& word) {
  int best = static_cast<int>(word.size() / 4) + 1;
  std::string found;
  for (const std::string& name : names)
    if (const int d = editDistance(word, name); d < best) {
      best = d;
      found = name;
    }
  return found;
}

/// Has the name all parts of the word, in whatever order (-strain_max), or their beginnings?
bool hasParts(const std::string& name, const std::string& word) {
  const auto parts = split(name, '_');
  return std::ranges::all_of(split(word, '_'), [&](const std::string& wanted) {
    return std::ranges::any_of(parts, [&](const std::string& part) {
      // One or two letters begin too many words.
      return wanted.size() > 2 ? part.starts_with(wanted) : part == wanted;
    });
  });
}

/// Known names that an unknown one may mean, at most three, or none.
std::vector<std::string> alike(const std::vector<std::string>& names, const std::string& word) {
  if (const std::string name = nearest(names, word); !name.empty()) return {name};
  std::vector<std::string> found;
  std::ranges::copy_if(names, std::back_inserter(found),
                       [&](const std::string& name) { return hasParts(name, word); });
  std::ranges::stable_sort(found, {}, [&](const std::string& name) {
    return std::pair(!name.starts_with(word), name.size());
  });
  found.resize(std::min<std::size_t>(found.size(), 3));
  // Behind the names of kinds.
  for (std::size_t at = word.find('_'); found.empty() && at < word.size();
       at = word.find('_', at + 1))
    if (const std::string name = nearest(names, word.substr(at + 1)); !name.empty())
      found.push_back(name);
  return found;
}

}  // namespace

void checkPrefixes(const char* option, const char* thing, const std::vector<std::string>& names,
                   bool joined) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    // PETSc finds -a_velocity for -a_1_velocity.
    const auto follows = [&](std::size_t k) {
      const auto c = static_cast<unsigned char>(name[k]);
      if (joined && c == '_')
        return k + 1 < name.size() && std::isalpha(static_cast<unsigned char>(name[k + 1])) != 0;
      return std::isalnum(c) != 0;
    };
    bool fits = std::isalpha(static_cast<unsigned char>(name[0]));
    for (std::size_t k = 1; k < name.size(); ++k) fits = fits && follows(k);
    if (!fits)
      throw InputError(
          format("%s: '%s' cannot name %s; a name is a letter and then letters or digits%s", option,
                 name.c_str(), thing, joined ? ", or _ with a letter behind it" : ""));
    // PETSc tells no capital from a small letter in the names of options.
    std::string small = name;
    std::ranges::transform(small, small.begin(), [](unsigned char c) { return std::tolower(c); });
    if (beginsPetscOptions(small))
      throw InputError(format("%s: '%s' cannot name %s, since -%s_... are options of PETSc", option,
                              name.c_str(), thing, small.c_str()));
    if (!seen.insert(small).second)
      throw InputError(format("%s: '%s' stands there twice (capitals are small letters here)",
                              option, name.c_str()));
  }
}

Options::Options() {
  PetscBool found;
  petsc(PetscOptionsHasName(nullptr, nullptr, "-help", &found));
  help_ = found == PETSC_TRUE;
}

void Options::printHelp(MPI_Comm comm) const {
  for (const Topic& topic : topics_) {
    PetscPrintf(comm, "\n%s\n", topic.title.c_str());
    for (const Entry& e : topic.entries) {
      const std::string unit = e.unit.empty() ? "" : " [" + e.unit + "]";
      PetscPrintf(comm, "  -%s <%s>%s: %s\n", e.name.c_str(), e.value.c_str(), unit.c_str(),
                  e.help.c_str());
    }
  }
  PetscPrintf(comm, "\n");
}

void Options::refuseUnknown() const {
  PetscInt count;
  char** names;
  char** values;
  petsc(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  std::vector<std::string> known;
  for (const Topic& topic : topics_)
    for (const Entry& e : topic.entries) known.push_back(e.name);
  std::string problem;
  for (PetscInt i = 0; i < count && problem.empty(); ++i) {
    const std::string name = names[i];
    if (belongsToPetsc(name)) continue;
    problem = format("unknown option -%s", names[i]);
    const auto suffix = std::ranges::find_if(boundarySuffixes,
                                             [&](std::string_view e) { return name.ends_with(e); });
    if (suffix != std::end(boundarySuffixes) && nearest(known, name).empty()) {
      problem += format("; a boundary condition must be named: -bc %s",
                        name.substr(0, name.size() - suffix->size()).c_str());
      continue;
    }
    const auto meant = alike(known, name);
    for (const std::string& option : meant)
      problem += (&option != &meant[0] ? ", -"
                  : meant.size() == 1  ? "; the nearest known one is -"
                                       : "; known ones like it: -") +
                 option;
    if (meant.empty()) problem += "; -help lists all";
  }
  petsc(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  for (const auto& [name, reason] : leftOut_)
    if (problem.empty() && !used_.contains(name))
      problem = format("-%s is not used by this run: %s", name.c_str(), reason.c_str());
  for (const auto& [name, value] : recorded_)
    if (problem.empty() && !readings_.contains(name))
      problem = format(
          "-restart %s: it was made with -%s %s, which this nanoweft does not know; go on with the "
          "version that wrote it",
          checkpoint_.c_str(), name.c_str(), value.c_str());
  if (!problem.empty()) throw InputError(problem);
}

void Options::goOnFrom(const std::string& checkpoint, const std::string& recorded,
                       const std::map<std::string, std::string>& inForce) {
  checkpoint_ = checkpoint;
  inForce_ = inForce;
  std::istringstream lines(recorded);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = line.find(' ');
    if (line[0] != '-' || space == std::string::npos || space < 2 || space + 1 == line.size())
      throw InputError(format("-restart %s: '%s' in its attribute options of /run is no option",
                              checkpoint.c_str(), line.c_str()));
    recorded_[line.substr(1, space - 1)] = line.substr(space + 1);
  }
}

std::optional<std::string> Options::recorded(const std::string& name) const {
  const auto it = recorded_.find(name);
  return it != recorded_.end() ? std::optional(it->second) : std::nullopt;
}

std::string Options::resultOptions(const std::set<std::string>& always) const {
  std::map<std::string, std::string> values = recorded_;
  for (const auto& [name, r] : readings_) {
    if (r.role == Role::run) continue;
    if (!checkpoint_.empty()) {
      // What was in force by default and is given now as the same is nothing new.
      const auto before = inForce_.find(name);
      const bool same = !recorded_.contains(name) && before != inForce_.end() && r.value &&
                        before->second == *r.value;
      if (r.role == Role::step && r.byUser && !same) values[name] = *r.value;
    } else if (r.value && (r.value != r.fallback || countWhenGiven_.contains(name))) {
      values[name] = *r.value;
    } else if (always.contains(name) && r.fallback) {
      values[name] = r.value.value_or(*r.fallback);
    }
  }
  std::string text;
  for (const auto& [name, value] : values) text += "-" + name + " " + value + "\n";
  return text;
}

OptionPrefix::OptionPrefix(Options& options, const std::string& prefix)
    : options_(options), before_(options.prefix_) {
  options.prefix_ = prefix.empty() ? "" : prefix + "_";
}

OptionPrefix::~OptionPrefix() {
  options_.prefix_ = before_;
}

OptionSection::OptionSection(Options& options, std::string title, bool active, std::string reason)
    : options_(options),
      prefix_(options.prefix_),
      topic_(0),
      active_(active),
      reason_(std::move(reason)) {
  for (; topic_ < options.topics_.size(); ++topic_)
    if (options.topics_[topic_].title == title) return;
  options.topics_.push_back({std::move(title), {}});
}

OptionSection OptionSection::as(Role role) const {
  OptionSection other = *this;
  other.role_ = role;
  return other;
}

OptionSection OptionSection::family() const {
  OptionSection other = *this;
  other.documented_ = false;
  return other;
}

std::string OptionSection::inForce(const std::string& name) const {
  if (prefix_.empty()) return name;
  ownText(name);  // PETSc then does not count it as unused where all kinds have their own
  const bool own = ownText(prefix_ + name).has_value();
  return own || options_.recorded(prefix_ + name) ? prefix_ + name : name;
}

bool OptionSection::given(const std::string& generalName) const {
  const std::string name = inForce(generalName);
  options_.countWhenGiven_.insert(name);
  const bool old = role_ != Role::run && options_.recorded(name);
  // In a restart a result's options are those of the checkpoint; `read` compares the user's.
  if (!options_.checkpoint_.empty() && role_ == Role::result) return old;
  PetscBool found;
  petsc(PetscOptionsHasName(nullptr, nullptr, ("-" + name).c_str(), &found));
  return old || found == PETSC_TRUE;
}

void OptionSection::document(const std::string& name, const char* shown, const char* unit,
                             const char* help) {
  auto& entries = options_.topics_[topic_].entries;
  if (std::ranges::none_of(entries, [&](const Options::Entry& e) { return e.name == name; }))
    entries.push_back({name, shown, unit, help});
}

std::optional<std::string> OptionSection::ownText(const std::string& name) const {
  // PetscOptionsGetString would cut a long value.
  const char* value = nullptr;
  PetscBool found;
  petsc(PetscOptionsFindPair(nullptr, nullptr, ("-" + name).c_str(), &value, &found));
  if (!found) return std::nullopt;
  return std::string(value ? value : "");
}

template <class T, class Parse>
std::optional<T> OptionSection::read(const Question& question, const std::optional<T>& fallback,
                                     const Parse& parse) {
  if (documented_)
    document(question.name, question.shown.c_str(), question.unit.c_str(), question.help.c_str());
  const std::string name = inForce(question.name);
  const Question q{name, question.shown, question.unit, question.help};
  const auto own = ownText(q.name);
  const auto old = role_ != Role::run ? options_.recorded(q.name) : std::nullopt;
  if (active_ && (own || old)) options_.used_.insert(name);
  if (!active_ && !prefix_.empty() && (own || old)) {
    // Other kinds, or this one with others, may use it; `refuseUnknown` looks when all are read.
    options_.leftOut_[name] = reason_;
    return fallback;
  }
  if (!active_ && old)
    throw InputError(format("-restart %s: it was made with -%s %s, which is not used: %s",
                            options_.checkpoint_.c_str(), q.name.c_str(), old->c_str(),
                            reason_.c_str()));
  Options::Reading reading;
  reading.role = role_;
  reading.byUser = own.has_value();
  std::optional<T> value;
  if (own && active_) value = parse(q.name, *own);
  if (value) reading.value = canonical(*value);
  if (fallback) reading.fallback = canonical(*fallback);
  if (own) agreeWithCheckpoint(q, *own, reading);
  if (own && !active_)
    throw InputError(format("-%s is not used by this run: %s", q.name.c_str(), reason_.c_str()));
  if (!own && old) {
    value = parse(q.name, *old);
    reading.value = canonical(*value);
  }
  // Where one name serves several kinds of different defaults, its value is no default.
  if (const auto before = options_.readings_.find(q.name);
      before != options_.readings_.end() && before->second.fallback != reading.fallback)
    reading.fallback.reset();
  if (active_) options_.readings_[q.name] = reading;
  return value;
}

void OptionSection::agreeWithCheckpoint(const Question& q, const std::string& own,
                                        const Options::Reading& reading) const {
  if (options_.checkpoint_.empty() || role_ != Role::result) return;
  const auto old = options_.recorded(q.name);
  std::string made;
  if (old) {
    if (reading.value == old) return;
    made = "with " + *old;
  } else if (!active_ || q.shown.empty() || q.shown == "none") {
    made = "without it";
  } else {
    if (reading.fallback && reading.value == reading.fallback) return;
    made = "with its default, " + q.shown;
  }
  throw InputError(format(
      "-%s%s: the checkpoint %s was made %s; a restart goes on with the same (start a new stage "
      "with -scene file -scene_file %s)",
      q.name.c_str(), own.empty() ? "" : (" " + own).c_str(), options_.checkpoint_.c_str(),
      made.c_str(), options_.checkpoint_.c_str()));
}

double OptionSection::real(const std::string& name, double fallback, const char* unit,
                           const char* help, Bounds bounds) {
  return read<double>({name, shownReal(fallback), unit, help}, fallback,
                      [&](const std::string& as, const std::string& text) {
                        const double value = parseReal(as, text);
                        checkBounds(as, value, bounds);
                        return value;
                      })
      .value_or(fallback);
}

std::optional<double> OptionSection::maybeReal(const std::string& name, const char* shown,
                                               const char* unit, const char* help, Bounds bounds) {
  return read<double>({name, shown, unit, help}, std::nullopt,
                      [&](const std::string& as, const std::string& text) {
                        const double value = parseReal(as, text);
                        checkBounds(as, value, bounds);
                        return value;
                      });
}

long OptionSection::integer(const std::string& name, long fallback, const char* help, long lower,
                            long upper) {
  return read<long>({name, std::to_string(fallback), "", help}, fallback,
                    [&](const std::string& as, const std::string& text) {
                      return parseInteger(as, text, lower, upper);
                    })
      .value_or(fallback);
}

std::optional<long> OptionSection::maybeInteger(const std::string& name, const char* shown,
                                                const char* help, long lower, long upper) {
  return read<long>({name, shown, "", help}, std::nullopt,
                    [&](const std::string& as, const std::string& text) {
                      return parseInteger(as, text, lower, upper);
                    });
}

bool OptionSection::flag(const std::string& name, bool fallback, const char* help) {
  return read<bool>(
             {name, canonical(fallback), "", help}, fallback,
             [&](const std::string& as, const std::string& text) { return parseFlag(as, text); })
      .value_or(fallback);
}

std::string OptionSection::text(const std::string& name, const std::string& fallback,
                                const char* help) {
  return read<std::string>({name, fallback.empty() ? "none" : fallback, "", help}, fallback,
                           [&](const std::string& as, const std::string& text) {
                             if (text.empty())
                               throw InputError(format("-%s needs a value", as.c_str()));
                             return text;
                           })
      .value_or(fallback);
}

namespace {

std::string barred(const std::vector<std::string>& choices) {
  std::string list;
  for (const std::string& c : choices) list += (list.empty() ? "" : "|") + c;
  return list;
}

}  // namespace

std::string OptionSection::choice(const std::string& name, const std::string& fallback,
                                  const std::vector<std::string>& choices, const char* help) {
  const std::string list = barred(choices);
  return read<std::string>({name, fallback, "", help + (" (" + list + ")")}, fallback,
                           [&](const std::string& as, const std::string& text) {
                             if (std::ranges::find(choices, text) == choices.end())
                               throw InputError(format("-%s '%s': must be one of %s", as.c_str(),
                                                       text.c_str(), list.c_str()));
                             return text;
                           })
      .value_or(fallback);
}

std::vector<std::string> OptionSection::choices(const std::string& name,
                                                const std::vector<std::string>& fallback,
                                                const std::vector<std::string>& choices,
                                                const char* help) {
  const std::string list = barred(choices);
  auto parse = [&](const std::string& as, const std::string& text) {
    const std::vector<std::string> parts = split(text);
    for (auto part = parts.begin(); part != parts.end(); ++part) {
      if (std::ranges::find(choices, *part) == choices.end())
        throw InputError(format("-%s '%s': must be one of %s%s", as.c_str(), text.c_str(),
                                list.c_str(), parts.size() > 1 ? ", or several of these" : ""));
      if (std::find(parts.begin(), part, *part) != part)
        throw InputError(
            format("-%s '%s': %s stands there twice", as.c_str(), text.c_str(), part->c_str()));
    }
    return parts;
  };
  return read<std::vector<std::string>>({name, canonical(fallback), "", help + (" (" + list + ")")},
                                        fallback, parse)
      .value_or(fallback);
}

std::optional<std::vector<double>> OptionSection::reals(const std::string& name, int count,
                                                        const char* shown, const char* unit,
                                                        const char* help) {
  auto parse = [&](const std::string& as, const std::string& text) {
    return parseReals(as, text, count);
  };
  return read<std::vector<double>>({name, shown, unit, help}, shownValue(shown, parse), parse);
}

std::optional<std::array<bool, 3>> OptionSection::flags3(const std::string& name, const char* shown,
                                                         const char* help) {
  auto parse = [](const std::string& as, const std::string& text) { return parseFlags3(as, text); };
  return read<std::array<bool, 3>>({name, shown, "", help}, shownValue(shown, parse), parse);
}

std::vector<std::string> OptionSection::words(const std::string& name, const char* help) {
  return read<std::vector<std::string>>(
             {name, "none", "", help}, std::nullopt,
             [&](const std::string& as, const std::string& text) {
               auto parts = split(text);
               for (const std::string& part : parts)
                 if (part.empty())
                   throw InputError(format("-%s '%s': an empty name", as.c_str(), text.c_str()));
               return parts;
             })
      .value_or(std::vector<std::string>());
}

}  // namespace nanoweft
