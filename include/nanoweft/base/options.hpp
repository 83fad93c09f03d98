/// Typed access to PETSc's options database, with the help text, the bounds and the list of known
/// names that make a misspelt option an error.
///
///     OptionSection s(options, "Pair forces");
///     cutoff = s.real("pair_cutoff", 54.24, "A", "distance at which ... vanishes", {0.0});
///
/// A section that does not apply to the run (`scene weave` options when `-scene file`) is given as
/// inactive with its reason: options set in it are then refused as unused.
///
/// Where a run has several things of a sort (kinds of fibre), an OptionPrefix makes the sections
/// opened while it lives look for `-PREFIX_name` first; `-name` alone is meant for all.
///
/// Every option that is read is noted with its value, its default and its role (what it may
/// change), in one way of writing for each value (`base/canonical.hpp`). From this come the
/// provenance of results and the rules of a restart: it has the options of its checkpoint, and
/// others that are given must agree with them.
#pragma once

#include <petscsys.h>

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace nanoweft {

struct Bounds {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool openLower = false;  ///< the lower bound itself is excluded
};
inline constexpr Bounds positive{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr Bounds nonNegative{0.0};

/// What an option may change, which settles what a restart may do with it.
enum class Role {
  result,  ///< what is computed: a restart keeps that of its checkpoint
  step,    ///< likewise, but a restart may set it anew
  run,     ///< where a run ends, what it writes, how it works: results are the same for any value
};

class Options {
 public:
  /// An option that was read.
  struct Reading {
    std::optional<std::string> value;     ///< as the user or the checkpoint gave it; empty: neither
    std::optional<std::string> fallback;  ///< its default; empty: it follows from other options
    bool byUser = false;
    Role role = Role::result;
  };
  struct Entry {
    std::string name, value, unit, help;
  };
  struct Topic {
    std::string title;
    std::vector<Entry> entries;
  };

  /// Reads -help; all else is read by sections.
  Options();

  bool helpWanted() const { return help_; }
  const std::vector<Topic>& topics() const { return topics_; }

  /// Prints every option that was read, by topic, with unit and default.
  void printHelp(MPI_Comm comm) const;

  /// Throws InputError when the database, or the checkpoint that the run goes on from, holds an
  /// option that nobody has asked for, naming the nearest known one. PETSc's own options
  /// (-log_view, ...) pass.
  void refuseUnknown() const;

  /// From now on the options of a checkpoint are in force without being given, and given ones of
  /// Role::result must agree with them. `recorded` is what resultOptions() said in the run that
  /// wrote the checkpoint; `inForce` are values of options of Role::step that were in force there
  /// by default. Throws InputError for text that is no list of options.
  void goOnFrom(const std::string& checkpoint, const std::string& recorded,
                const std::map<std::string, std::string>& inForce);

  /// All options that were read and apply to the run, by name.
  const std::map<std::string, Reading>& readings() const { return readings_; }

  /// Value of an option in the checkpoint that the run goes on from.
  std::optional<std::string> recorded(const std::string& name) const;

  /// One `-name value` a line, ordered by name: the options that can change a result and differ
  /// from their defaults, and those of `always` whatever their value. In a restart those of the
  /// checkpoint, with what was set anew.
  std::string resultOptions(const std::set<std::string>& always) const;

 private:
  friend class OptionSection;
  friend class OptionPrefix;
  bool help_ = false;
  std::string prefix_;  ///< with its underscore, of the sections to be opened
  std::vector<Topic> topics_;
  std::map<std::string, Reading> readings_;
  /// Options meant for all kinds that some kind does not use, with the reason, and those that some
  /// kind uses.
  std::map<std::string, std::string> leftOut_;
  std::set<std::string> used_;
  std::set<std::string> countWhenGiven_;  ///< giving them has an effect even at their default
  std::string checkpoint_;                ///< that the run goes on from, or empty
  std::map<std::string, std::string> recorded_, inForce_;
};

/// While it lives, sections that are opened look for `-PREFIX_name` before `-name`.
class OptionPrefix {
 public:
  OptionPrefix(Options& options, const std::string& prefix);
  ~OptionPrefix();
  OptionPrefix(const OptionPrefix&) = delete;
  OptionPrefix& operator=(const OptionPrefix&) = delete;

 private:
  Options& options_;
  std::string before_;
};

/// Throws InputError for names of things (a kind of fibre, a wall) that cannot begin the names of
/// their options, or that are given twice. `option`: what lists them. `joined`: letters may follow
/// an underscore, which the names of two kinds could not have.
void checkPrefixes(const char* option, const char* thing, const std::vector<std::string>& names,
                   bool joined = false);

class OptionSection {
 public:
  OptionSection(Options& options, std::string title, bool active = true, std::string reason = "");

  /// The same section for options of another role.
  OptionSection as(Role role) const;
  /// The same section for options that `document` shows as a family.
  OptionSection family() const;

  /// Set by the user, or in a restart (but for Role::run) in its checkpoint?
  bool given(const std::string& name) const;

  double real(const std::string& name, double fallback, const char* unit, const char* help,
              Bounds bounds = {});
  /// No default: empty when not given. `shown` is what -help prints as default.
  std::optional<double> maybeReal(const std::string& name, const char* shown, const char* unit,
                                  const char* help, Bounds bounds = {});
  long integer(const std::string& name, long fallback, const char* help, long lower, long upper);
  std::optional<long> maybeInteger(const std::string& name, const char* shown, const char* help,
                                   long lower, long upper);
  bool flag(const std::string& name, bool fallback, const char* help);
  std::string text(const std::string& name, const std::string& fallback, const char* help);
  std::string choice(const std::string& name, const std::string& fallback,
                     const std::vector<std::string>& choices, const char* help);
  /// Several of the choices, separated by commas; none twice.
  std::vector<std::string> choices(const std::string& name,
                                   const std::vector<std::string>& fallback,
                                   const std::vector<std::string>& choices, const char* help);
  /// `count` numbers; 0: any number of them.
  std::optional<std::vector<double>> reals(const std::string& name, int count, const char* shown,
                                           const char* unit, const char* help);
  std::optional<std::array<bool, 3>> flags3(const std::string& name, const char* shown,
                                            const char* help);
  /// Help for an option that is read elsewhere, or for a family whose names are the user's
  /// (`NAME_region`).
  void document(const std::string& name, const char* shown, const char* unit, const char* help);
  std::vector<std::string> words(const std::string& name, const char* help);

 private:
  struct Question {
    const std::string& name;
    std::string shown, unit, help;
  };
  /// The name under which an option is in force: with the prefix where it is set so.
  std::string inForce(const std::string& name) const;
  /// What the user set it to.
  std::optional<std::string> ownText(const std::string& name) const;
  /// The value in force, made of its text by `parse`, noted and compared with the checkpoint's;
  /// empty when neither the user nor the checkpoint gave it.
  template <class T, class Parse>
  std::optional<T> read(const Question& question, const std::optional<T>& fallback,
                        const Parse& parse);
  void agreeWithCheckpoint(const Question& question, const std::string& own,
                           const Options::Reading& reading) const;

  Options& options_;
  std::string prefix_;
  std::size_t topic_;
  bool active_;
  std::string reason_;
  Role role_ = Role::result;
  bool documented_ = true;
};

}  // namespace nanoweft
