#include "nanoweft/record/gage_stress.hpp"

#include <algorithm>
#include <limits>

#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/base/threads.hpp"
#include "nanoweft/force/bond_geometry.hpp"
#include "nanoweft/record/carriers.hpp"
#include "nanoweft/record/interactions.hpp"

namespace nanoweft {

namespace {

/// The region between two planes across an axis.
struct Gage {
  int axis;
  double lower, upper;

  double held(double x) const { return std::clamp(x, lower, upper); }
  bool contains(double x) const { return x > lower && x < upper; }
  /// Part of the line from `from` to `to` that lies inside.
  double part(double from, double to) const {
    return from == to ? contains(from) : (held(to) - held(from)) / (to - from);
  }
};

Gage findGage(const State& state, int axis, double segment) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double faces[2] = {-infinity, -infinity};  // a and -b
  for (int i = 0; i < state.owned(); ++i) {
    const double x = state.pose[8 * i + axis];
    if (state.group[i] >> leftGripBit & 1) faces[0] = std::max(faces[0], x);
    if (state.group[i] >> rightGripBit & 1) faces[1] = std::max(faces[1], -x);
  }
  MPI_Allreduce(MPI_IN_PLACE, faces, 2, MPI_DOUBLE, MPI_MAX, state.comm());
  const double between = -faces[1] - faces[0], inset = std::min(0.5 * segment, 0.25 * between);
  return {axis, faces[0] + inset, -faces[1] - inset};
}

/// Sum of symmetric dyads: xx, yy, zz, xy, xz, yz; and of what the dyads yx, zx, zy have beyond
/// these.
struct DyadSum {
  SumUnit unit;
  ExactSum sum[9];

