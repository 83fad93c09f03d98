/// A result file that appears under its name only when it is complete, and that replaces no other
/// file than the one it was meant to replace. For one process; nothing here is collective.
#pragma once

#include <sys/stat.h>

#include <cstdint>

#include <string>
#include <string_view>

namespace nanoweft {

/// What stands under a name: nothing, or a certain file with a certain content.
struct FileIdentity {
  bool exists = false;
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = 0;
  std::int64_t modified = 0;  ///< nanoseconds

  bool operator==(const FileIdentity&) const = default;
  /// Of the file behind a descriptor, or under a name (links are followed).
  static FileIdentity of(int descriptor);
  static FileIdentity of(const std::string& file);
  /// Are both one file, whatever its content?
  bool sameFile(const FileIdentity& other) const {
    return exists && other.exists && device == other.device && inode == other.inode;
  }
};

/// The absolute name behind all symbolic links of `file`, which need not exist. A file put under
/// this name leaves the links as they are. A loop of links ends at one of them.
std::string throughLinks(const std::string& file);

class OutputFile {
 public:
  enum class Temporary { nameless, named };
  /// Makes an empty file without a name in the folder of `file`, or where the file system cannot do
  /// that, one named FILE.tmp- and six letters. `problem()` says when that failed.
  explicit OutputFile(const std::string& file, Temporary wanted = Temporary::nameless);
  /// Removes the file unless it has been published.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// "cannot write FILE: reason", or empty while all is well.
  const std::string& problem() const { return problem_; }
  int descriptor() const { return descriptor_; }
  /// Appends text; a failure is remembered in problem().
  void write(std::string_view text);
  /// Notes that the caller's own write to descriptor() failed; `reason`: its errno.
  void fail(int reason);

  /// Brings the content to the disk and puts the file under its name, in the place of `replaced`.
  /// Fails when another file than `replaced` stands there by now. Returns the problem; when it is
  /// empty, `replaced` is the new file.
  std::string publish(FileIdentity& replaced);

 private:
  bool linkTo(const std::string& name) const;
  std::string unusedName() const;
  std::string takePlace(const FileIdentity& replaced);

  std::string file_, leaf_;  ///< as given; last part of the name behind all links
  std::string hidden_;       ///< the temporary's name in the folder, where it has one
  int folder_ = -1, descriptor_ = -1;
  std::string problem_;
};

}  // namespace nanoweft
