/// A text file that this process alone writes. Functions here are not collective, and throw
/// std::runtime_error with the name of the file and the reason.
#pragma once

#include <cstdint>
#include <string>

namespace nanoweft {

/// Are these names of one file, there or not?
bool isSameFile(const std::string& a, const std::string& b);

/// Locked for as long as the object lives, so that a second run is refused. Content is replaced by
/// a rename of a complete, synchronised file: whenever the process is killed, either the old or the
/// new content is there.
class LockedFile {
 public:
  /// Opens the file, or the one that a link stands for; makes an empty one where there is none.
  /// Anything but a regular file or a character device is refused.
  explicit LockedFile(const std::string& name);
  /// Removes a file that it has made and that is still empty.
  ~LockedFile();
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;

  const std::string& name() const { return name_; }
  int descriptor() const { return descriptor_; }
  /// A device has no content to keep.
  bool isDevice() const { return device_; }
  std::int64_t size() const { return size_; }

  /// Makes the content `head`, then the present bytes from `begin` to `end`.
  void replace(const std::string& head, std::int64_t begin = 0, std::int64_t end = 0);
  /// A failure leaves the file as it was.
  void append(const std::string& text);
  /// Returns when all is on the disk.
  void sync();

 private:
  [[noreturn]] void fail(int reason) const;
  bool open();

  std::string name_, path_;
  int descriptor_ = -1;
  bool device_ = false, made_ = false;
  std::int64_t size_ = 0;
};

}  // namespace nanoweft
