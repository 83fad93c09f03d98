#include "nanoweft/app/last_checkpoint.hpp"

#include <sys/stat.h>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

LastCheckpoint::Stamp LastCheckpoint::stampOf(const std::string& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino, status.st_size, status.st_mtim.tv_sec,
          status.st_mtim.tv_nsec};
}

void LastCheckpoint::note(const std::string& file, std::int64_t step) {
  file_ = file;
  step_ = step;
  stamp_ = stampOf(file);
}

std::string LastCheckpoint::sentence() const {
  if (file_.empty()) return "there is no checkpoint";
  const auto step = static_cast<long long>(step_);
  const Stamp now = stampOf(file_);
  if (now == stamp_ && now.size >= 0)
    return format("the checkpoint %s of step %lld is good", file_.c_str(), step);
  return format("the checkpoint %s of step %lld has been %s since", file_.c_str(), step,
                now.size < 0 ? "removed" : "changed by others");
}

}  // namespace nanoweft
