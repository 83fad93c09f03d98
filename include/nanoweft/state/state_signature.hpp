/// The digest that a state file carries in its HDF5 user block, the bytes before all that HDF5
/// knows of: one line of text with the SHA-256 of all behind.
#pragma once

#include <string>

namespace nanoweft {

/// Size of the user block.
inline constexpr int signatureBytes = 512;

/// Puts the digest of all behind into the user block of a file that is open for reading and
/// writing. Returns 0, or the errno of what failed.
int signFile(int descriptor);

struct SignatureCheck {
  enum Result { intact, unsigned_, damaged, unreadable } result;
  std::string digest;  ///< SHA-256 of the whole file
  int reason = 0;      ///< errno, where the file is unreadable
};

/// Compares the digest. `unsigned_`: there is no user block of nanoweft's.
SignatureCheck checkSignature(int descriptor);

}  // namespace nanoweft
