/// Segments with something in every field, told by their row alone, wherever they lie.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "nanoweft/domain/domain.hpp"
#include "nanoweft/state/rest.hpp"
#include "nanoweft/state/state.hpp"

namespace nanoweft::test {

constexpr int fibreLength = 8;
constexpr std::int64_t allRows = 6 * fibreLength, firstClosed = 4 * fibreLength;
constexpr ExtraFields allFields{
    .gap = true, .viscous = true, .rest = true, .ends = true, .friction = true, .extension = true};

/// Six straight fibres side by side lie in it; the last two are closed.
inline Box sceneBox() {
  return {{0, 0, 0}, {100, 100, 100}, {true, true, true}};
}

/// Makes point i the segment of that row. `moved`: from where it usually lies.
inline void setSegment(State& state, int i, std::int64_t row, double moved = 0) {
  for (int k = 0; const Field& f : fields) {
    ++k;
    f.visit(state, [&]<class T>(T* values) {
      for (int c = 0; values && c < f.components; ++c)
        values[f.components * i + c] =
            static_cast<T>(1000.25 * static_cast<double>(row + 1) + 10 * k + c);
    });
  }
  const auto index = static_cast<std::int32_t>(row % fibreLength);
  state.row[i] = row;
  state.fibre[i] = 100 + row / fibreLength;
  state.chain[2 * i] = index;
  state.chain[2 * i + 1] = fibreLength;
  state.bond[i] = (row >= firstClosed ? fibreClosed : 0) | (index == 3 ? nextBroken : 0);
  const auto fibre = static_cast<double>(row / fibreLength);
  const double pose[8] = {
      5 + 12 * fibre, 5 + 8 * fibre + moved, 5.0 + 10 * index, 0, 0.6, 0, 0.8, 0};
  std::copy_n(pose, 8, state.pose + 8 * i);
  if (state.rest) setRest(state, i, {0.01 * static_cast<double>(row), 0.02, -0.03});
}

/// Gives each rank a block of rows, in their order.
inline void fillScene(State& state) {
  const std::int64_t first = allRows * state.rank() / state.ranks(),
                     last = allRows * (state.rank() + 1) / state.ranks();
  state.addOwned(static_cast<int>(last - first));
  for (std::int64_t row = first; row < last; ++row)
    setSegment(state, static_cast<int>(row - first), row);
  state.countTotal();
}

/// All rows on every rank, to compare with.
class Reference {
 public:
  explicit Reference(double moved = 0) {
    all_.addOwned(allRows);
    for (int i = 0; i < allRows; ++i) setSegment(all_, i, i, moved);
  }
  const State& state() const { return all_; }
  /// Has point i of `state` the bits of its row in this field?
  bool same(const Field& f, const State& state, int i) const {
    const std::size_t bytes = f.bytes();
    return std::memcmp(f.data(state) + bytes * static_cast<std::size_t>(i),
                       f.data(all_) + bytes * static_cast<std::size_t>(state.row[i]), bytes) == 0;
  }
  void expectOwned(const State& state) const {
    for (const Field& f : fields)
      for (int i = 0; i < state.owned(); ++i)
        ASSERT_TRUE(same(f, state, i)) << f.name << " of row " << state.row[i];
  }

 private:
  State all_{PETSC_COMM_SELF, sceneBox(), allFields};
};

/// Is each row on one rank? Collective.
inline void expectEveryRowOnce(const State& state) {
  std::array<int, allRows> count{};
  for (int i = 0; i < state.owned(); ++i) ++count[static_cast<std::size_t>(state.row[i])];
  MPI_Allreduce(MPI_IN_PLACE, count.data(), allRows, MPI_INT, MPI_SUM, state.comm());
  for (std::size_t row = 0; row < allRows; ++row) EXPECT_EQ(count[row], 1) << "row " << row;
}

}  // namespace nanoweft::test
