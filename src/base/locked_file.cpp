#include "nanoweft/base/locked_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "nanoweft/base/output_file.hpp"

namespace nanoweft {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t copyBlock = 1 << 20;

/// 0, or the reason why not all could be written.
int writeAll(int descriptor, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written < 0 ? errno : EIO;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return 0;
}

int copyRange(int from, int to, std::int64_t begin, std::int64_t end) {
  std::vector<char> block(static_cast<std::size_t>(std::min(copyBlock, end - begin)));
  while (begin < end) {
    const auto wanted = static_cast<std::size_t>(std::min(copyBlock, end - begin));
    const ssize_t got = ::pread(from, block.data(), wanted, begin);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return got < 0 ? errno : EIO;
    if (const int reason = writeAll(to, block.data(), static_cast<std::size_t>(got))) return reason;
    begin += got;
  }
  return 0;
}

/// File systems without locks let every run write.
bool lockedByAnother(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

}  // namespace

bool isSameFile(const std::string& a, const std::string& b) {
  const std::string files[2] = {throughLinks(a), throughLinks(b)};
  const FileIdentity there[2] = {FileIdentity::of(files[0]), FileIdentity::of(files[1])};
  if (there[0].exists && there[1].exists) return there[0].sameFile(there[1]);
  std::error_code code;
  fs::path whole[2];
  for (int k = 0; k < 2; ++k) {
    whole[k] = fs::weakly_canonical(files[k], code);
    if (code) whole[k] = fs::path(files[k]).lexically_normal();
  }
  return whole[0] == whole[1];
}

LockedFile::LockedFile(const std::string& name) : name_(name), path_(throughLinks(name)) {
  // A limit on the size of files shall be an error of write(), not the end of the process.
  std::signal(SIGXFSZ, SIG_IGN);
  // Another run may put its file in the place of the one just opened.
  while (!open()) {
  }
}

LockedFile::~LockedFile() {
  if (descriptor_ < 0) return;
  if (made_ && size_ == 0) ::unlink(path_.c_str());
  ::close(descriptor_);
}

void LockedFile::fail(int reason) const {
  throw std::runtime_error("cannot write " + name_ + ": " + std::strerror(reason));
}

/// Opens and locks what is there now; false when it was replaced meanwhile.
bool LockedFile::open() {
  struct stat there;
  const bool exists = ::stat(path_.c_str(), &there) == 0;
  if (exists && S_ISDIR(there.st_mode))
    throw std::runtime_error("cannot write " + name_ + ": it is a folder");
  if (exists && !S_ISREG(there.st_mode) && !S_ISCHR(there.st_mode))
    throw std::runtime_error("cannot write " + name_ + ": it is no regular file");
  device_ = exists && S_ISCHR(there.st_mode);
  made_ = false;
  const int flags = O_APPEND | O_CLOEXEC | O_NOCTTY | O_NONBLOCK | (device_ ? O_WRONLY : O_RDWR);
  int fd = ::open(path_.c_str(), flags);
  if (fd < 0 && errno == ENOENT) {
    fd = ::open(path_.c_str(), flags | O_CREAT | O_EXCL, 0666);
    made_ = fd >= 0;
    if (fd < 0 && errno == EEXIST && !fs::is_symlink(path_)) return false;
  }
  if (fd < 0) fail(errno);
  struct stat opened;
  const bool known = ::fstat(fd, &opened) == 0;
  if (device_ && known && S_ISCHR(opened.st_mode)) {
    // A terminal that is slow shall be waited for.
    ::fcntl(fd, F_SETFL, ::fcntl(fd, F_GETFL) & ~O_NONBLOCK);
    descriptor_ = fd;
    return true;
  }
  if (known && S_ISREG(opened.st_mode) && lockedByAnother(fd)) {
    ::close(fd);
    throw std::runtime_error("cannot write " + name_ + ": another run is writing it");
  }
  const bool same = known && S_ISREG(opened.st_mode) && ::stat(path_.c_str(), &there) == 0 &&
                    there.st_dev == opened.st_dev && there.st_ino == opened.st_ino;
  if (!same) {
    ::close(fd);
    return false;
  }
  descriptor_ = fd;
  size_ = opened.st_size;
  return true;
}

void LockedFile::replace(const std::string& head, std::int64_t begin, std::int64_t end) {
  if (device_) return append(head);
  OutputFile next(name_);
  const int fd = next.descriptor();
  struct stat old, now;
  if (fd >= 0 && ::fstat(descriptor_, &old) == 0 && ::fchmod(fd, old.st_mode & 07777) != 0)
    next.fail(errno);
  next.write(head);
  if (next.problem().empty())
    if (const int reason = copyRange(descriptor_, fd, begin, end)) next.fail(reason);
  // No other process knows the new file yet, so this call gets the lock.
  if (next.problem().empty()) lockedByAnother(fd);
  const int kept = ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (kept < 0) next.fail(errno);
  FileIdentity replaced = FileIdentity::of(descriptor_);
  if (const std::string problem = next.publish(replaced); !problem.empty()) {
    if (kept >= 0) ::close(kept);
    throw std::runtime_error(problem);
  }
  ::fcntl(kept, F_SETFL, O_APPEND);
  ::close(descriptor_);
  descriptor_ = kept;
  made_ = false;
  size_ = ::fstat(kept, &now) == 0 ? now.st_size : 0;
}

void LockedFile::append(const std::string& text) {
  struct stat now;
  if (!device_ && ::fstat(descriptor_, &now) == 0 && now.st_nlink == 0)
    throw std::runtime_error("cannot write " + name_ + ": it was removed");
  if (const int reason = writeAll(descriptor_, text.data(), text.size())) {
    if (!device_ && ::ftruncate(descriptor_, size_) != 0) {
      // A torn row stays at the end; whoever reads the table will notice it.
    }
    fail(reason);
  }
  size_ += static_cast<std::int64_t>(text.size());
}

void LockedFile::sync() {
  if (!device_ && ::fsync(descriptor_) != 0) fail(errno);
}

}  // namespace nanoweft
