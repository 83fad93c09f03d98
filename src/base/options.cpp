#include "nanoweft/base/options.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string_view>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// Options that PetscInitialize and PETSc's own objects may read here.
constexpr std::string_view petscNames[] = {
    "help",
    "version",
    "skip_petscrc",
    "options_file",
    "options_file_yaml",
    "options_string_yaml",
    "options_left",
    "options_view",
    "options_monitor",
    "options_monitor_cancel",
    "options_suppress_deprecated_warnings",
    "citations",
    "log",
    "log_all",
    "log_view",
    "log_view_memory",
    "log_trace",
    "log_sync",
    "log_mpe",
    "log_exclude",
    "log_include_actions",
    "log_include_objects",
    "info",
    "info_exclude",
    "malloc",
    "malloc_debug",
    "malloc_dump",
    "malloc_hbw",
    "malloc_test",
    "malloc_view",
    "malloc_view_threshold",
    "malloc_requested_size",
    "malloc_coalesce",
    "memory_view",
    "fp_trap",
    "on_error_abort",
    "on_error_attach_debugger",
    "on_error_emacs",
    "on_error_mpiabort",
    "error_output_none",
    "error_output_stdout",
    "start_in_debugger",
    "debugger_nodes",
    "debugger_pause",
    "debugger_ranks",
    "debug_terminal",
    "stop_for_debugger",
    "no_signal_handler",
    "checkstack",
    "objects_dump",
    "get_total_flops",
    "history",
    "nox",
    "nox_warning",
    "display",
    "shared_tmp",
    "not_shared_tmp",
    "tmp",
    "use_gpu_aware_mpi",
    "mpi_linear_solver_server",
    "build_twosided",
    "x_virtual",
};
constexpr std::string_view petscPrefixes[] = {"draw_",          "sf_",        "dm_", "viewer_hdf5_",
                                              "viewer_binary_", "vecscatter_"};

bool belongsToPetsc(std::string_view name) {
  return std::ranges::find(petscNames, name) != std::end(petscNames) ||
         std::ranges::any_of(petscPrefixes,
                             [&](std::string_view p) { return name.starts_with(p); });
}

/// The suffixes of options whose first part is the user's (boundary.cpp).
constexpr std::string_view boundarySuffixes[] = {"_region",   "_group", "_fix",   "_fix_rotation",
                                                 "_velocity", "_ramp",  "_force", "_torque"};

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

double parseReal(const std::string& name, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(value))
    throw InputError(format("-%s '%s': expected a number", name.c_str(), text.c_str()));
  return value;
}

long parseInteger(const std::string& name, const std::string& text) {
  const double value = parseReal(name, text);  // so that 1e6 may be written for a step count
  if (value != std::floor(value) || std::abs(value) > 9e15)
    throw InputError(format("-%s '%s': expected a whole number", name.c_str(), text.c_str()));
  return static_cast<long>(value);
}

bool parseFlag(const std::string& name, std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  if (text.empty() || text == "1" || text == "true" || text == "yes" || text == "on") return true;
  if (text == "0" || text == "false" || text == "no" || text == "off") return false;
  throw InputError(format("-%s '%s': expected true or false (1 or 0)", name.c_str(), text.c_str()));
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
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

}  // namespace

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
  std::string problem;
  for (PetscInt i = 0; i < count && problem.empty(); ++i) {
    const std::string_view name = names[i];
    if (belongsToPetsc(name)) continue;
    const Entry* nearest = nullptr;
    int best = 1000;
    for (const Topic& topic : topics_)
      for (const Entry& e : topic.entries)
        if (const int d = editDistance(name, e.name); d < best) {
          best = d;
          nearest = &e;
        }
    problem = format("unknown option -%s", names[i]);
    const auto suffix = std::ranges::find_if(boundarySuffixes,
                                             [&](std::string_view e) { return name.ends_with(e); });
    if (suffix != std::end(boundarySuffixes) && best > 2)
      problem += format("; a boundary condition must be named: -bc %s",
                        std::string(name.substr(0, name.size() - suffix->size())).c_str());
    else if (nearest)
      problem += format("; the nearest known one is -%s", nearest->name.c_str());
  }
  petsc(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  if (!problem.empty()) throw InputError(problem);
}

OptionSection::OptionSection(Options& options, std::string title, bool active, std::string reason)
    : options_(options), topic_(0), active_(active), reason_(std::move(reason)) {
  for (; topic_ < options.topics_.size(); ++topic_)
    if (options.topics_[topic_].title == title) return;
  options.topics_.push_back({std::move(title), {}});
}

bool OptionSection::given(const std::string& name) const {
  PetscBool found;
  petsc(PetscOptionsHasName(nullptr, nullptr, ("-" + name).c_str(), &found));
  return found == PETSC_TRUE;
}

