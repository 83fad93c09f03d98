#include "nanoweft/state/state_signature.hpp"

#include <unistd.h>

#include <cerrno>

#include "nanoweft/base/digest.hpp"

namespace nanoweft {

namespace {

constexpr const char* mark = "nanoweft state file (HDF5). SHA-256 of all behind these 512 bytes: ";

std::string signature(const std::string& digest) {
  std::string block = mark + digest + "\n";
  block.resize(signatureBytes, '\0');
  return block;
}

}  // namespace

int signFile(int descriptor) {
  const auto digests = digestFile(descriptor, signatureBytes);
  if (!digests) return errno;
  const std::string block = signature(digests->behind);
  std::size_t done = 0;
  while (done < block.size()) {
    const ssize_t n =
        ::pwrite(descriptor, block.data() + done, block.size() - done, static_cast<off_t>(done));
    if (n > 0)
      done += static_cast<std::size_t>(n);
    else if (n == 0 || errno != EINTR)
      return n == 0 ? ENOSPC : errno;
  }
  return 0;
}

SignatureCheck checkSignature(int descriptor) {
  std::string block(signatureBytes, '\0');
  const ssize_t got = ::pread(descriptor, block.data(), block.size(), 0);
  const auto digests = got < 0 ? std::nullopt : digestFile(descriptor, signatureBytes);
  if (!digests) return {SignatureCheck::unreadable, "", errno};
  if (!block.starts_with(mark)) return {SignatureCheck::unsigned_, digests->whole};
  const bool same = block == signature(digests->behind);
  return {same ? SignatureCheck::intact : SignatureCheck::damaged, digests->whole};
}

}  // namespace nanoweft
