#include "nanoweft/base/digest.hpp"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

constexpr std::size_t blockBytes = 1 << 20;

}  // namespace

struct Sha256::Context {
  EVP_MD_CTX* state = EVP_MD_CTX_new();
  ~Context() { EVP_MD_CTX_free(state); }
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  if (!context_->state || EVP_DigestInit_ex(context_->state, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("OpenSSL has no SHA-256");
}

Sha256::~Sha256() = default;

void Sha256::add(const void* bytes, std::size_t count) {
  if (EVP_DigestUpdate(context_->state, bytes, count) != 1)
    throw std::runtime_error("SHA-256 failed");
}

std::string Sha256::digest() {
  unsigned char bytes[EVP_MAX_MD_SIZE];
  unsigned length = 0;
  if (EVP_DigestFinal_ex(context_->state, bytes, &length) != 1)
    throw std::runtime_error("SHA-256 failed");
  std::string text;
  for (unsigned k = 0; k < length; ++k) text += format("%02x", bytes[k]);
  return text;
}

std::optional<FileDigests> digestFile(int descriptor, std::int64_t skip) {
  Sha256 whole, behind;
  std::vector<char> block(blockBytes);
  for (std::int64_t at = 0;;) {
    const ssize_t got = ::pread(descriptor, block.data(), block.size(), at);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    const auto count = static_cast<std::size_t>(got);
    whole.add(block.data(), count);
    if (skip > 0) {
      const auto skipped = static_cast<std::size_t>(std::clamp<std::int64_t>(skip - at, 0, got));
      behind.add(block.data() + skipped, count - skipped);
    }
    at += got;
  }
  FileDigests result;
  result.whole = whole.digest();
  result.behind = skip > 0 ? behind.digest() : result.whole;
  return result;
}

std::string sha256OfFile(const std::string& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  struct stat status {};
  if (fd < 0 || ::fstat(fd, &status) != 0) {
    const int reason = errno;
    if (fd >= 0) ::close(fd);
    throw InputError("cannot read " + file + ": " + std::strerror(reason));
  }
  if (!S_ISREG(status.st_mode)) {
    ::close(fd);
    throw InputError("cannot read " + file + ": it is no regular file");
  }
  const auto digests = digestFile(fd);
  const int reason = errno;
  ::close(fd);
  if (!digests) throw InputError("cannot read " + file + ": " + std::strerror(reason));
  return digests->whole;
}

}  // namespace nanoweft
