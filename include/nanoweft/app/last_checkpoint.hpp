/// Which checkpoint a failed run can be continued from.
#pragma once

#include <cstdint>
#include <string>

namespace nanoweft {

class LastCheckpoint {
 public:
  /// A whole checkpoint of `step` has just been written to, or read from, `file`.
  void note(const std::string& file, std::int64_t step);
  /// Says what to go on with, or that there is nothing; looks whether the file is still the one
  /// that was noted.
  std::string sentence() const;

 private:
  /// Tells a file from another that has taken its place.
  struct Stamp {
    unsigned long device = 0, inode = 0;
    long size = -1, seconds = 0, nanoseconds = 0;
    bool operator==(const Stamp&) const = default;
  };
  static Stamp stampOf(const std::string& file);

  std::string file_;
  std::int64_t step_ = -1;
  Stamp stamp_;
};

}  // namespace nanoweft
