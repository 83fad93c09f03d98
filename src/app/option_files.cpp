#include "nanoweft/app/option_files.hpp"

#include <petscsys.h>
#include <strings.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <new>
#include <set>
#include <utility>

#include "nanoweft/app/signals.hpp"
#include "nanoweft/app/text_input.hpp"
#include "nanoweft/app/yaml_options.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr std::size_t largestFile = 64 << 20;
constexpr int deepestNesting = 20;
constexpr const char* wrongFileHint = "; option files are given with -options_file NAME";

bool same(const std::string& a, const char* b) {
  return strcasecmp(a.c_str(), b) == 0;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string shown(const std::string& word) {
  return word.size() > 40 ? word.substr(0, 40) + "..." : word;
}

bool isYaml(const std::string& file, const std::string& text) {
  const std::string name = lower(file);
  return name.ends_with(".yaml") || name.ends_with(".yml") || name.ends_with(".json") ||
         text.starts_with("%YAML ") || text.starts_with("---");
}

/// Follows the options of rank 0 through all sources.
class Collector {
 public:
  GivenOptions take() { return std::move(options_); }

  /// A file that need not be there.
  void resourceFile(const std::string& file) {
    std::error_code code;
    if (!std::filesystem::exists(file, code) || std::filesystem::is_directory(file, code)) return;
    readFile(file, file, false);
  }

  void yaml(const std::string& text, const std::string& where) {
    for (const YamlOption& o : parseYaml(text, where))
      give({"-" + o.name, false}, Word{o.value, true}, where + format(": line %d", o.line));
  }

  /// Names and values after each other, as on a command line. `hint` ends the message about a
  /// word that is no option.
  void words(const std::vector<Word>& words, const std::string& where, const std::string& hint) {
    for (std::size_t k = 0; k < words.size(); ++k) {
      const Word& name = words[k];
      if (!isName(name)) refuse(where, "'" + shown(name.text) + "' is no option" + hint);
      const bool valued = k + 1 < words.size() && !isName(words[k + 1]) && !isSwitch(name.text);
      give(name, valued ? std::optional(words[k + 1]) : std::nullopt, where);
      k += valued;
    }
    requireClosedPrefixes(0, where);
  }

 private:
  [[noreturn]] static void refuse(const std::string& where, const std::string& reason) {
    throw InputError(where.empty() ? reason : where + ": " + reason);
  }

  static bool isName(const Word& word) { return !word.quoted && isOptionName(word.text); }
  static bool isSwitch(const std::string& name) { return same(name, "-prefix_pop"); }

  void requireClosedPrefixes(std::size_t count, const std::string& where) {
    if (prefixes_.size() > count)
      refuse(where, "-prefix_push " + prefixes_.back() + " without its -prefix_pop");
  }

  void readFile(const std::string& file, const std::string& where, bool forceYaml) {
    if (static_cast<int>(open_.size()) > deepestNesting)
      refuse(where, format("files are nested more than %d deep", deepestNesting));
    TextFile input(file, where);
    const FileKey key = input.key();
    for (const auto& [name, other] : open_)
      if (other == key) refuse(where, "files that include each other (" + name + ")");
    // A second reading would find nothing, or wait for ever.
    if (!key.again && std::ranges::find(drained_, key) != drained_.end())
      refuse(where, "has been read before and can be read once only");
    if (!key.again) drained_.push_back(key);
    const std::string text = input.read(largestFile);
    total_ += text.size();
    if (total_ > largestFile) refuse(where, "all files of options are larger than 64 MB");
    open_.emplace_back(file, key);
    const std::size_t prefixes = prefixes_.size(), before = std::exchange(pushedBefore_, prefixes);
    if (forceYaml || isYaml(file, text))
      yaml(text, where);
    else
      lines(splitLines(text, where), where);
    requireClosedPrefixes(prefixes, where);
    pushedBefore_ = before;
    open_.pop_back();
  }

  void lines(const std::vector<TextLine>& lines, const std::string& where) {
    // PETSc's aliases hold for their whole file.
    for (const TextLine& line : lines)
      if (same(line.words[0].text, "alias")) alias(line, where);
    for (const TextLine& line : lines) {
      if (same(line.words[0].text, "alias")) continue;
      const std::string place = where + format(": line %d", line.number);
      const auto& w = line.words;
      if (!isName(w[0]))
        refuse(place, "'" + shown(w[0].text) + "' is no option (options begin with -)");
      if (w.size() > 1 && isName(w[1]))
        refuse(place,
               "'" + shown(w[1].text) + "' after " + shown(w[0].text) + "; one option on a line");
      if (w.size() > 2)
        refuse(place, "'" + shown(w[2].text) +
                          "' after the value; one option on a line, and a value with blanks "
                          "stands in quotes");
      give(w[0], w.size() > 1 ? std::optional(w[1]) : std::nullopt, place);
    }
  }

  void alias(const TextLine& line, const std::string& where) {
    const auto& w = line.words;
    if (w.size() != 3 || !isName(w[1]) || !isName(w[2]))
      refuse(where + format(": line %d", line.number), "expected 'alias -new_name -option'");
    aliases_[lower(w[1].text)] = w[2].text;
  }

  static void checkName(const std::string& name, const std::string& where) {
    if (const auto at = name.find('='); at != std::string::npos)
      refuse(where, "'" + shown(name) + "': a blank and no = stands before the value: " +
                        shown(name.substr(0, at)) + " " + shown(name.substr(at + 1)));
    if (name.starts_with("--"))
      refuse(where, "'" + shown(name) + "' is no option; options begin with one -");
    if (name.find("\xc2\xa0") != std::string::npos)
      refuse(where, "'" + shown(name) + "': a no-break space (of a web page?) is no blank");
    if (name.size() > 500) refuse(where, "'" + shown(name) + "': the name is too long");
  }

  void give(const Word& given, const std::optional<Word>& word, const std::string& where) {
    std::string name = given.text;
    if (name == "--help" || name == "-h") {
      options_.briefHelp = true;
      name = "-help";
    }
    if (name == "--version" || same(name, "-version")) {
      options_.version = true;
      return;
    }
    checkName(name, where);
    if (follow(name, word, where)) return;
    std::string prefix;
    for (const std::string& p : prefixes_) prefix += p;
    name = "-" + prefix + name.substr(1);
    if (const auto it = aliases_.find(lower(name)); it != aliases_.end()) name = it->second;
    if (!isOptionName(name)) refuse(where, "'" + shown(name) + "' is no option");
    // The files that it leaves out come before all others.
    if (same(name, "-skip_petscrc") && !where.empty())
      refuse(where, "-skip_petscrc counts on the command line only");
    options_.list.push_back({name, word ? std::optional(word->text) : std::nullopt});
  }

  /// Follows options that bring further options or change their names; false for any other.
  bool follow(const std::string& name, const std::optional<Word>& word, const std::string& where) {
    const bool file = same(name, "-options_file"), yamlFile = same(name, "-options_file_yaml"),
               yamlText = same(name, "-options_string_yaml"), push = same(name, "-prefix_push");
    if (same(name, "-prefix_pop")) {
      if (prefixes_.size() <= pushedBefore_)
        refuse(where, "-prefix_pop without a -prefix_push in the same file");
      prefixes_.pop_back();
      return true;
    }
    if (!file && !yamlFile && !yamlText && !push) return false;
    if (!word || word->text.empty())
      refuse(where, name + (push       ? " needs a prefix"
                            : yamlText ? " needs a text"
                                       : " needs the name of a file"));
    if (push)
      prefixes_.push_back(word->text);
    else if (yamlText)
      yaml(word->text, (where.empty() ? "" : where + ": ") + name);
    else
      nested(name, word->text, where, yamlFile);
    return true;
  }

  void nested(const std::string& option, std::string file, const std::string& where,
              bool yamlFile) {
    if (file.ends_with(":yaml")) {
      file.erase(file.size() - 5);
      yamlFile = true;
    }
    readFile(file, (where.empty() ? "" : where + ": ") + option + " " + file, yamlFile);
  }

  GivenOptions options_;
  std::vector<std::string> prefixes_;
  std::size_t pushedBefore_ = 0;  ///< those of the files that include the present one
  std::map<std::string, std::string> aliases_;
  std::vector<std::pair<std::string, FileKey>> open_;  ///< files being read, the outermost first
  std::vector<FileKey> drained_;                       ///< pipes that have been read
  std::size_t total_ = 0;
};

std::vector<Word> argumentWords(int argc, char** argv) {
  std::vector<Word> words;
  for (int k = 1; k < argc; ++k) words.push_back({argv[k], false});
  return words;
}

GivenOptions collect(int argc, char** argv) {
  const std::vector<Word> arguments = argumentWords(argc, argv);
  Collector collector;
  if (std::ranges::none_of(arguments,
                           [](const Word& w) { return same(w.text, "-skip_petscrc"); })) {
    if (const char* home = std::getenv("HOME"); home && *home)
      collector.resourceFile(std::string(home) + "/.petscrc");
    collector.resourceFile(".petscrc");
    collector.resourceFile("petscrc");
  }
  if (const char* text = std::getenv("PETSC_OPTIONS"))
    collector.words(splitWords(text, "PETSC_OPTIONS"), "PETSC_OPTIONS", " (options begin with -)");
  if (const char* text = std::getenv("PETSC_OPTIONS_YAML"))
    collector.yaml(text, "PETSC_OPTIONS_YAML");
  collector.words(arguments, "", wrongFileHint);
  return collector.take();
}

std::string pack(const GivenOptions& options) {
  std::string bytes{options.briefHelp ? '1' : '0', options.version ? '1' : '0'};
  for (const GivenOption& o : options.list) {
    bytes.append(o.name).push_back('\0');
    bytes.append(o.value ? "=" + *o.value : "").push_back('\0');
  }
  return bytes;
}

GivenOptions unpack(const std::string& bytes) {
  GivenOptions options;
  options.briefHelp = bytes[0] == '1';
  options.version = bytes[1] == '1';
  for (std::size_t at = 2; at < bytes.size();) {
    const std::string name = bytes.c_str() + at;
    at += name.size() + 1;
    const std::string value = bytes.c_str() + at;
    at += value.size() + 1;
    options.list.push_back({name, value.empty() ? std::nullopt : std::optional(value.substr(1))});
  }
  return options;
}

/// What `collect` finds on rank 0, on all ranks.
template <class Collect>
GivenOptions fromRankZero(MPI_Comm comm, const Collect& collect) {
  enum Result : int { good, wrong, interrupted };
  int rank;
  MPI_Comm_rank(comm, &rank);
  int message[2] = {good, 0};
  std::string bytes;
  if (rank == 0) {
    try {
      bytes = pack(collect());
    } catch (const InputError& error) {
      message[0] = wrong;
      bytes = error.what();
    } catch (const Interrupted& stop) {
      message[0] = interrupted;
      bytes = stop.what();
    } catch (const std::bad_alloc&) {
      message[0] = wrong;
      bytes = "there is not enough memory for the options";
    }
    message[1] = static_cast<int>(bytes.size());
  }
  MPI_Bcast(message, 2, MPI_INT, 0, comm);
  bytes.resize(static_cast<std::size_t>(message[1]));
  MPI_Bcast(bytes.data(), message[1], MPI_CHAR, 0, comm);
  if (message[0] == wrong) throw InputError(bytes);
  if (message[0] == interrupted) throw Interrupted(bytes);
  return unpack(bytes);
}

}  // namespace

