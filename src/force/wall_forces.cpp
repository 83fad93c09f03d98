#include "nanoweft/force/wall_forces.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

namespace nanoweft {

namespace {

constexpr int points = 6;  ///< of a segment

/// Place of a point along its segment, in lengths of it from the centre.
double placeOf(int point) {
  return (point + 0.5) / points - 0.5;
}

void addTo(ExactSum* sum, const Vec3d& v, double sign, const SumUnit& unit) {
  sum[0].add(sign * v.x, unit);
  sum[1].add(sign * v.y, unit);
  sum[2].add(sign * v.z, unit);
}

void addAt(double* to, const Vec3d& v) {
  to[0] += v.x;
  to[1] += v.y;
  to[2] += v.z;
}

}  // namespace

WallForces::WallForces(Walls walls, const Kinds& kinds)
    : walls_(std::move(walls)),
      kinds_(kinds),
      energyUnit_(kinds.energyScale()),
      forceUnit_(kinds.forceScale()),
      felt_(walls_.size()) {}

bool WallForces::rub() const {
  return std::ranges::any_of(walls_, [](const Wall& w) { return bool(w.friction); });
}

bool WallForces::driven() const {
  return std::ranges::any_of(walls_, [](const Wall& w) { return w.driven(); });
}

void WallForces::add(State& state, ContactHistory* history, const Terms& terms, Share share,
                     WallTally& tally) const {
  tally.felt.resize(walls_.size());
  for (int i = share.begin; i < share.end; ++i) {
    const Fibre& fibre = kinds_[state.kind(i)];
    const double reach = fibre.radius + 0.5 * fibre.length;
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      const Vec3d x = terms.nearest(state.position(i) - walls_[w].at());
      if (walls_[w].see(x).gap < reach)
        touch(state, history, terms, {i, w, x, axis1(state.orientation(i)), fibre}, tally);
    }
  }
}

double WallForces::stiffnessOf(const Wall& wall, int kind) const {
  const double piece = kinds_[kind].length / points;
  return 0.25 * std::numbers::pi * wall.modulus[static_cast<std::size_t>(kind)] * piece;
}

void WallForces::touch(State& state, ContactHistory* history, const Terms& terms,
                       const Place& place, WallTally& tally) const {
  const auto& [i, number, x, axis, fibre] = place;
  const Wall& wall = walls_[number];
  const double line = stiffnessOf(wall, state.kind(i));
  Vec3d force, torque;
  ContactPatch patch;
  patch.share = 1;
  double energy = 0;
  for (int k = 0; k < points; ++k) {
    const double u = placeOf(k) * fibre.length;
    const Wall::Sight sight = wall.see(x + u * axis);
    const double overlap = fibre.radius - sight.gap;
    if (!(overlap > 0)) continue;
    const double load = line * overlap;
    energy += 0.5 * load * overlap;
    force += load * sight.normal;
    torque += (u * load) * cross(axis, sight.normal);
    patch.load += load;
    patch.stiffness += line;
    patch.placeI += load * u;
    patch.overlap += load * overlap;
    patch.normal -= load * sight.normal;  // towards the wall
  }
  if (!(patch.load > 0)) return;
  addAt(state.force + 3 * i, force);
  addAt(state.torque + 3 * i, torque);
  tally.energy.add(energy, energyUnit_);
  WallTally::Felt& felt = tally.felt[number];
  addTo(felt.force, force, -1.0, forceUnit_);
  addTo(felt.torque, cross(x, force) + torque, -1.0, energyUnit_);
  if (!wall.driven()) {
    const Vec3d now = wall.wayAt(terms.time);
    if (terms.dt > 0)
      tally.external.add(0.5 * dot(force, now - wall.wayAt(terms.time - terms.dt)), energyUnit_);
    if (terms.ahead > 0)
      tally.ahead.add(0.5 * dot(force, wall.wayAt(terms.time + terms.ahead) - now), energyUnit_);
  }
  if (!wall.friction || !terms.viscous || !history) return;
  patch.placeI /= patch.load;
  patch.overlap /= patch.load;
  if (const double size = norm(patch.normal); size > 0) {
    patch.normal = (1.0 / size) * patch.normal;
    rubAt(state, *history, terms, place, patch, tally);
  }
}

