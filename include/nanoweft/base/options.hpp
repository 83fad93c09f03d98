/// Typed access to PETSc's options database, with the help text, the bounds and the list of known
/// names that make a misspelt option an error.
///
///     OptionSection s(options, "Pair forces");
///     cutoff = s.real("pair_cutoff", 54.24, "A", "distance at which ... vanishes", {0.0});
///
/// A section that does not apply to the run (`scene weave` options when `-scene file`) is given as
/// inactive with its reason: options set in it are then refused as unused.
#pragma once

#include <petscsys.h>

#include <array>
#include <limits>
#include <optional>
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

class Options {
 public:
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

  /// Throws InputError when the database holds an option that nobody has asked for, naming the
  /// nearest known one. PETSc's own options (-log_view, ...) pass.
  void refuseUnknown() const;

 private:
  friend class OptionSection;
  bool help_ = false;
  std::vector<Topic> topics_;
};

class OptionSection {
 public:
  OptionSection(Options& options, std::string title, bool active = true, std::string reason = "");

  /// Set by the user?
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
  std::optional<std::vector<double>> reals(const std::string& name, int count, const char* shown,
                                           const char* unit, const char* help);
  std::optional<std::array<bool, 3>> flags3(const std::string& name, const char* shown,
                                            const char* help);
  /// Help for a family of options whose names are the user's (`NAME_region`).
  void document(const std::string& name, const char* shown, const char* unit, const char* help);
  std::vector<std::string> words(const std::string& name, const char* help);

 private:
  std::optional<std::string> raw(const std::string& name, const std::string& shown,
                                 const std::string& unit, const std::string& help);

  Options& options_;
  std::size_t topic_;
  bool active_;
  std::string reason_;
};

}  // namespace nanoweft
