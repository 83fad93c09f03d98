/// What reading and writing a state file share.
#pragma once

#include <hdf5.h>
#include <mpi.h>

#include <algorithm>
#include <cstdint>

namespace nanoweft {

inline constexpr const char* stateFormatName = "nanoweft-state";
inline constexpr std::int64_t stateFormatVersion = 1;
/// Rows of a chunk. Fixed, so that a file does not depend on the number of ranks.
inline constexpr std::int64_t chunkRows = 16384;

/// The rows that a rank reads or puts in order for the file.
struct RowBlock {
  std::int64_t begin, count;
  RowBlock(std::int64_t total, int rank, int ranks) {
    begin = total * rank / ranks;
    count = total * (rank + 1) / ranks - begin;
  }
  /// The same in whole chunks.
  static RowBlock ofChunks(std::int64_t total, int rank, int ranks) {
    RowBlock block((total + chunkRows - 1) / chunkRows, rank, ranks);
    block.begin *= chunkRows;
    block.count = std::clamp<std::int64_t>(total - block.begin, 0, block.count * chunkRows);
    return block;
  }
};

}  // namespace nanoweft
