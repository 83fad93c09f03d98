/// SHA-256 of files, by OpenSSL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace nanoweft {

/// SHA-256 of bytes that come in pieces.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(const void* bytes, std::size_t count);
  /// The digest in 64 hexadecimal digits; nothing can be added afterwards.
  std::string digest();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

struct FileDigests {
  std::string whole;   ///< of all bytes, as sha256sum prints it
  std::string behind;  ///< of the bytes behind the first `skip`
};

/// Reads the file behind a descriptor to its end. Nothing, with errno set, when that fails.
std::optional<FileDigests> digestFile(int descriptor, std::int64_t skip = 0);

/// SHA-256 of a regular file. Throws InputError with the reason.
std::string sha256OfFile(const std::string& file);

}  // namespace nanoweft