GivenOptions readOptions(MPI_Comm comm, int argc, char** argv) {
  return fromRankZero(comm, [&] { return collect(argc, argv); });
}

GivenOptions readOptions(MPI_Comm comm, const std::vector<std::string>& words) {
  return fromRankZero(comm, [&] {
    Collector collector;
    std::vector<Word> plain;
    for (const std::string& word : words) plain.push_back({word, false});
    collector.words(plain, "", wrongFileHint);
    return collector.take();
  });
}

void insertOptions(const GivenOptions& options) {
  for (const GivenOption& o : options.list)
    petsc(PetscOptionsSetValue(nullptr, o.name.c_str(), o.value ? o.value->c_str() : nullptr));
}

PetscErrorCode initialisePetsc(const std::string& program, const GivenOptions& options) {
  // PETSc 3.18 reads these options before all others. If its database already has their values, it
  // copies them after freeing them; as arguments they are safe.
  static const std::set<std::string> early{"-help", "-options_monitor", "-options_monitor_cancel",
                                           "-petsc_ci", "-skip_petscrc"};
  // Static, since PETSc keeps pointers to its arguments.
  static std::vector<std::string> words;
  // PETSc's signal handlers call functions that may wait for the interrupted code for ever.
  words = {program, "-skip_petscrc", "-no_signal_handler"};
  GivenOptions late;
  for (const GivenOption& o : options.list) {
    if (!early.contains(o.name)) {
      late.list.push_back(o);
      continue;
    }
    words.push_back(o.name);
    // `-help intro` would end the program inside PETSc.
    if (o.value && *o.value != "intro") words.push_back(*o.value);
  }
  insertOptions(late);
  static std::vector<char*> pointers;
  pointers.clear();
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  int count = static_cast<int>(words.size());
  char** arguments = pointers.data();
  return PetscInitialize(&count, &arguments, nullptr, nullptr);
}

}  // namespace nanoweft