void WallForces::rubAt(State& state, ContactHistory& history, const Terms& terms,
                       const Place& place, const ContactPatch& patch, WallTally& tally) const {
  const auto& [i, number, x, axis, fibre] = place;
  const Wall& wall = walls_[number];
  // Walls stand among the partners with negative rows.
  double* const spring = history.find(state, i, -2 - static_cast<std::int64_t>(number)).at;
  if (!spring) return;
  const Vec3d lever = patch.placeI * axis + (fibre.radius - 0.5 * patch.overlap) * patch.normal;
  // Velocities are those half a step back.
  const Vec3d surface = wall.surfaceVelocity(wall.at() + x + lever, terms.time - 0.5 * terms.dt);
  FrictionLaw law = wall.friction;
  law.mass = fibre.mass;
  const auto action = law.act(
      patch, lever, axis, fibre.radius,
      {triple(state.velocity, i), surface, triple(state.angular, i), Vec3d{}}, terms.dt, spring);
  addAt(state.viscous + 6 * i, action.forceI);
  addAt(state.viscous + 6 * i + 3, action.torqueI);
  tally.friction.add(action.power * terms.dt, energyUnit_);
  // Steppers book all work of friction on the fibres as damped; the wall's part comes from whoever
  // moves the wall, or, where it is driven, from the wall's own motion (`kick`).
  const Vec3d prescribed = wall.driven() ? surface - wall.speed : surface;
  const double work = dot(action.forceI, prescribed) * terms.dt;
  tally.external.add(work, energyUnit_);
  tally.dragged.add(work, energyUnit_);
  WallTally::Felt& felt = tally.felt[number];
  addTo(felt.friction, action.forceI, -1.0, forceUnit_);
  addTo(felt.force, action.forceI, -1.0, forceUnit_);
  addTo(felt.torque, cross(x + lever, action.forceI), -1.0, energyUnit_);
}

void WallForces::note(const std::vector<WallTally>& tallies) {
  felt_.assign(walls_.size(), {});
  for (const WallTally& tally : tallies)
    for (std::size_t w = 0; w < tally.felt.size(); ++w)
      for (int c = 0; c < 3; ++c) {
        felt_[w].force[c].merge(tally.felt[w].force[c]);
        felt_[w].torque[c].merge(tally.felt[w].torque[c]);
        felt_[w].friction[c].merge(tally.felt[w].friction[c]);
      }
}

void WallForces::noteAhead(const std::vector<WallTally>& tallies) {
  ahead_ = {};
  for (const WallTally& tally : tallies) ahead_.merge(tally.ahead);
}

std::vector<double> WallForces::felt(MPI_Comm comm) const {
  std::vector<ExactSum> sums;
  for (const WallTally::Felt& f : felt_) {
    sums.insert(sums.end(), f.force, f.force + 3);
    sums.insert(sums.end(), f.torque, f.torque + 3);
    sums.insert(sums.end(), f.friction, f.friction + 3);
  }
  ExactSum::reduce(sums.data(), static_cast<int>(sums.size()), comm);
  std::vector<double> values;
  for (std::size_t k = 0; k < sums.size(); ++k)
    values.push_back(sums[k].value(k % 9 / 3 == 1 ? energyUnit_ : forceUnit_));
  return values;
}

void WallForces::kick(MPI_Comm comm, double time, double h, const Accounts& accounts) {
  if (!driven()) return;
  const std::vector<double> all = felt(comm);
  int rank;
  MPI_Comm_rank(comm, &rank);
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    Wall& wall = walls_[w];
    if (!wall.driven()) continue;
    const Vec3d along = (1.0 / norm(wall.force)) * wall.force, before = wall.speed,
                push = wall.factor(time) * wall.force - wall.drag * before;
    const Vec3d felt = triple(all.data(), 3 * static_cast<int>(w)),
                friction = triple(all.data(), 3 * static_cast<int>(w) + 2);
    wall.speed += (h / wall.mass * dot(push + felt, along)) * along;
    if (rank != 0) continue;
    // What the push puts in and drag takes out, and what friction takes from the wall: the same on
    // all ranks, so one books it.
    const Vec3d way = 0.5 * h * (before + wall.speed);
    accounts.external.add(dot(push, way), energyUnit_);
    accounts.damped.add(-dot(friction, way), energyUnit_);
  }
}

void WallForces::move(MPI_Comm comm, double time, double dt, const Accounts& accounts) {
  accounts.external.merge(std::exchange(ahead_, {}));
  kick(comm, time, 0.5 * dt, accounts);
  for (Wall& wall : walls_) {
    if (wall.driven())
      wall.moved += dt * wall.speed;
    else
      wall.moved = wall.wayAt(time + dt);
  }
}

void WallForces::finish(MPI_Comm comm, double time, double dt, const Accounts& accounts) {
  kick(comm, time, 0.5 * dt, accounts);
}

void WallForces::place(double time) {
  for (Wall& wall : walls_)
    if (!wall.driven()) wall.moved = wall.wayAt(time);
}

void WallForces::save(RunRecord& record, MPI_Comm comm) const {
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const Wall& wall = walls_[w];
    record.reals["wall_" + wall.name] = {wall.moved.x, wall.moved.y, wall.moved.z,
                                         wall.speed.x, wall.speed.y, wall.speed.z};
    std::vector<ExactSum> sums(felt_[w].force, felt_[w].force + 3);
    sums.insert(sums.end(), felt_[w].torque, felt_[w].torque + 3);
    ExactSum::reduce(sums.data(), 6, comm);
    auto& numbers = record.integers["wall_" + wall.name + "_felt"];
    for (const ExactSum& sum : sums) numbers.insert(numbers.end(), sum.data(), sum.data() + 3);
    if (!wall.driven() || !wall.friction) continue;
    std::vector<ExactSum> rubbed(felt_[w].friction, felt_[w].friction + 3);
    ExactSum::reduce(rubbed.data(), 3, comm);
    auto& own = record.integers["wall_" + wall.name + "_friction"];
    for (const ExactSum& sum : rubbed) own.insert(own.end(), sum.data(), sum.data() + 3);
  }
}

