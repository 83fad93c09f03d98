#include "nanoweft/record/group_table.hpp"

#include <algorithm>
#include <cmath>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/record/table_observer.hpp"

namespace nanoweft {

namespace {

constexpr const char* startPositions = "group_positions";

std::vector<std::string> columnsFor(const Boundaries& boundaries, const UnitSystem& units) {
  std::vector<std::string> columns{timeColumn(units)};
  for (const Boundary& b : boundaries.list()) {
    for (const char* what : {"force", "torque", "position", "displacement"})
      for (const char* axis : {"x", "y", "z"}) columns.push_back(b.name + "_" + what + "_" + axis);
    columns.push_back(b.name + "_work");
  }
  return columns;
}

/// The length that the coordinates of a state have, for the grid of sums.
double lengthScale(const Box& box) {
  double scale = 0;
  for (std::size_t d = 0; d < 3; ++d)
    scale = std::max({scale, std::abs(box.lower[d]), std::abs(box.upper[d])});
  return scale;
}

Vec3d unwrapped(const State& state, int i) {
  return state.box.unwrapped(state.pose + 8 * i, state.image + 3 * i);
}

/// A sum of vectors over the segments of a group, of all ranks.
class VectorSum {
 public:
  explicit VectorSum(double scale) : unit_(scale) {}
  void add(const Vec3d& v) {
    sum_[0].add(v.x, unit_);
    sum_[1].add(v.y, unit_);
    sum_[2].add(v.z, unit_);
  }
  Vec3d total(MPI_Comm comm) {
    ExactSum::reduce(sum_, 3, comm);
    return {sum_[0].value(unit_), sum_[1].value(unit_), sum_[2].value(unit_)};
  }

 private:
  SumUnit unit_;
  ExactSum sum_[3];
};

/// Calls `visit(i)` for the owned members.
template <class Visit>
void forMembers(const State& state, const Boundary& group, const Visit& visit) {
  for (int i = 0; i < state.owned(); ++i)
    if (state.group[i] >> group.bit & 1) visit(i);
}

Vec3d meanPosition(const State& state, const Boundary& group) {
  VectorSum sum(lengthScale(state.box));
  std::int64_t members = 0;
  forMembers(state, group, [&](int i) {
    sum.add(unwrapped(state, i));
    ++members;
  });
  MPI_Allreduce(MPI_IN_PLACE, &members, 1, MPI_INT64_T, MPI_SUM, state.comm());
  return (1.0 / static_cast<double>(members)) * sum.total(state.comm());
}

struct Wrench {
  Vec3d force, torque;
};

/// What the group does to its member i.
Wrench wrenchOn(const State& state, const Boundaries& all, const Boundary& group, int i) {
  const double f = group.factor(state.time);
  const double load[6] = {group.force.x,  group.force.y,  group.force.z,
                          group.torque.x, group.torque.y, group.torque.z};
  double own[6];
  for (int c = 0; c < 6; ++c) {
    const double fibres =
        (c < 3 ? state.force[3 * i + c] : state.torque[3 * i + c - 3]) + state.viscousOn(i, c);
    const bool held = c < 3 ? group.fix[static_cast<std::size_t>(c)] : group.fixRotation;
    const bool lost = state.group[i] & all.holders(static_cast<std::size_t>(c));
    own[c] = held ? -fibres : lost ? 0.0 : f * load[c];
  }
  return {{own[0], own[1], own[2]}, {own[3], own[4], own[5]}};
}

Wrench wrenchOn(const System& system, const Boundary& group, const Vec3d& about) {
  const State& state = system.state;
  const Kinds& kinds = system.forces.kinds();
  const double force = kinds.forceScale();
  VectorSum forces(force), torques(force * std::max(kinds.longest(), lengthScale(state.box)));
  forMembers(state, group, [&](int i) {
    const Wrench own = wrenchOn(state, system.boundaries, group, i);
    forces.add(own.force);
    torques.add(own.torque + cross(unwrapped(state, i) - about, own.force));
  });
  return {forces.total(state.comm()), torques.total(state.comm())};
}

class GroupTable : public TableObserver {
 public:
  GroupTable(Options& options, const UnitSystem& units, const Boundaries& boundaries, long interval)
      : TableObserver(
            options,
            {.option = "group_monitor",
             .help = "force, torque, position, displacement and work of each group of -bc "
                     "through a viewer: ascii:FILE.csv, draw",
             .columns = columnsFor(boundaries, units),
             .abscissa = 0,
             .curves = {1, 2, 3}},
            interval),
        boundaries_(boundaries),
        groups_(boundaries.list().size()) {
    if (wanted() && groups_ == 0)
      throw InputError("-group_monitor: there are no groups; name some by -bc");
  }

  void restore(const RunRecord& record) override {
    if (!record.reals.contains(startPositions))
      throw InputError(
          "-group_monitor: the run that " + record.source +
          " goes on has had no such table, so it does not know the work of the groups");
    starts_ = record.needReals(startPositions, 3 * groups_);
  }
  void save(RunRecord& record) const override { record.reals[startPositions] = starts_; }

  void begin(const Moment& moment) override {
    if (starts_.empty())
      for (std::size_t k = 0; k < groups_; ++k) {
        const Vec3d mean = meanPosition(moment.state(), boundaries_.list()[k]);
        starts_.insert(starts_.end(), {mean.x, mean.y, mean.z});
      }
    TableObserver::begin(moment);
  }

 protected:
  std::vector<double> row(const Moment& moment) override;

 private:
  const Boundaries& boundaries_;
  std::size_t groups_;          ///< the first of the boundaries; the grips of a tension test follow
  std::vector<double> starts_;  ///< three coordinates for each
};

std::vector<double> GroupTable::row(const Moment& moment) {
  const State& state = moment.state();
  const ForceField& forces = moment.system.forces;
  std::vector<ExactSum> work = moment.system.accounts.groups;
  ExactSum::reduce(work.data(), static_cast<int>(work.size()), state.comm());
  std::vector<double> values{state.time};
  for (std::size_t k = 0; k < groups_; ++k) {
    const Boundary& group = boundaries_.list()[k];
    const Vec3d mean = meanPosition(state, group);
    const Wrench wrench =
        wrenchOn(moment.system, group, group.centre ? group.centreAt(state.time) : mean);
    const Vec3d start{starts_[3 * k], starts_[3 * k + 1], starts_[3 * k + 2]};
    for (const Vec3d& v : {wrench.force, wrench.torque, mean, mean - start})
      values.insert(values.end(), {v.x, v.y, v.z});
    values.push_back(work[k].value(forces.energyUnit()));
  }
  return values;
}

}  // namespace

std::unique_ptr<Observer> makeGroupTable(Options& options, const UnitSystem& units,
                                         const Boundaries& boundaries, long interval) {
  auto table = std::make_unique<GroupTable>(options, units, boundaries, interval);
  if (!table->wanted()) return nullptr;
  return table;
}

}  // namespace nanoweft
