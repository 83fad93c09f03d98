#include "nanoweft/motion/breakage.hpp"

#include <algorithm>
#include <bit>
#include <unordered_map>
#include <utility>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/gather.hpp"
#include "nanoweft/force/pair_list.hpp"

namespace nanoweft {

namespace {

struct Break {
  std::int64_t start;  // row of the fibre's first segment
  std::int32_t index, length, closed;
};

/// Bonds break rarely, so every rank is told of every break. A segment may have gone to another
/// rank since the rank that reports it found its bond broken, so its owner describes it.
std::vector<Break> describe(const State& state, const std::vector<std::int64_t>& rows) {
  std::vector<std::int64_t> sorted = ofAllRanks(rows, state.comm());
  std::ranges::sort(sorted);
  std::vector<Break> mine;
  for (int i = 0; i < state.owned() && !sorted.empty(); ++i)
    if (std::ranges::binary_search(sorted, state.row[i]))
      mine.push_back({state.row[i] - state.chain[2 * i], state.chain[2 * i], state.chain[2 * i + 1],
                      state.bond[i] & fibreClosed});
  return ofAllRanks(mine, state.comm());
}

void spreadBreaks(State& state, int exclude, const std::vector<std::int64_t>& rows) {
  const std::vector<Break> all = describe(state, rows);
  if (all.empty()) return;
  std::unordered_map<std::int64_t, std::vector<Break>> byFibre;
  for (const Break& b : all) byFibre[b.start].push_back(b);
  const int farthest = std::min(exclude, mostExcludeWithBreakage) - 1;
  for (int i = 0; i < state.owned(); ++i) {
    const auto found = byFibre.find(state.row[i] - state.chain[2 * i]);
    if (found == byFibre.end()) continue;
    const int index = state.chain[2 * i], length = state.chain[2 * i + 1];
    for (const Break& b : found->second) {
      // Places from this segment on to the break's first segment, and from its second one back
      // here.
      int on = b.index - index, back = index - (b.index + 1);
      if (b.closed) {
        on = (on % length + length) % length;
        back = (back % length + length) % length;
      }
      if (back == 0) state.bond[i] |= previousBroken;
      if (!state.gap) continue;
      for (int places = 1; places <= farthest; ++places) {
        const bool aheadExists = b.closed || index + places < length,
                   behindExists = b.closed || index >= places;
        if (on >= 0 && places > on && aheadExists) state.gap[4 * i] |= std::int64_t{1} << places;
        if (back >= 0 && places > back && behindExists)
          state.gap[4 * i + 1] |= std::int64_t{1} << places;
      }
    }
  }
}

}  // namespace

void Breaks::spread(State& state) {
  spreadBreaks(state, exclude_, std::exchange(rows_, {}));
}

void spreadOldBreaks(State& state, int exclude) {
  std::vector<std::int64_t> rows;
  for (int i = 0; i < state.owned(); ++i)
    if (state.bond[i] & nextBroken) rows.push_back(state.row[i]);
  spreadBreaks(state, exclude, rows);
}

bool Breaks::release(State& state, const ForceField& forces, const Domain& domain) const {
  if (!state.gap || !forces.pairs() || state.step % gapCheckInterval != 0) return false;
  std::vector<double> reaches;
  for (int k = 0; k < forces.kinds().count(); ++k) {
    const PairForce* own = forces.pairs().between(k, k);
    reaches.push_back(own ? own->reach() : 0.0);
  }
  bool any = false;
  for (int i = 0; i < state.owned(); ++i)
    for (int direction = 0; direction < 2; ++direction) {
      auto waiting = static_cast<std::uint64_t>(state.gap[4 * i + direction] &
                                                ~state.gap[4 * i + 2 + direction]);
      const double reach = reaches[static_cast<std::size_t>(state.kind(i))], reach2 = reach * reach;
      const int index = state.chain[2 * i], length = state.chain[2 * i + 1];
      for (; waiting; waiting &= waiting - 1) {
        const int places = std::countr_zero(waiting);
        const int other =
            ((index + (direction == 0 ? places : -places)) % length + length) % length;
        const int j = domain.localIndex(state.row[i] - index + other);
        // A segment that is not even in the halo is beyond the list's range.
        if (j >= 0) {
          const Vec3d d = forces.nearest()(state.position(j) - state.position(i));
          if (dot(d, d) <= reach2) continue;
        }
        state.gap[4 * i + 2 + direction] |= std::int64_t{1} << places;
        any = true;
      }
    }
  return any;
}

}  // namespace nanoweft