void OptionSection::document(const std::string& name, const char* shown, const char* unit,
                             const char* help) {
  auto& entries = options_.topics_[topic_].entries;
  if (std::ranges::none_of(entries, [&](const Options::Entry& e) { return e.name == name; }))
    entries.push_back({name, shown, unit, help});
}

std::optional<std::string> OptionSection::raw(const std::string& name, const std::string& shown,
                                              const std::string& unit, const std::string& help) {
  document(name, shown.c_str(), unit.c_str(), help.c_str());
  // PetscOptionsGetString would cut a long value.
  const char* value = nullptr;
  PetscBool found;
  petsc(PetscOptionsFindPair(nullptr, nullptr, ("-" + name).c_str(), &value, &found));
  if (!found) return std::nullopt;
  if (!active_)
    throw InputError(format("-%s is not used by this run: %s", name.c_str(), reason_.c_str()));
  return std::string(value ? value : "");
}

double OptionSection::real(const std::string& name, double fallback, const char* unit,
                           const char* help, Bounds bounds) {
  return maybeReal(name, shownReal(fallback).c_str(), unit, help, bounds).value_or(fallback);
}

std::optional<double> OptionSection::maybeReal(const std::string& name, const char* shown,
                                               const char* unit, const char* help, Bounds bounds) {
  const auto text = raw(name, shown, unit, help);
  if (!text) return std::nullopt;
  const double value = parseReal(name, *text);
  checkBounds(name, value, bounds);
  return value;
}

long OptionSection::integer(const std::string& name, long fallback, const char* help, long lower,
                            long upper) {
  return maybeInteger(name, std::to_string(fallback).c_str(), help, lower, upper)
      .value_or(fallback);
}

std::optional<long> OptionSection::maybeInteger(const std::string& name, const char* shown,
                                                const char* help, long lower, long upper) {
  const auto text = raw(name, shown, "", help);
  if (!text) return std::nullopt;
  const long value = parseInteger(name, *text);
  if (value < lower || value > upper)
    throw InputError(format("-%s %ld: must be from %ld to %ld", name.c_str(), value, lower, upper));
  return value;
}

bool OptionSection::flag(const std::string& name, bool fallback, const char* help) {
  const auto text = raw(name, fallback ? "true" : "false", "", help);
  return text ? parseFlag(name, *text) : fallback;
}

std::string OptionSection::text(const std::string& name, const std::string& fallback,
                                const char* help) {
  const auto value = raw(name, fallback.empty() ? "none" : fallback, "", help);
  if (value && value->empty()) throw InputError(format("-%s needs a value", name.c_str()));
  return value.value_or(fallback);
}

std::string OptionSection::choice(const std::string& name, const std::string& fallback,
                                  const std::vector<std::string>& choices, const char* help) {
  std::string list;
  for (const std::string& c : choices) list += (list.empty() ? "" : "|") + c;
  const std::string value = raw(name, fallback, "", help + (" (" + list + ")")).value_or(fallback);
  if (std::ranges::find(choices, value) == choices.end())
    throw InputError(
        format("-%s '%s': must be one of %s", name.c_str(), value.c_str(), list.c_str()));
  return value;
}

std::optional<std::vector<double>> OptionSection::reals(const std::string& name, int count,
                                                        const char* shown, const char* unit,
                                                        const char* help) {
  const auto value = raw(name, shown, unit, help);
  if (!value) return std::nullopt;
  const auto parts = split(*value);
  if (static_cast<int>(parts.size()) != count)
    throw InputError(format("-%s '%s': expected %d numbers separated by commas", name.c_str(),
                            value->c_str(), count));
  std::vector<double> numbers;
  for (const std::string& part : parts) numbers.push_back(parseReal(name, part));
  return numbers;
}

std::optional<std::array<bool, 3>> OptionSection::flags3(const std::string& name, const char* shown,
                                                         const char* help) {
  const auto value = raw(name, shown, "", help);
  if (!value) return std::nullopt;
  const auto parts = split(*value);
  if (parts.size() != 3)
    throw InputError(format("-%s '%s': expected three of 0 and 1 separated by commas", name.c_str(),
                            value->c_str()));
  return std::array{parseFlag(name, parts[0]), parseFlag(name, parts[1]),
                    parseFlag(name, parts[2])};
}

std::vector<std::string> OptionSection::words(const std::string& name, const char* help) {
  const auto value = raw(name, "none", "", help);
  if (!value) return {};
  auto parts = split(*value);
  for (const std::string& part : parts)
    if (part.empty())
      throw InputError(format("-%s '%s': an empty name", name.c_str(), value->c_str()));
  return parts;
}

}  // namespace nanoweft
