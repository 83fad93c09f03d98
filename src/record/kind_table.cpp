#include "nanoweft/record/kind_table.hpp"

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/threads.hpp"
#include "nanoweft/force/bond_geometry.hpp"
#include "nanoweft/record/carriers.hpp"
#include "nanoweft/record/interactions.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

/// Energies of a kind, in this order in the table.
enum Part { stretch, shear, bending, torsion, kinetic, rotational, parts };
constexpr const char* partNames[parts] = {"stretch", "shear",   "bending",
                                          "torsion", "kinetic", "rotational"};

std::vector<std::string> columnsFor(const Kinds& kinds, const UnitSystem& units) {
  std::vector<std::string> columns{timeColumn(units)};
  for (const Fibre& f : kinds)
    for (const char* part : partNames) columns.push_back(f.kind + "_" + part);
  const auto carriers = carrierNames(kinds);
  columns.insert(columns.end(), carriers.begin() + kinds.count(), carriers.end());
  return columns;
}

class KindTable : public TableObserver {
 public:
  KindTable(Options& options, const UnitSystem& units, const Kinds& kinds, long interval)
      : TableObserver(
            options,
            {.option = "kind_monitor",
             .help = "energies of each kind of fibre through a viewer: ascii:FILE.csv, draw",
             .columns = columnsFor(kinds, units),
             .abscissa = 0,
             .curves = {1, 2, 3, 4}},
            interval),
        kinds_(kinds) {
    if (wanted() && kinds[0].kind.empty())
      throw InputError("-kind_monitor: the fibres have no kinds; name them by -kinds");
  }

 protected:
  std::vector<double> row(const Moment& moment) override;

 private:
  std::size_t pairColumn(int a, int b) const;
  void addShare(const System& s, std::size_t thread, std::vector<ExactSum>& sums) const;

  const Kinds& kinds_;
};

/// Place of the pairs of two kinds behind the kinds' own columns.
std::size_t KindTable::pairColumn(int a, int b) const {
  const int n = kinds_.count();
  return static_cast<std::size_t>((parts - 1) * n + Carriers{n}.ofPair(a, b));
}

/// Adds what belongs to a thread's segments; a bond or pair belongs to its first one.
void KindTable::addShare(const System& s, std::size_t thread, std::vector<ExactSum>& sums) const {
  const State& state = s.state;
  const SumUnit& unit = s.forces.energyUnit();
  const Share share = s.forces.shares()[thread];
  for (int i = share.begin; i < share.end; ++i) {
    const int kind = state.kind(i);
    const Fibre& fibre = kinds_[kind];
    auto add = [&](Part part, double value) {
      sums[static_cast<std::size_t>(parts * kind + part)].add(value, unit);
    };
    const double* v = state.velocity + 3 * i;
    const double* w = state.angular + 3 * i;
    add(kinetic, 0.5 * fibre.mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    add(rotational, 0.5 * fibre.inertia * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
    for (const Tie& tie : state.ties(i)) {
      if (tie.broken || !tie.first) continue;
      const auto u = bondEnergy(
          state, kinds_, i,
          bondGeometry(state, kinds_, s.forces.nearest(), i, s.domain.partner(state, i, tie)));
      add(stretch, u.stretch);
      add(shear, u.shear);
      add(bending, u.bending);
      add(torsion, u.torsion);
    }
  }
  forEachPair(state, s.forces, thread,
              [&](const PairForce& force, const ListPair& p, const Vec3d& d) {
                if (p.i < share.begin || p.i >= share.end) return;
                const int a = state.kind(p.i), b = state.kind(p.j);
                sums[pairColumn(a, b)].add(resolved(state, force, p, d).energy, unit);
              });
}

std::vector<double> KindTable::row(const Moment& moment) {
  const System& s = moment.system;
  const SumUnit& unit = s.forces.energyUnit();
  const std::size_t columns = pairColumn(kinds_.count() - 1, kinds_.count() - 1) + 2;
  std::vector<ExactSum> total(columns);
  onShares(s.forces.shares().size(), [&](std::size_t t) {
    std::vector<ExactSum> sums(columns);
    addShare(s, t, sums);
#pragma omp critical
    for (std::size_t k = 0; k < columns; ++k) total[k].merge(sums[k]);
  });
  for (std::size_t k = 0; k < s.state.links.size(); ++k)
    if (!s.state.links[k].broken && s.forces.links().ends(k)[0] < s.state.owned())
      total.back().add(s.forces.links().resolve(s.state, s.forces.nearest(), k).energy.total(),
                       unit);
  ExactSum::reduce(total.data(), static_cast<int>(columns), s.state.comm());
  std::vector<double> values{s.state.time};
  for (const ExactSum& sum : total) values.push_back(sum.value(unit));
  return values;
}

}  // namespace

std::unique_ptr<Observer> makeKindTable(Options& options, const UnitSystem& units,
                                        const Kinds& kinds, long interval) {
  auto table = std::make_unique<KindTable>(options, units, kinds, interval);
  if (!table->wanted()) return nullptr;
  return table;
}

}  // namespace nanoweft
