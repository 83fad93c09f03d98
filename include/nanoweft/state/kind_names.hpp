/// Kinds in a state file, of fibres (/state/kind) or of links (/link/kind): numbers, and an
/// attribute of that dataset with the names behind them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nanoweft/state/dataset_writer.hpp"
#include "nanoweft/state/open_state.hpp"

namespace nanoweft {

/// Where kinds stand: their dataset, and the option that names those of a run.
struct KindPlace {
  const char* dataset;
  const char* option;
};
inline constexpr KindPlace kindsOfFibres{"/state/kind", "-kinds"},
    kindsOfLinks{"/link/kind", "-link_kinds"};

/// The names in the file, in the order of the numbers; empty: none are given. Throws InputError
/// for an attribute that holds no names. Not collective.
std::vector<std::string> readKindNames(const OpenState& file, const KindPlace& place);

/// Writes the names to the dataset `kind` of the group, which is there already. For rank 0.
void writeKindNames(DatasetWriter& writer, hid_t group, const std::vector<std::string>& names);

/// a,b,c
std::string listOf(const std::vector<std::string>& names);

/// For each kind of the file, its number in the run.
class KindNumbers {
 public:
  /// `theirs`: the names in the file; `known`: those of the run. Without names in the file its
  /// numbers are those of the run.
  KindNumbers(const KindPlace& place, const std::vector<std::string>& theirs,
              const std::vector<std::string>& known);

  /// The number in the run; -1 for one that the file does not explain.
  int of(std::int32_t kind) const {
    return kind >= 0 && static_cast<std::size_t>(kind) < numbers_.size()
               ? numbers_[static_cast<std::size_t>(kind)]
               : -1;
  }
  std::size_t count() const { return numbers_.size(); }
  /// What is wrong with the names, or nothing.
  const std::string& problem() const { return problem_; }

 private:
  std::vector<int> numbers_;
  std::string problem_;
};

}  // namespace nanoweft
