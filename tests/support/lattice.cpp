#include "support/lattice.hpp"

#include <random>
#include <vector>

#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {

void writeLattice(const std::string& file, double off) {
  constexpr int n = Lattice::n;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> part(-off, off);
  std::vector<FibreInput> nodes;
  std::vector<LinkEnds> links;
  auto node = [&](int i, int j) { return (j % n) * n + (i % n + n) % n; };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int odd = j % 2;
      nodes.push_back(straightFibre({(i + 0.5 * odd + 0.1) * Lattice::a + part(random),
                                     (j + 0.1) * Lattice::rise + part(random), 0},
                                    {1, 0, 0}, 1));
      for (const int other : {node(i + 1, j), node(i + odd, j + 1), node(i + odd - 1, j + 1)})
        links.push_back({node(i, j), 0, other, 0});
    }
  writeState(file, nodes,
             {{0, 0, -50}, {n * Lattice::a, n * Lattice::rise, 50}, {true, true, false}});
  setLinks(file, links);
}

}  // namespace nanoweft::test
