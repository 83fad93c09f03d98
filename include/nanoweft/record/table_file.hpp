/// The format of a table's file, and its check before a restart goes on with it. Lines that begin
/// with `#` say where the table comes from; then come the names of the columns, then a row every so
/// many steps. Functions here are not collective.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/provenance.hpp"

namespace nanoweft {

/// From step `begin` on there is a row at every multiple of `interval`; in the first stretch of a
/// table also at `begin` itself.
struct TableStretch {
  std::int64_t interval, begin;
};

struct TableHead {
  std::optional<Provenance> provenance;
  std::vector<TableStretch> stretches;  ///< a restart may have changed the interval
  std::string columns;                  ///< names, as they stand there
  std::int64_t end = 0;                 ///< bytes up to the first row
  long long lines = 0;                  ///< lines up to the first row

  /// The head as it stands in the file.
  std::string text() const;
  /// The first step after `step` that has a row.
  std::int64_t nextRow(std::int64_t step) const;
};

TableHead readTableHead(int descriptor);

struct TableRows {
  std::int64_t end = 0;    ///< bytes up to the end of the rows that stay
  std::int64_t last = -1;  ///< step of the last of them, or -1
  std::string problem;     ///< why the table cannot be gone on with, or nothing
};

/// Checks every row up to `restartStep`: complete, with finite numbers, none missing, none twice.
/// Later rows do not stay. Nor does a row that is at `restartStep` only because the earlier run
/// ended there, unless the restart makes no step (`ends`).
TableRows checkTableRows(int descriptor, const TableHead& head, std::int64_t restartStep,
                         bool ends);

}  // namespace nanoweft
