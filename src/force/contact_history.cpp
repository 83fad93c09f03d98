#include "nanoweft/force/contact_history.hpp"

#include <algorithm>
#include <bit>

namespace nanoweft {

namespace {

std::int64_t* slotsOf(State& state, int i) {
  return state.contact + contactSlots * static_cast<std::size_t>(i);
}
double* springOf(State& state, int i, int slot) {
  return state.spring +
         3 * (contactSlots * static_cast<std::size_t>(i) + static_cast<std::size_t>(slot));
}

}  // namespace

void ContactHistory::rebuild(const State& state) {
  const auto n = static_cast<std::size_t>(state.owned());
  taken_.assign(n, 0);
  found_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    for (int k = 0; k < contactSlots; ++k)
      if (state.contact[contactSlots * i + static_cast<std::size_t>(k)] != 0) taken_[i] |= 1u << k;
}

void ContactHistory::begin(Share share) {
  std::fill(found_.begin() + share.begin, found_.begin() + share.end, 0u);
}

void ContactHistory::end(State& state, Share share) {
  for (int i = share.begin; i < share.end; ++i) {
    const auto at = static_cast<std::size_t>(i);
    for (std::uint32_t gone = taken_[at] & ~found_[at]; gone != 0; gone &= gone - 1) {
      const int slot = std::countr_zero(gone);
      slotsOf(state, i)[slot] = 0;
      std::fill_n(springOf(state, i, slot), 3, 0.0);
    }
    taken_[at] &= found_[at];
  }
}

double* ContactHistory::find(State& state, int i, std::int64_t partner) {
  const auto at = static_cast<std::size_t>(i);
  std::int64_t* const slots = slotsOf(state, i);
  const std::int64_t key = partner + 1;
  int slot = 0;
  while (slot < contactSlots && slots[slot] != key) ++slot;
  if (slot == contactSlots) {
    slot = std::countr_one(taken_[at]);
    if (slot >= contactSlots) {
      full_.store(true, std::memory_order_relaxed);
      return nullptr;
    }
    slots[slot] = key;
    taken_[at] |= 1u << slot;
  }
  found_[at] |= 1u << slot;
  return springOf(state, i, slot);
}

}  // namespace nanoweft