  void add(double factor, const Vec3d& a, const Vec3d& b) {
    sum[0].add(factor * a.x * b.x, unit);
    sum[1].add(factor * a.y * b.y, unit);
    sum[2].add(factor * a.z * b.z, unit);
    sum[3].add(0.5 * factor * (a.x * b.y + a.y * b.x), unit);
    sum[4].add(0.5 * factor * (a.x * b.z + a.z * b.x), unit);
    sum[5].add(0.5 * factor * (a.y * b.z + a.z * b.y), unit);
    sum[6].add(0.5 * factor * (a.y * b.x - a.x * b.y), unit);
    sum[7].add(0.5 * factor * (a.z * b.x - a.x * b.z), unit);
    sum[8].add(0.5 * factor * (a.z * b.y - a.y * b.z), unit);
  }
};

/// A thread's part of the virial, a sum for each carrier. Each bond and pair counts for the owner
/// of its first segment.
void addVirial(const State& state, const Domain& domain, const ForceField& forces, const Gage& gage,
               std::size_t thread, std::vector<DyadSum>& sums) {
  const Share share = forces.shares()[thread];
  const Carriers carriers{forces.kinds().count()};
  auto sum = [&](int carrier) -> DyadSum& { return sums[static_cast<std::size_t>(carrier)]; };
  auto along = [&](int i) { return state.pose[8 * i + gage.axis]; };
  for (int i = share.begin; i < share.end; ++i) {
    DyadSum& own = sum(carriers.ofKind(state.kind(i)));
    const double* v = state.velocity + 3 * i;
    const bool free = !(state.group[i] & (1 << leftGripBit | 1 << rightGripBit));
    if (free && gage.contains(along(i)))
      own.add(-forces.kinds()[state.kind(i)].mass, {v[0], v[1], v[2]}, {v[0], v[1], v[2]});
    for (const Tie& tie : state.ties(i)) {
      if (tie.broken || !tie.first) continue;
      const int j = domain.partner(state, i, tie);
      if (const double part = gage.part(along(i), along(j)); part > 0) {
        const auto bond = bondGeometry(state, forces.kinds(), forces.nearest(), i, j);
        own.add(part, bond.separation, bondLaw(state, forces.kinds(), i).force(bond).force);
      }
    }
  }
  for (std::size_t k = 0; thread == 0 && k < state.links.size(); ++k) {
    const auto [i, j] = forces.links().ends(k);
    if (state.links[k].broken || i >= state.owned()) continue;
    const auto link = forces.links().resolve(state, forces.nearest(), k);
    if (const double part = gage.part(along(i), along(j)); part > 0)
      sum(carriers.links()).add(part, link.separation, link.force.force);
  }
  forEachPair(state, forces, thread,
              [&](const PairForce& force, const ListPair& p, const Vec3d& d) {
                if (p.i < share.begin || p.i >= share.end) return;
                if (const double part = gage.part(along(p.i), along(p.j)); part > 0)
                  sum(carriers.ofPair(state.kind(p.i), state.kind(p.j)))
                      .add(part, d, resolved(state, force, p, d).force);
              });
}

/// The virial by carriers, of all ranks; and the numbers that make stresses of it.
struct Virial {
  std::vector<DyadSum> sums;
  double volume;
};

Virial virialIn(const State& state, const Domain& domain, const ForceField& forces,
                const Gage& gage, double volume) {
  const std::size_t threads = forces.shares().size();
  const std::vector<DyadSum> zero(
      static_cast<std::size_t>(Carriers{forces.kinds().count()}.count()),
      DyadSum{forces.energyUnit(), {}});
  Virial total{zero, volume};
#pragma omp parallel for schedule(static, 1) num_threads(teamOf(threads))
  for (std::size_t t = 0; t < threads; ++t) {
    std::vector<DyadSum> own = zero;
    addVirial(state, domain, forces, gage, t, own);
#pragma omp critical
    for (std::size_t c = 0; c < own.size(); ++c)
      for (std::size_t k = 0; k < 9; ++k) total.sums[c].sum[k].merge(own[c].sum[k]);
  }
  return total;
}

Virial virialOf(const State& state, const Domain& domain, const ForceField& forces,
                const Tension& tension) {
  const Gage gage = findGage(state, tension.axis, forces.kinds().longest());
  return virialIn(state, domain, forces, gage,
                  (gage.upper - gage.lower) * tension.width * tension.thickness);
}

/// The stress of all carriers together. Collective.
std::array<double, 9> sumOf(const Virial& virial, const ForceField& forces, const UnitSystem& units,
                            MPI_Comm comm) {
  DyadSum total{forces.energyUnit(), {}};
  for (const DyadSum& own : virial.sums)
    for (std::size_t k = 0; k < 9; ++k) total.sum[k].merge(own.sum[k]);
  ExactSum::reduce(total.sum, 9, comm);
  std::array<double, 9> stress;
  for (std::size_t k = 0; k < 9; ++k)
    stress[k] = total.sum[k].value(total.unit) / (virial.volume * units.gigapascal);
  return stress;
}

}  // namespace

std::array<double, 6> gageStress(const State& state, const Domain& domain, const ForceField& forces,
                                 const Tension& tension, const UnitSystem& units) {
  const auto all = sumOf(virialOf(state, domain, forces, tension), forces, units, state.comm());
  std::array<double, 6> symmetric;
  std::copy_n(all.begin(), 6, symmetric.begin());
  return symmetric;
}

std::array<double, 9> boxStress(const State& state, const Domain& domain, const ForceField& forces,
                                double volume, const UnitSystem& units) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Gage everything{0, -infinity, infinity};
  auto stress =
      sumOf(virialIn(state, domain, forces, everything, volume), forces, units, state.comm());
  for (std::size_t k = 6; k < 9; ++k) stress[k] += stress[k - 3];
  return stress;
}

std::vector<double> carriedStress(const State& state, const Domain& domain,
                                  const ForceField& forces, const Tension& tension,
                                  const UnitSystem& units) {
  const Virial virial = virialOf(state, domain, forces, tension);
  std::vector<ExactSum> axial;
  for (const DyadSum& own : virial.sums) axial.push_back(own.sum[tension.axis]);
  ExactSum::reduce(axial.data(), static_cast<int>(axial.size()), state.comm());
  std::vector<double> stress;
  for (const ExactSum& sum : axial)
    stress.push_back(sum.value(forces.energyUnit()) / (virial.volume * units.gigapascal));
  return stress;
}

}  // namespace nanoweft
