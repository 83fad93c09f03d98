/// The partition by METIS of chain pieces. A piece is named by the row of its first segment.
#include <metis.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "nanoweft/base/error.hpp"
#include "nanoweft/domain/deliver.hpp"
#include "nanoweft/domain/partition.hpp"

namespace nanoweft {

namespace {

/// METIS catches these signals while it works and leaves them with handlers that serve once.
class KeptHandlers {
 public:
  KeptHandlers() {
    for (std::size_t k = 0; k < 2; ++k) sigaction(signals[k], nullptr, &kept_[k]);
  }
  ~KeptHandlers() {
    for (std::size_t k = 0; k < 2; ++k) sigaction(signals[k], &kept_[k], nullptr);
  }
  KeptHandlers(const KeptHandlers&) = delete;
  KeptHandlers& operator=(const KeptHandlers&) = delete;

 private:
  static constexpr int signals[2] = {SIGTERM, SIGABRT};
  struct sigaction kept_[2];
};

struct Vertex {
  std::int64_t piece;
  double work;
};

/// A weighted edge of the graph between two pieces, a < b.
struct Edge {
  std::int64_t a, b;
  double weight;
};

/// A piece's segments in or next to a cell.
struct Occupant {
  std::int64_t cell, piece;
  std::int32_t count, guest;  ///< guest: they are in a neighbouring cell
};

std::int64_t pieceOf(std::int64_t row, std::int32_t index, int size) {
  return row - index % size;
}
std::int64_t pieceOf(const State& s, int i, int size) {
  return pieceOf(s.row[i], s.chain[2 * i], size);
}

/// Adds up the weights of equal edges.
void merge(std::vector<Edge>& edges) {
  std::sort(edges.begin(), edges.end(),
            [](const Edge& x, const Edge& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (kept > 0 && edges[kept - 1].a == edges[k].a && edges[kept - 1].b == edges[k].b)
      edges[kept - 1].weight += edges[k].weight;
    else
      edges[kept++] = edges[k];
  }
  edges.resize(kept);
}

Edge tie(std::int64_t a, std::int64_t b, double weight) {
  return {std::min(a, b), std::max(a, b), weight};
}

/// Edges between pieces that are close. Each rank tells the owners of cells which pieces it has in
/// them and next to them. An owner joins the pieces that meet in its cells; the weight of an edge
/// is about the number of their segments that are within range of each other.
std::vector<Edge> closeness(const State& state, const CellGrid& grid, int size) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::int32_t> counts;  // by cell and piece
  for (int i = 0; i < state.owned(); ++i)
    ++counts[{grid.cellOf(state.pose + 8 * i), pieceOf(state, i, size)}];
  std::map<int, std::vector<Occupant>> notices;
  std::vector<std::int64_t> around;
  std::int64_t lastCell = -1;
  for (const auto& [place, count] : counts) {
    const auto& [cell, piece] = place;
    if (cell != lastCell) grid.neighbours(cell, around);
    lastCell = cell;
    for (std::int64_t c : around) notices[grid.owner(c)].push_back({c, piece, count, c != cell});
  }
  std::vector<Occupant> occupants;
  for (const auto& [rank, items] : deliver(state.comm(), notices))
    occupants.insert(occupants.end(), items.begin(), items.end());
  std::sort(occupants.begin(), occupants.end(), [](const Occupant& x, const Occupant& y) {
    return x.cell != y.cell ? x.cell < y.cell : x.guest < y.guest;
  });
  std::vector<Edge> edges;
  for (std::size_t begin = 0, end = 0; begin < occupants.size(); begin = end) {
    while (end < occupants.size() && occupants[end].cell == occupants[begin].cell) ++end;
    for (std::size_t a = begin; a < end && !occupants[a].guest; ++a)
      for (std::size_t b = a + 1; b < end; ++b)
        if (occupants[a].piece != occupants[b].piece)
          // Half the weight: two neighbouring cells both see the pair.
          edges.push_back(tie(
              occupants[a].piece, occupants[b].piece,
              (occupants[b].guest ? 0.5 : 1.0) * std::min(occupants[a].count, occupants[b].count)));
    if (edges.size() > 1000000) merge(edges);
  }
  merge(edges);
  return edges;
}

/// METIS' graph in compressed rows, from what all ranks sent.
class Graph {
 public:
  Graph(std::vector<Vertex> vertices, std::vector<Edge> edges) {
    std::sort(vertices.begin(), vertices.end(),
              [](const Vertex& x, const Vertex& y) { return x.piece < y.piece; });
    double all = 0;
    for (const Vertex& v : vertices) {
      if (pieces.empty() || pieces.back() != v.piece) {
        pieces.push_back(v.piece);
        work_.push_back(0);
      }
      work_.back() += v.work;
      all += v.work;
    }
    merge(edges);
    // Places of edges are numbers of METIS.
    if (2 * edges.size() > static_cast<std::size_t>(std::numeric_limits<idx_t>::max())) return;
    std::vector<idx_t> degree(pieces.size() + 1, 0);
    std::vector<std::pair<idx_t, idx_t>> ends;
    for (const Edge& e : edges) {
      ends.emplace_back(indexOf(e.a), indexOf(e.b));
      ++degree[static_cast<std::size_t>(ends.back().first) + 1];
      ++degree[static_cast<std::size_t>(ends.back().second) + 1];
    }
    for (std::size_t k = 1; k < degree.size(); ++k) degree[k] += degree[k - 1];
    rows_ = degree;
    columns_.resize(2 * edges.size());
    weights_.resize(2 * edges.size());
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const auto weight = static_cast<idx_t>(std::lround(std::clamp(edges[k].weight, 1.0, 1e5)));
      auto put = [&](idx_t from, idx_t to) {
        const auto place = static_cast<std::size_t>(degree[static_cast<std::size_t>(from)]++);
        columns_[place] = to;
        weights_[place] = weight;
      };
      put(ends[k].first, ends[k].second);
      put(ends[k].second, ends[k].first);
    }
    // METIS sums the weights in 32 bits, so they are scaled to a sum of 1e9.
    for (double w : work_)
      vertexWeights_.push_back(
          static_cast<idx_t>(std::lround(std::max(1.0, 1e9 * w / std::max(all, 1e-300)))));
  }

