/// The digest of a state file: one line of text with the SHA-256 of all bytes behind the user
/// block. It stands in that block, the first bytes of an HDF5 file, which HDF5 leaves to the user.
#pragma once

#include <string>

namespace nanoweft {

/// Size of the user block.
inline constexpr int signatureBytes = 512;

/// Puts the digest of all bytes behind the user block into it. The file must be open for reading
/// and writing. Returns 0, or the errno of what failed.
int signFile(int descriptor);

struct SignatureCheck {
  enum Result { intact, unsigned_, damaged, unreadable } result;
  std::string digest;  ///< SHA-256 of the whole file
  int reason = 0;      ///< errno, where the file is unreadable
};

/// Compares the digest. `unsigned_`: there is no user block of nanoweft's.
SignatureCheck checkSignature(int descriptor);

}  // namespace nanoweft
