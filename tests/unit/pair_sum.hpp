/// The pair sum over a few segments, as the program computes it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "helpers.hpp"
#include "nanoweft/base/error.hpp"
#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/fibre/presets.hpp"
#include "nanoweft/force/pair_forces.hpp"

namespace nanoweft::test {

inline constexpr double length = 13.56;

inline std::shared_ptr<PairForce> makeForce(const std::string& options) {
  petsc(PetscOptionsClear(nullptr));
  petsc(PetscOptionsInsertString(nullptr, options.c_str()));
  Options read;
  const PairForces pairs = readPairForces(read, nanoUnits(), cnt1010(nanoUnits()));
  petsc(PetscOptionsClear(nullptr));
  return pairs ? pairs.classes()[0].force : nullptr;
}

struct Pose {
  Vec3d x;
  Quatd q;
};

struct Sum {
  double energy;
  std::vector<Vec3d> force, torque;
  std::int64_t resolved, pointPairs;
};

/// All pairs of the segments.
inline Sum evaluate(const PairForce& force, const std::vector<Pose>& segments) {
  std::vector<double> pose;
  std::vector<ListPair> pairs;
  const auto n = static_cast<std::int32_t>(segments.size());
  for (const Pose& s : segments)
    pose.insert(pose.end(), {s.x.x, s.x.y, s.x.z, 0, s.q.w, s.q.x, s.q.y, s.q.z});
  for (std::int32_t i = 0; i < n; ++i)
    for (std::int32_t j = i + 1; j < n; ++j) pairs.push_back({i, j});
  std::vector<ForceSum> sum(segments.size() + 1, ForceSum{});
  const MinimumImage nearest{Box{}};
  PairRuns listed;
  listed.set(FoundPairs(pairs), n);
  DrawnPairs drawn;
  force.draw(listed, pose.data(), nearest, 1.0, drawn);
  PairJob job;
  job.pose = pose.data();
  job.drawn = &drawn;
  job.begin = 0;
  job.end = job.spare = n;
  job.sum = sum.data();
  job.nearest = &nearest;
  PairTally tally;
  tally.energyUnit = SumUnit(1.0);
  force.add(job, true, tally);
  Sum result{tally.energy.value(tally.energyUnit), {}, {}, tally.resolved, tally.pointPairs};
  for (std::size_t i = 0; i < segments.size(); ++i) {
    auto vector = [&](std::size_t k, double unit) {
      return unit * Vec3d{static_cast<double>(sum[i].at[k]), static_cast<double>(sum[i].at[k + 1]),
                          static_cast<double>(sum[i].at[k + 2])};
    };
    result.force.push_back(vector(0, force.forceUnit()));
    result.torque.push_back(vector(3, force.torqueUnit()));
  }
  return result;
}

inline std::vector<Pose> pairAt(double distance, Random& random) {
  const Vec3d direction = random.vector(1.0);
  return {{{0, 0, 0}, random.orientation()},
          {(distance / norm(direction)) * direction, random.orientation()}};
}

}  // namespace nanoweft::test
