/// Map from 64-bit keys >= 0 to 32-bit indices (from rows to local indices, from cells to their
/// places), built at every rebuild and looked up in a few nanoseconds: a hash table with open
/// addressing, or a plain array where most keys of a range are present.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace nanoweft {

class IndexMap {
 public:
  explicit IndexMap(std::size_t expected = 0) { makeSlots(expected); }
  /// For keys first <= key <= last.
  IndexMap(std::size_t expected, std::int64_t first, std::int64_t last) : first_(first) {
    // An array of this length takes no more memory than the slots.
    const auto length = static_cast<std::uint64_t>(last - first + 1);
    if (last >= first && length <= 8 * expected)
      dense_.assign(length, -1);
    else
      makeSlots(expected);
  }

  /// Inserts `key` unless present; returns the index stored under it.
  int insert(std::int64_t key, int index) {
    if (!dense_.empty()) {
      int& place = dense_[static_cast<std::size_t>(key - first_)];
      return place < 0 ? place = index : place;
    }
    if (2 * (count_ + 1) > slots_.size()) grow();
    Slot& slot = find(key);
    if (slot.key < 0) {
      slot = {key, index};
      ++count_;
    }
    return slot.index;
  }

  /// Index under `key`, or -1.
  int at(std::int64_t key) const {
    if (!dense_.empty()) {
      const auto place = static_cast<std::uint64_t>(key - first_);
      return place < dense_.size() ? dense_[place] : -1;
    }
    for (std::size_t k = hash(key) & mask_;; k = (k + 1) & mask_) {
      if (slots_[k].key == key) return slots_[k].index;
      if (slots_[k].key < 0) return -1;
    }
  }

 private:
  struct Slot {
    std::int64_t key = -1;
    int index = -1;
  };

  static std::size_t hash(std::int64_t key) {
    auto h = static_cast<std::uint64_t>(key) * 0x9E3779B97F4A7C15ull;
    return static_cast<std::size_t>(h ^ (h >> 32));
  }
  void makeSlots(std::size_t expected) {
    slots_.resize(std::bit_ceil(2 * expected + 16));
    mask_ = slots_.size() - 1;
  }
  Slot& find(std::int64_t key) {
    std::size_t k = hash(key) & mask_;
    while (slots_[k].key >= 0 && slots_[k].key != key) k = (k + 1) & mask_;
    return slots_[k];
  }
  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    mask_ = slots_.size() - 1;
    for (const Slot& s : old)
      if (s.key >= 0) find(s.key) = s;
  }

  std::vector<Slot> slots_;
  std::size_t mask_ = 0, count_ = 0;
  std::vector<int> dense_;  ///< indices by key - first_; empty: `slots_` is in use
  std::int64_t first_ = 0;
};

}  // namespace nanoweft
