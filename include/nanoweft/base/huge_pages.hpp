/// Large pages for large arrays: the forces of pairs go through them in no order, and each small
/// page that is met for the first time in a while costs a walk through the page tables.
#pragma once

#include <cstddef>

namespace nanoweft {

/// Asks the system to back an array by large pages, those in use already included. A hint: where
/// the system has none to give, nothing happens.
void preferHugePages(void* begin, std::size_t bytes);

}  // namespace nanoweft
