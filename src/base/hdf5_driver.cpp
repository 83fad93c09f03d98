#include "nanoweft/base/hdf5_driver.hpp"

#include <sys/stat.h>
#include <unistd.h>
#if __has_include(<H5FDdevelop.h>)  // HDF5 1.14
#include <H5FDdevelop.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace nanoweft::h5 {

namespace {

struct Driven : H5FD_t {
  OpenFile* file = nullptr;
  haddr_t allocated = 0, end = 0;
  /// Metadata that could not be written, in the order of the writes: HDF5 may want to read it
  /// again.
  std::vector<std::pair<haddr_t, std::string>> unwritten;
};

Driven& driven(H5FD_t* f) {
  return *static_cast<Driven*>(f);
}
const Driven& driven(const H5FD_t* f) {
  return *static_cast<const Driven*>(f);
}

H5FD_t* openDriven(const char*, unsigned, hid_t access, haddr_t) {
  const auto* const given = static_cast<OpenFile* const*>(H5Pget_driver_info(access));
  struct stat status {};
  if (!given || ::fstat((*given)->descriptor, &status) != 0) return nullptr;
  auto* const made = new (std::nothrow) Driven{};
  if (!made) return nullptr;
  made->file = *given;
  made->end = static_cast<haddr_t>(status.st_size);
  return made;
}

herr_t closeDriven(H5FD_t* f) {
  delete &driven(f);
  return 0;
}

/// Two open files never count as the same one, since each keeps a failure of its own.
int compare(const H5FD_t* a, const H5FD_t* b) {
  return a < b ? -1 : a > b ? 1 : 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags)
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t allocated(const H5FD_t* f, H5FD_mem_t) {
  return driven(f).allocated;
}

herr_t allocate(H5FD_t* f, H5FD_mem_t, haddr_t address) {
  driven(f).allocated = address;
  return 0;
}

haddr_t endOf(const H5FD_t* f, H5FD_mem_t) {
  return driven(f).end;
}

herr_t readDriven(H5FD_t* f, H5FD_mem_t, hid_t, haddr_t address, size_t size, void* buffer) {
  Driven& d = driven(f);
  char* const out = static_cast<char*>(buffer);
  size_t got = 0;
  while (got < size) {
    const ssize_t n =
        ::pread(d.file->descriptor, out + got, size - got, static_cast<off_t>(address + got));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      if (d.file->failure == 0) d.file->failure = errno;
      return -1;
    }
    if (n == 0) break;
    got += static_cast<size_t>(n);
  }
  // What lies behind the end has not been written yet.
  std::memset(out + got, 0, size - got);
  for (const auto& [at, bytes] : d.unwritten) {
    const haddr_t from = std::max(at, address),
                  to = std::min(at + bytes.size(), address + static_cast<haddr_t>(size));
    if (from < to) std::memcpy(out + (from - address), bytes.data() + (from - at), to - from);
  }
  return 0;
}

herr_t writeDriven(H5FD_t* f, H5FD_mem_t type, hid_t, haddr_t address, size_t size,
                   const void* buffer) {
  Driven& d = driven(f);
  const char* const bytes = static_cast<const char*>(buffer);
  size_t done = 0;
  while (done < size && d.file->failure == 0) {
    const ssize_t n =
        ::pwrite(d.file->descriptor, bytes + done, size - done, static_cast<off_t>(address + done));
    if (n > 0)
      done += static_cast<size_t>(n);
    else if (n == 0 || errno != EINTR)
      d.file->failure = n == 0 ? ENOSPC : errno;
  }
  if (done < size && type != H5FD_MEM_DRAW) {
    try {
      d.unwritten.emplace_back(address, std::string(bytes, size));
    } catch (const std::bad_alloc&) {
      return -1;
    }
  }
  d.end = std::max(d.end, address + static_cast<haddr_t>(size));
  return 0;
}

herr_t truncate(H5FD_t* f, hid_t, hbool_t) {
  Driven& d = driven(f);
  if (d.end == d.allocated) return 0;
  if (d.file->failure == 0 && ::ftruncate(d.file->descriptor, static_cast<off_t>(d.allocated)) != 0)
    d.file->failure = errno;
  d.end = d.allocated;
  return 0;
}

hid_t driver() {
  static const hid_t registered = [] {
    static H5FD_class_t c{};
#ifdef H5FD_CLASS_VERSION
    c.version = H5FD_CLASS_VERSION;
    c.value = 511;  // of those that HDF5 leaves to unregistered drivers
#endif
    c.name = "nanoweft";
    c.maxaddr = static_cast<haddr_t>(std::numeric_limits<off_t>::max());
    c.fc_degree = H5F_CLOSE_WEAK;
    c.fapl_size = sizeof(OpenFile*);
    c.open = openDriven;
    c.close = closeDriven;
    c.cmp = compare;
    c.query = query;
    c.get_eoa = allocated;
    c.set_eoa = allocate;
    c.get_eof = endOf;
    c.read = readDriven;
    c.write = writeDriven;
    c.truncate = truncate;
    const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(map), std::end(map), c.fl_map);
    return H5FDregister(&c);
  }();
  return registered;
}

}  // namespace

Handle accessTo(OpenFile& file) {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  OpenFile* const info = &file;
  H5Pset_driver(access, driver(), &info);
  return access;
}

}  // namespace nanoweft::h5
