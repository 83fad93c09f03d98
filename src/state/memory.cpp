#include "nanoweft/state/memory.hpp"

#include <sys/resource.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "nanoweft/base/error.hpp"

namespace nanoweft {

namespace {

/// Places of a rank's segments are 32-bit, and those of its poses eight times as large.
constexpr std::int64_t mostSegments = 2147483647 / 8;

std::string tooMany(std::int64_t segments) {
  return format("%lld segments on one rank; at most %lld: take more ranks",
                static_cast<long long>(segments), static_cast<long long>(mostSegments));
}

/// Address space that this process may still ask for.
double leftOfLimit() {
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return 1e300;
  double pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

/// All memory that this computer, or the container that this runs in, has.
double memoryHere() {
  struct sysinfo info {};
  double most = 1e300;
  if (::sysinfo(&info) == 0)
    most = static_cast<double>(info.totalram + info.totalswap) * info.mem_unit;
  double container = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> container; container > 0)
    most = std::min(most, container);
  return most;
}

}  // namespace

void requirePlaces(MPI_Comm comm, std::int64_t segments) {
  agree<RunError>(comm, segments > mostSegments ? tooMany(segments) : "");
}

void requireMemory(MPI_Comm comm, std::int64_t segments, double bytesPerSegment) {
  const double needed = bytesPerSegment * static_cast<double>(segments);
  MPI_Comm node;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  double neededHere = 0;
  MPI_Allreduce(&needed, &neededHere, 1, MPI_DOUBLE, MPI_SUM, node);
  MPI_Comm_free(&node);
  std::string problem;
  auto tooLarge = [&](double bytes, double there, const char* where) {
    if (bytes > there && problem.empty())
      problem = format(
          "not enough memory: the segments take %.3g GB and more, and %s %.3g GB; take fewer "
          "segments or more computers",
          bytes / 1e9, where, std::max(there, 0.0) / 1e9);
  };
  if (segments > mostSegments) problem = tooMany(segments);
  tooLarge(needed, leftOfLimit(), "the limit of this process (ulimit -v) leaves");
  tooLarge(neededHere, memoryHere(), "this computer has");
  agree<RunError>(comm, problem);
}

}  // namespace nanoweft
