/// Where a result comes from: what another run needs to give the same bytes again.
///
/// State files carry it in attributes of /run, tables in leading lines that begin with `#`. It
/// holds no host, date or number of ranks, so the same run writes the same bytes anywhere.
#pragma once

#include <istream>
#include <optional>
#include <string>

namespace nanoweft {

struct Provenance {
  std::string program;  ///< "nanoweft"
  std::string version;
  /// One `-name value` a line, ordered by name: the options that can change a result and differ
  /// from their defaults, and the seed.
  std::string options;
  std::string
      input;  ///< SHA-256 (hexadecimal) of the state file that the run started from, or empty

  bool operator==(const Provenance&) const = default;
  /// Do both come from the same run? Another version of the program may have gone on with it.
  bool sameRun(const Provenance& other) const {
    return program == other.program && options == other.options && input == other.input;
  }

  /// The lines that stand at the head of a table.
  std::string tableHead() const;
  /// Reads such lines and leaves the stream at the first other one; nothing when there are none.
  static std::optional<Provenance> fromTable(std::istream& in);
};

}  // namespace nanoweft