void WallForces::restore(const RunRecord& record, int rank) {
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    Wall& wall = walls_[w];
    const auto& reals = record.needReals("wall_" + wall.name, 6);
    wall.moved = {reals[0], reals[1], reals[2]};
    wall.speed = {reals[3], reals[4], reals[5]};
    const auto& numbers = record.needIntegers("wall_" + wall.name + "_felt", 18);
    for (std::size_t c = 0; c < 6 && rank == 0; ++c)
      std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(3 * c), 3,
                  (c < 3 ? felt_[w].force[c] : felt_[w].torque[c - 3]).data());
    if (!wall.driven() || !wall.friction) continue;
    const auto& own = record.needIntegers("wall_" + wall.name + "_friction", 9);
    for (std::size_t c = 0; c < 3 && rank == 0; ++c)
      std::copy_n(own.begin() + static_cast<std::ptrdiff_t>(3 * c), 3, felt_[w].friction[c].data());
  }
}

double WallForces::leastGap(const State& state, const MinimumImage& nearest, int i,
                            const Wall& wall) const {
  const Vec3d x = nearest(state.position(i) - wall.at()), axis = axis1(state.orientation(i));
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < points; ++k)
    least = std::min(least, wall.see(x + (placeOf(k) * kinds_[state.kind(i)].length) * axis).gap);
  return least;
}

WallForces::Depth WallForces::deepest(const State& state, const MinimumImage& nearest) const {
  Depth deepest{0, std::numeric_limits<std::int64_t>::max(), 0, 0, 0};
  auto deeper = [](const Depth& a, const Depth& b) {
    return a.radii != b.radii ? a.radii > b.radii : a.row < b.row;
  };
  for (int i = 0; i < state.owned(); ++i)
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      const double radius = kinds_[state.kind(i)].radius;
      const double gap = leastGap(state, nearest, i, walls_[w]);
      const Depth own{(radius - gap) / radius, state.row[i], state.fibre[i], state.chain[2 * i],
                      static_cast<std::int32_t>(w)};
      if (deeper(own, deepest)) deepest = own;
    }
  std::vector<Depth> all(static_cast<std::size_t>(state.ranks()));
  MPI_Allgather(&deepest, sizeof deepest, MPI_BYTE, all.data(), sizeof deepest, MPI_BYTE,
                state.comm());
  return *std::ranges::min_element(all, deeper);
}

double WallForces::stiffest(const State& state, const MinimumImage& nearest) const {
  if (!driven()) return 0;
  // Points of each kind that touch each wall: numbers add up to the same on any ranks.
  const auto kinds = static_cast<std::size_t>(kinds_.count());
  std::vector<std::int64_t> touching(walls_.size() * kinds, 0);
  for (int i = 0; i < state.owned(); ++i)
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      if (!walls_[w].driven()) continue;
      const Fibre& fibre = kinds_[state.kind(i)];
      const Vec3d x = nearest(state.position(i) - walls_[w].at()),
                  axis = axis1(state.orientation(i));
      for (int k = 0; k < points; ++k)
        touching[w * kinds + static_cast<std::size_t>(state.kind(i))] +=
            walls_[w].see(x + (placeOf(k) * fibre.length) * axis).gap < fibre.radius;
    }
  MPI_Allreduce(MPI_IN_PLACE, touching.data(), static_cast<int>(touching.size()), MPI_INT64_T,
                MPI_SUM, state.comm());
  double largest = 0;
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    double sum = 0;
    for (int k = 0; k < kinds_.count(); ++k)
      sum += stiffnessOf(walls_[w], k) *
             static_cast<double>(touching[w * kinds + static_cast<std::size_t>(k)]);
    if (walls_[w].driven()) largest = std::max(largest, sum / walls_[w].mass);
  }
  return largest;
}

bool WallForces::borne(MPI_Comm comm, double share) const {
  if (!driven()) return true;
  const std::vector<double> all = felt(comm);
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const Vec3d& force = walls_[w].force;
    if (const double whole = norm(force);
        walls_[w].driven() && std::abs(dot(force + triple(all.data(), 3 * static_cast<int>(w)),
                                           force)) > share * whole * whole)
      return false;
  }
  return true;
}

double WallForces::pointSpacing(const Fibre& fibre) {
  return fibre.length / points;
}

double WallForces::kinetic() const {
  double sum = 0;
  for (const Wall& w : walls_) sum += 0.5 * w.mass * dot(w.speed, w.speed);
  return sum;
}

}  // namespace nanoweft