  /// The rank of each piece; empty when METIS fails.
  std::vector<idx_t> divide(int parts) {
    std::vector<idx_t> part(pieces.size());
    std::iota(part.begin(), part.end(), 0);
    if (part.size() <= static_cast<std::size_t>(parts)) return part;
    if (rows_.empty()) return {};
    idx_t vertices = static_cast<idx_t>(pieces.size()), constraints = 1, number = parts, cut = 0;
    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    options[METIS_OPTION_UFACTOR] = 30;  // 3 % above the mean; less makes cuts far longer
    auto attempt = [&] {
      const KeptHandlers kept;
      return METIS_PartGraphKway(&vertices, &constraints, rows_.data(), columns_.data(),
                                 vertexWeights_.data(), nullptr, weights_.data(), &number, nullptr,
                                 nullptr, options, &cut, part.data());
    };
    int status = attempt();
    // METIS takes a SIGTERM that ends this run for its own. Begun again it comes to an end, and the
    // run's handler gets the signal; an error of METIS comes again.
    if (status == METIS_ERROR) {
      status = attempt();
      if (status == METIS_OK) ::raise(SIGTERM);
    }
    if (status != METIS_OK) part.clear();
    return part;
  }

  idx_t indexOf(std::int64_t piece) const {
    return static_cast<idx_t>(std::lower_bound(pieces.begin(), pieces.end(), piece) -
                              pieces.begin());
  }

  std::vector<std::int64_t> pieces;

 private:
  std::vector<double> work_;
  std::vector<idx_t> rows_, columns_, weights_, vertexWeights_;
};

struct Verdict {
  std::int64_t piece;
  std::int32_t rank;
};

template <class T>
std::vector<std::pair<int, std::vector<T>>> toFirst(MPI_Comm comm, std::vector<T> items) {
  std::map<int, std::vector<T>> outgoing;
  outgoing[0] = std::move(items);
  return deliver(comm, outgoing);
}

}  // namespace

std::vector<int> MetisPartitioner::assign(const State& state, const CellGrid& grid,
                                          const std::vector<double>& work, bool again) {
  std::vector<int> destination(static_cast<std::size_t>(state.owned()), state.rank());
  if (divided_ && !again) return destination;
  divided_ = true;

  std::unordered_map<std::int64_t, double> own;
  std::vector<Edge> edges = closeness(state, grid, piece_);
  // More than closeness: a cut bond costs a ghost on each side, and pairs near it are done twice.
  constexpr double bondWeight = 8.0;
  for (int i = 0; i < state.owned(); ++i) {
    const std::int64_t piece = pieceOf(state, i, piece_);
    own[piece] += work[static_cast<std::size_t>(i)];
    for (const Tie& t : state.ties(i))
      if (const std::int64_t other = pieceOf(t.row, t.index, piece_); t.first && other != piece)
        edges.push_back(tie(piece, other, bondWeight));
  }
  for (const Link& link : state.links) {
    const std::int64_t a = pieceOf(link.row[0], link.index[0], piece_),
                       b = pieceOf(link.row[1], link.index[1], piece_);
    if (a != b) edges.push_back(tie(a, b, bondWeight));
  }
  std::vector<Vertex> vertices;
  for (const auto& [piece, sum] : own) vertices.push_back({piece, sum});
  const auto allVertices = toFirst(state.comm(), std::move(vertices));
  const auto allEdges = toFirst(state.comm(), std::move(edges));

  std::map<int, std::vector<Verdict>> verdicts;
  int divided = 1;
  if (state.rank() == 0) {
    std::vector<Vertex> v;
    std::vector<Edge> e;
    for (const auto& [rank, items] : allVertices) v.insert(v.end(), items.begin(), items.end());
    for (const auto& [rank, items] : allEdges) e.insert(e.end(), items.begin(), items.end());
    Graph graph(std::move(v), std::move(e));
    const auto part = graph.divide(state.ranks());
    divided = !part.empty();
    for (const auto& [rank, items] : allVertices)
      for (const Vertex& x : items)
        if (!part.empty())
          verdicts[rank].push_back(
              {x.piece, part[static_cast<std::size_t>(graph.indexOf(x.piece))]});
  }
  MPI_Bcast(&divided, 1, MPI_INT, 0, state.comm());
  if (!divided) {
    PetscPrintf(state.comm(), "warning: METIS cannot divide the fibres; straight cuts do\n");
    return RectilinearPartitioner().assign(state, grid, work, again);
  }
  std::unordered_map<std::int64_t, std::int32_t> rankOf;
  for (const auto& [rank, items] : deliver(state.comm(), verdicts))
    for (const Verdict& v : items) rankOf[v.piece] = v.rank;
  for (int i = 0; i < state.owned(); ++i)
    destination[static_cast<std::size_t>(i)] = rankOf.at(pieceOf(state, i, piece_));
  return destination;
}

}  // namespace nanoweft
