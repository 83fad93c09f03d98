#include "nanoweft/base/huge_pages.hpp"

#include <sys/mman.h>

#include <cstdint>

namespace nanoweft {

void preferHugePages(void* begin, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t page = 2 << 20;
  const auto from = reinterpret_cast<std::uintptr_t>(begin);
  const std::uintptr_t first = (from + page - 1) / page * page, last = (from + bytes) / page * page;
  if (last <= first) return;
  madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#ifdef MADV_COLLAPSE
  // What has been written to would keep its small pages otherwise (Linux 6.1 on; fails before).
  madvise(reinterpret_cast<void*>(first), last - first, MADV_COLLAPSE);
#endif
#endif
}

}  // namespace nanoweft
