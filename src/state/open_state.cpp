#include "nanoweft/state/open_state.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// Why this is no file to read a state from, or nothing. Looks only: to open a fifo would wait.
std::string problemOfKind(const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    const int reason = errno;
    if (reason != ENOENT) return std::strerror(reason);
    return ::lstat(file.c_str(), &status) == 0 ? "it is a link to nothing" : "it does not exist";
  }
  if (S_ISDIR(status.st_mode)) return "it is a folder";
  if (S_ISFIFO(status.st_mode)) return "it is a fifo";
  if (S_ISSOCK(status.st_mode)) return "it is a socket";
  return S_ISREG(status.st_mode) ? "" : "it is a device";
}

}  // namespace

OpenState::OpenState(const std::string& file) : name_(file) {
  if (const std::string problem = problemOfKind(file); !problem.empty()) refuse(problem);
  open_.descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (open_.descriptor < 0) refuse(std::strerror(errno));
  // HDF5 locks what it has open for writing.
  if (::flock(open_.descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(open_.descriptor);
    refuse("it is locked: another program has it open for writing");
  }
}

OpenState::~OpenState() {
  segments_ = {}, record_ = {}, links_ = {}, file_ = {};
  ::close(open_.descriptor);
}

void OpenState::refuse(const std::string& reason) const {
  throw InputError("state file " + name_ + " cannot be used: " + reason);
}

void OpenState::openGroups() {
  h5::silence();
  const h5::Handle access = h5::accessTo(open_);
  file_ = h5::Handle(H5Fopen(name_.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  if (!file_.valid() && open_.failure != 0) refuse(std::strerror(open_.failure));
  if (!file_.valid()) refuse("not a readable HDF5 file (" + h5::lastError() + ")");
  const h5::Found state = h5::find(file_, "state"), run = h5::find(file_, "run");
  if (state == h5::Found::nothing) refuse("it has no group /state");
  if (state != h5::Found::group) refuse("/state is not a group of this file");
  if (run != h5::Found::nothing && run != h5::Found::group)
    refuse("/run is not a group of this file");
  if (h5::find(file_, "contact") != h5::Found::nothing)
    refuse("it has /contact, which this version of nanoweft does not know");
  const h5::Found link = h5::find(file_, "link");
  if (link != h5::Found::nothing && link != h5::Found::group)
    refuse("/link is not a group of this file");
  segments_ = h5::Handle(H5Gopen2(file_, "state", H5P_DEFAULT), H5Gclose);
  if (!segments_.valid()) refuse("/state cannot be opened (" + h5::lastError() + ")");
  if (run == h5::Found::group) record_ = h5::Handle(H5Gopen2(file_, "run", H5P_DEFAULT), H5Gclose);
  if (link == h5::Found::group) links_ = h5::Handle(H5Gopen2(file_, "link", H5P_DEFAULT), H5Gclose);
  if (link == h5::Found::group && !links_.valid())
    refuse("/link cannot be opened (" + h5::lastError() + ")");
  if (run == h5::Found::group && !record_.valid())
    refuse("/run cannot be opened (" + h5::lastError() + ")");
}

}  // namespace nanoweft
