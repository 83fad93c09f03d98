#include "nanoweft/force/contact_history.hpp"

#include <algorithm>
#include <array>
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

/// The spring of the contact of two segments; null where there is none.
const double* known(State& state, int i, std::int64_t partner) {
  const std::int64_t* const slots = slotsOf(state, i);
  const auto slot = std::find(slots, slots + contactSlots, partner + 1) - slots;
  return slot < contactSlots ? springOf(state, i, static_cast<int>(slot)) : nullptr;
}

/// Rows of the segment before i along its fibre, of i, and of the one after it; -1: none, or the
/// bond to it is broken.
std::array<std::int64_t, 3> along(const State& state, int i) {
  std::array<std::int64_t, 3> rows{-1, state.row[i], -1};
  const int free = state.freeEnds(i);
  for (const Tie& tie : state.ties(i))
    if (!(free & (tie.first ? freeNext : freePrevious))) rows[tie.first ? 2 : 0] = tie.row;
  return rows;
}

}  // namespace

void ContactHistory::rebuild(const State& state, const Domain& domain) {
  domain_ = &domain;
  const auto n = static_cast<std::size_t>(state.owned());
  taken_.assign(n, 0);
  found_.assign(n, 0);
  fresh_.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    for (int k = 0; k < contactSlots; ++k)
      if (state.contact[contactSlots * i + static_cast<std::size_t>(k)] != 0) taken_[i] |= 1u << k;
}

void ContactHistory::begin(Share share) {
  std::fill(found_.begin() + share.begin, found_.begin() + share.end, 0u);
  std::fill(fresh_.begin() + share.begin, fresh_.begin() + share.end, 0u);
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

ContactHistory::Spring ContactHistory::find(State& state, int i, std::int64_t partner) {
  const auto at = static_cast<std::size_t>(i);
  std::int64_t* const slots = slotsOf(state, i);
  const std::int64_t key = partner + 1;
  int slot = 0;
  while (slot < contactSlots && slots[slot] != key) ++slot;
  if (slot == contactSlots) {
    slot = std::countr_one(taken_[at]);
    if (slot >= contactSlots) {
      full_.store(true, std::memory_order_relaxed);
      return {nullptr, false};
    }
    slots[slot] = key;
    taken_[at] |= 1u << slot;
    fresh_[at] |= 1u << slot;
  }
  found_[at] |= 1u << slot;
  return {springOf(state, i, slot), (fresh_[at] >> slot & 1) != 0};
}

std::vector<ContactHistory::Heir> ContactHistory::heirs(State& state, Share share) const {
  std::vector<Heir> all;
  for (int i = share.begin; i < share.end; ++i)
    for (std::uint32_t left = fresh_[static_cast<std::size_t>(i)]; left != 0; left &= left - 1) {
      const int slot = std::countr_zero(left);
      const std::int64_t partner = slotsOf(state, i)[slot] - 1;
      if (partner < 0) continue;  // a wall
      const Vec3d spring = meanAround(state, i, domain_->localIndex(partner));
      if (norm(spring) > 0) all.push_back({springOf(state, i, slot), spring});
    }
  return all;
}

Vec3d ContactHistory::meanAround(State& state, int i, int j) const {
  const auto own = along(state, i), others = along(state, j);
  const bool first = own[1] < others[1];
  Vec3d sum;
  int count = 0;
  // The threads of both segments add the same springs in the same order.
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      const std::int64_t k = own[first ? a : b], partner = others[first ? b : a];
      if (k < 0 || partner < 0) continue;
      const double* const spring = known(state, domain_->localIndex(k), partner);
      if (!spring || (spring[0] == 0 && spring[1] == 0 && spring[2] == 0)) continue;
      // Where a closed fibre begins, the two segments of a pair change places.
      sum += ((k < partner) == first ? 1.0 : -1.0) * Vec3d{spring[0], spring[1], spring[2]};
      ++count;
    }
  return (count > 0 ? 1.0 / count : 0.0) * sum;
}

}  // namespace nanoweft
