#include "nanoweft/domain/link_moves.hpp"

#include <algorithm>
#include <unordered_map>

#include "nanoweft/domain/deliver.hpp"

namespace nanoweft {

void moveLinks(State& state, const std::vector<int>& destination) {
  std::unordered_map<std::int64_t, int> rankOf;  // of the owned segments that have links
  for (const Link& link : state.links)
    for (const std::int64_t row : link.row) rankOf.try_emplace(row, -1);
  for (int i = 0; i < state.owned(); ++i)
    if (const auto at = rankOf.find(state.row[i]); at != rankOf.end())
      at->second = destination[static_cast<std::size_t>(i)];
  std::map<int, Links> outgoing;
  for (const Link& link : state.links) {
    const int a = rankOf.at(link.row[0]), b = rankOf.at(link.row[1]);
    if (a >= 0) outgoing[a].push_back(link);
    if (b >= 0 && b != a) outgoing[b].push_back(link);
  }
  state.links.clear();
  for (auto& [rank, links] : deliver(state.comm(), outgoing))
    state.links.insert(state.links.end(), links.begin(), links.end());
  // A link whose ends came from two ranks to one has come twice.
  std::ranges::sort(state.links, {}, &Link::id);
  const auto twice = std::ranges::unique(state.links, {}, &Link::id);
  state.links.erase(twice.begin(), twice.end());
}

}  // namespace nanoweft
