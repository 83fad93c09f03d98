/// Large pages for large arrays. The pair kernel visits the arrays of segments in no order; with
/// small pages, many visits would cost a walk through the page tables.
#pragma once

#include <cstddef>

namespace nanoweft {

/// Asks the system to back an array by large pages, also where it has been written to before. This
/// is a hint: a system that has no large pages to give does nothing.
void preferHugePages(void* begin, std::size_t bytes);

}  // namespace nanoweft
