#include "nanoweft/base/output_file.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <climits>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace fs = std::filesystem;

namespace {

FileIdentity identity(const struct stat& status) {
  return {true, status.st_dev, status.st_ino, status.st_size,
          std::int64_t{status.st_mtim.tv_sec} * 1000000000 + status.st_mtim.tv_nsec};
}

/// What stands under a name in an open folder; links are not followed.
FileIdentity identityIn(int folder, const std::string& leaf) {
  struct stat status {};
  return ::fstatat(folder, leaf.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 ? identity(status)
                                                                            : FileIdentity{};
}

/// Lets one process at a time look at a name and then replace it. The lock is the folder's: readers
/// lock files. Where the file system has no locks, or another process keeps one, only the look
/// protects.
class FolderLock {
 public:
  explicit FolderLock(int folder) : folder_(folder) {
    for (int tries = 0; tries < 200; ++tries) {
      locked_ = ::flock(folder_, LOCK_EX | LOCK_NB) == 0;
      if (locked_ || (errno != EWOULDBLOCK && errno != EINTR)) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  ~FolderLock() {
    if (locked_) ::flock(folder_, LOCK_UN);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int folder_;
  bool locked_ = false;
};

}  // namespace

FileIdentity FileIdentity::of(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 ? identity(status) : FileIdentity{};
}

FileIdentity FileIdentity::of(const std::string& file) {
  struct stat status {};
  return ::stat(file.c_str(), &status) == 0 ? identity(status) : FileIdentity{};
}

std::string throughLinks(const std::string& file) {
  constexpr int mostLinks = 40;  // as in the kernel
  std::error_code code;
  fs::path path = fs::absolute(file, code);
  if (code) return file;
  for (int k = 0; k < mostLinks && fs::is_symlink(path, code); ++k) {
    const fs::path target = fs::read_symlink(path, code);
    if (code) break;
    path = path.parent_path() / target;  // an absolute target replaces all
  }
  // The folders' links are resolved, so that one place has one name.
  const fs::path folder = fs::canonical(path.parent_path(), code);
  return code ? path.string() : (folder / path.filename()).string();
}

OutputFile::OutputFile(const std::string& file, Temporary wanted) : file_(file) {
  const fs::path target = throughLinks(file);
  leaf_ = target.filename().string();
  folder_ = ::open(target.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_ < 0) {
    fail(errno);
    return;
  }
  struct stat status {};
  if (::fstatat(folder_, leaf_.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0 && errno != ENOENT) {
    fail(errno);  // a name too long, for one
    return;
  }
  // A file without a name leaves nothing behind, however the program ends. To name it, /proc is
  // needed.
  if (wanted == Temporary::nameless && ::access("/proc/self/fd", X_OK) == 0)
    descriptor_ = ::openat(folder_, ".", O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
  if (descriptor_ >= 0) return;
  hidden_ = unusedName();
  descriptor_ = ::openat(folder_, hidden_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ >= 0) return;
  const int reason = errno;
  hidden_.clear();
  fail(reason);
}

OutputFile::~OutputFile() {
  if (!hidden_.empty()) ::unlinkat(folder_, hidden_.c_str(), 0);
  if (descriptor_ >= 0) ::close(descriptor_);
  if (folder_ >= 0) ::close(folder_);
}

/// A name that nothing has, short enough for any target.
std::string OutputFile::unusedName() const {
  const std::string stem = leaf_.substr(0, NAME_MAX - 11);
  static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789";
  for (std::uint64_t seed =
           static_cast<std::uint64_t>(::getpid()) * 7919 +
           static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
       ; ++seed) {
    std::uint64_t digits = seed * 0x9E3779B97F4A7C15u >> 20;
    std::string name = stem + ".tmp-";
    for (int k = 0; k < 6; ++k, digits /= 36) name += letters[digits % 36];
    if (!identityIn(folder_, name).exists) return name;
  }
}

void OutputFile::fail(int reason) {
  if (problem_.empty()) problem_ = "cannot write " + file_ + ": " + std::strerror(reason);
}

void OutputFile::write(std::string_view text) {
  while (problem_.empty() && !text.empty()) {
    const ssize_t done = ::write(descriptor_, text.data(), text.size());
    if (done >= 0)
      text.remove_prefix(static_cast<std::size_t>(done));
    else if (errno != EINTR)
      fail(errno);
  }
}

/// Gives the nameless file a name that nothing has; false, with errno set, otherwise.
bool OutputFile::linkTo(const std::string& name) const {
  const std::string self = format("/proc/self/fd/%d", descriptor_);
  return ::linkat(AT_FDCWD, self.c_str(), folder_, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
}

std::string OutputFile::publish(FileIdentity& replaced) {
  if (problem_.empty() && ::fsync(descriptor_) != 0) fail(errno);
  if (!problem_.empty()) return problem_;
  const FolderLock lock(folder_);
  if (const std::string taken = takePlace(replaced); !taken.empty()) return problem_ = taken;
  hidden_.clear();
  replaced = FileIdentity::of(descriptor_);
  // Some file systems cannot sync folders.
  if (::fsync(folder_) != 0 && errno != EINVAL && errno != ENOTSUP) fail(errno);
  return problem_;
}

std::string OutputFile::takePlace(const FileIdentity& replaced) {
  const std::string refused =
      "will not replace " + file_ + ": something else has written it since this run looked";
  if (identityIn(folder_, leaf_) != replaced) return refused;
  if (!replaced.exists) {
    const bool done = hidden_.empty() ? linkTo(leaf_)
                                      : ::renameat2(folder_, hidden_.c_str(), folder_,
                                                    leaf_.c_str(), RENAME_NOREPLACE) == 0;
    if (done) return "";
    if (errno == EEXIST) return refused;
    const bool cannot = !hidden_.empty() && (errno == EINVAL || errno == ENOSYS);
    if (!cannot) return fail(errno), problem_;
  }
  if (hidden_.empty()) {
    const std::string name = unusedName();
    if (!linkTo(name)) return fail(errno), problem_;
    hidden_ = name;
  }
  if (::renameat(folder_, hidden_.c_str(), folder_, leaf_.c_str()) != 0) fail(errno);
  return problem_;
}

}  // namespace nanoweft
