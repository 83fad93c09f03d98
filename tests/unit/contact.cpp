/// Contacts where axes come closest (model.md 18).
#include "nanoweft/force/contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "helpers.hpp"
#include "nanoweft/force/contact_force.hpp"
#include "nanoweft/force/friction.hpp"
#include "pair_sum.hpp"

namespace nanoweft::test {
namespace {

constexpr double radius[] = {6.78, 3.39, 20.0}, segment[] = {13.56, 6.78, 30.0}, modulus = 0.1;

ContactLaw lawOf(int i, int j) {
  return {modulus, {radius[i], radius[j]}, {segment[i], segment[j]}, 6};
}

std::unique_ptr<PairForce> forceOf(int i, int j) {
  const ContactLaw law = lawOf(i, j);
  PairTraits traits;
  traits.cutoff = law.touch();
  traits.largestForce = 1e3;
  PairChoice choice;
  choice.length = {segment[i], segment[j]};
  return makeContactForce(law, {}, traits, choice);
}

struct Reference {
  int kinds[2], ends[2];
  Pose pose[2];
  double energy;
  Vec3d force, torque[2];
};

std::vector<Reference> references() {
  std::vector<Reference> all;
  for (const auto& r : readTable("contacts.csv")) {
    auto vec = [&](std::size_t k) { return Vec3d{r[k], r[k + 1], r[k + 2]}; };
    auto whole = [&](std::size_t k) { return static_cast<int>(r[k]); };
    auto pose = [&](std::size_t k) {
      return Pose{vec(k), {r[k + 3], r[k + 4], r[k + 5], r[k + 6]}};
    };
    all.push_back({{whole(0), whole(1)},
                   {whole(2) + 2 * whole(3), whole(4) + 2 * whole(5)},
                   {pose(6), pose(13)},
                   r[20],
                   vec(21),
                   {vec(24), vec(27)}});
  }
  return all;
}

TEST(Contact, AgreesWithFiftyDigits) {
  const auto all = references();
  ASSERT_EQ(all.size(), 60u);
  for (const Reference& r : all) {
    auto ends = [](int bits) { return FreeEnds<double>{1.0 * (bits & 1), 1.0 * (bits >> 1)}; };
    const auto contact =
        lawOf(r.kinds[0], r.kinds[1])(r.pose[1].x - r.pose[0].x, axis1(r.pose[0].q),
                                      axis1(r.pose[1].q), ends(r.ends[0]), ends(r.ends[1]));
    EXPECT_NEAR(contact.energy, r.energy, 1e-10 * (std::abs(r.energy) + 1e-3));
    EXPECT_LT(norm(contact.force - r.force), 1e-10 * (norm(r.force) + 1e-3));
    EXPECT_LT(norm(contact.torqueI - r.torque[0]), 1e-10 * (norm(r.torque[0]) + 1e-2));
    EXPECT_LT(norm(contact.torqueJ - r.torque[1]), 1e-10 * (norm(r.torque[1]) + 1e-2));
  }
}

/// Segments along a line through `middle`, which lies `offset` lengths from a centre.
std::vector<Pose> chain(int kind, const Vec3d& middle, const Vec3d& along, double offset) {
  const Vec3d z{0, 0, 1};
  const Quatd q = quaternionFromAxes(along, cross(z, along), z);
  std::vector<Pose> segments;
  for (int k = -8; k <= 8; ++k)
    segments.push_back({middle + ((k + offset) * segment[kind]) * along, q});
  return segments;
}

/// Energy of two chains and force on the first.
PairAction between(const PairForce& force, const std::vector<Pose>& a, const std::vector<Pose>& b) {
  PairAction sum;
  for (const Pose& i : a)
    for (const Pose& j : b) {
      const auto one = force.resolve(j.x - i.x, i.q, j.q);
      sum.energy += one.energy;
      sum.force += one.force;
    }
  return sum;
}

TEST(Contact, ACrossingHasOneForceWhereverItFalls) {
  const int kinds[][2] = {{0, 0}, {2, 1}};
  for (const auto& [i, j] : kinds) {
    const auto force = forceOf(i, j);
    const ContactLaw law = lawOf(i, j);
    for (const double degrees : {24.0, 41.0, 90.0, 133.0}) {
      const double angle = degrees * std::numbers::pi / 180, overlap = 0.3;
      const Vec3d along{std::cos(angle), std::sin(angle), 0};
      // Hertz: the force grows as the radius of the contact, by 1/sin.
      const double expected = law.crossedForce(overlap) / std::sqrt(std::sin(angle));
      for (int k = 0; k < 40; ++k) {
        const auto sum =
            between(*force, chain(i, {0, 0, 0}, {1, 0, 0}, std::fmod(0.137 * k, 1.0)),
                    chain(j, {0, 0, law.touch() - overlap}, along, std::fmod(0.291 * k, 1.0)));
        EXPECT_NEAR(sum.force.z, -expected, 1e-9 * expected) << degrees << " " << k;
        EXPECT_LT(std::hypot(sum.force.x, sum.force.y), 1e-9 * expected) << degrees << " " << k;
        EXPECT_NEAR(sum.energy, 0.4 * overlap * expected, 1e-9 * expected);
      }
    }
  }
}

TEST(Contact, ACrossingHasOneFrictionWhereverItFalls) {
  const ContactLaw law = lawOf(0, 0);
  FrictionLaw friction;
  friction.mu = 10;
  friction.restitution = 0.5;
  friction.mass = 1;
  for (const double degrees : {41.0, 90.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    Vec3d first;
    for (int k = 0; k < 20; ++k) {
      Vec3d sum;
      for (const Pose& i : chain(0, {0, 0, 0}, {1, 0, 0}, std::fmod(0.137 * k, 1.0)))
        for (const Pose& j : chain(0, {0, 0, law.touch() - 0.3},
                                   {std::cos(angle), std::sin(angle), 0}, 0.291 * k)) {
          const ContactPatch patch = law.patch(j.x - i.x, axis1(i.q), axis1(j.q), {}, {});
          double spring[3] = {0.01, 0.02, 0};
          if (patch.load > 0)
            sum += friction
                       .act(patch, j.x - i.x, axis1(i.q), radius[0],
                            {{}, {1e-3, 2e-3, -1e-3}, {}, {}}, 0.0, spring)
                       .forceI;
        }
      if (k == 0) first = sum;
      EXPECT_GT(norm(sum), 0);
      EXPECT_LT(norm(sum - first), 1e-9 * norm(first)) << degrees << " " << k;
    }
  }
}

/// Two spheres of radius 1 that overlap by 0.2, the second in the direction n from the first; the
/// first turns at `spin`.
FrictionLaw::Action rub(const FrictionLaw& law, const Vec3d& n, const Vec3d& velocity,
                        const Vec3d& spin, double* spring) {
  ContactPatch patch;
  patch.load = 2;
  patch.stiffness = 7;
  patch.share = 1;
  patch.overlap = 0.2;
  patch.normal = n;
  return law.act(patch, 1.8 * n, {0, 0, 1}, 1.0, {{}, velocity, spin, {}}, 0.01, spring);
}

TEST(Friction, ASpringTurnsWithItsContactAndKeepsItsLength) {
  FrictionLaw law;
  law.mu = 1;
  double spring[3] = {0.3, 0, 0.1};
  // The contact rolls from z to x in the plane of the spring's first component.
  for (int k = 1; k <= 2000; ++k) {
    const double angle = 0.5 * std::numbers::pi * k / 2000;
    rub(law, {std::sin(angle), 0, std::cos(angle)}, {}, {}, spring);
    if (k == 1) {
      EXPECT_NEAR(spring[0], std::hypot(0.3, 0.1), 1e-3);
    }
  }
  EXPECT_NEAR(spring[0], 0, 1e-12);
  EXPECT_NEAR(spring[1], 0, 1e-12);
  EXPECT_NEAR(spring[2], -std::hypot(0.3, 0.1), 1e-12);
}

TEST(Friction, OfASlidingContactIsTheBoundAndItsSpringHoldsThat) {
  FrictionLaw law;
  law.mu = 0.3;
  double spring[3] = {0, 0, 0};
  // The surface of j goes along x, at last by 0.01 a step.
  FrictionLaw::Action action;
  for (int k = 0; k < 1000; ++k) action = rub(law, {0, 0, 1}, {1, 0, 0}, {}, spring);
  EXPECT_NEAR(action.forceI.x, 0.3 * 2, 1e-14);
  EXPECT_NEAR(spring[0], 0.3 * 2 / (2.0 / 7 * 7), 1e-14);
  EXPECT_NEAR(action.power, 0.3 * 2 * 1, 1e-14);
  // It acts where the surfaces meet, 0.9 from both centres.
  EXPECT_NEAR(action.torqueI.y, 0.9 * 0.6, 1e-14);
  EXPECT_NEAR(action.torqueJ.y, 0.9 * 0.6, 1e-14);
  // A spin of i about y carries its surface along x too.
  double other[3] = {0, 0, 0};
  action = rub(law, {0, 0, 1}, {}, {0, 1, 0}, other);
  EXPECT_NEAR(other[0], -0.9 * 0.01, 1e-14);
  EXPECT_NEAR(action.forceI.x, -0.9 * 0.01 * 2, 1e-14);
}

TEST(Friction, DampingAlongTheNormalIsAtMostTheLoad) {
  FrictionLaw law;
  law.restitution = 0.5;
  law.mass = 3;
  const double log = std::log(0.5), beta = -log / std::hypot(std::numbers::pi, log),
               damping = 2 * beta * std::sqrt(7.0 * 3.0);
  for (const double opening : {0.1, -0.1, 100.0, -100.0}) {
    double spring[3] = {0, 0, 0};
    const auto action = rub(law, {0, 0, 1}, {0, 0, opening}, {}, spring);
    EXPECT_NEAR(action.forceI.z, std::clamp(damping * opening, -2.0, 2.0), 1e-14) << opening;
  }
}

TEST(Contact, FibresSlideAlongEachOtherWithoutCorrugation) {
  const auto force = forceOf(0, 0);
  const double overlap = 0.1;
  for (const double degrees : {0.0, 3.0, 13.0, 17.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    for (int k = 0; k < 30; ++k) {
      const Vec3d along{std::cos(angle), std::sin(angle), 0};
      const auto sum = between(*force, chain(0, {0, 0, 0}, {1, 0, 0}, std::fmod(0.137 * k, 1.0)),
                               chain(0, {0, 0, 2 * radius[0] - overlap}, along, 0));
      // The ends of parallel chains lie over each other's ends: those are left out by symmetry.
      if (degrees == 0 && k % 10 != 0) continue;
      EXPECT_GT(-sum.force.z, 0);
      EXPECT_LT(std::abs(sum.force.x), 2e-3 * std::abs(sum.force.z)) << degrees << " " << k;
    }
  }
}

TEST(Contact, AxesThatMeetAreNotThrownApart) {
  const ContactLaw law = lawOf(0, 0);
  const double T = segment[0],
               most = 10 * (law.crossedForce(law.touch()) + law.lineStiffness() * T);
  Random random;
  std::uniform_real_distribution<double> place(-T, T);
  for (const double apart : {0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4})
    for (int k = 0; k < 50; ++k) {
      const Vec3d ei = axis1(random.orientation()),
                  ej = k % 10 == 0 ? ei : axis1(random.orientation()),
                  n = axis2(random.orientation());
      const Vec3d r = place(random.engine) * ei - place(random.engine) * ej + apart * n;
      const auto contact = law(r, ei, ej, FreeEnds<double>{1, 1}, FreeEnds<double>{0, 1});
      EXPECT_LT(norm(contact.force), most) << apart;
      EXPECT_LT(norm(contact.torqueI), 2 * T * most) << apart;
      EXPECT_LT(norm(contact.torqueJ), 2 * T * most) << apart;
    }
}

TEST(Contact, LanesGiveWhatSinglePairsGive) {
  const auto force = forceOf(0, 0);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-14, 14), turn(-2, 2);
  std::vector<Pose> segments;
  for (int k = 0; k < 60; ++k)
    segments.push_back({{place(random), place(random), place(random)},
                        rotation(Vec3d{turn(random), turn(random), turn(random)})});
  const Sum sum = evaluate(*force, segments);
  double energy = 0;
  std::vector<Vec3d> on(segments.size());
  int touching = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::size_t j = i + 1; j < segments.size(); ++j) {
      const auto one = force->resolve(segments[j].x - segments[i].x, segments[i].q, segments[j].q);
      energy += one.energy;
      on[i] += one.force;
      on[j] -= one.force;
      touching += one.energy > 0;
    }
  EXPECT_GT(touching, 100);
  EXPECT_LT(sum.resolved, 60 * 59 / 2) << "pairs that cannot touch are resolved";
  EXPECT_NEAR(sum.energy, energy, 1e-11 * energy);
  for (std::size_t i = 0; i < segments.size(); ++i)
    EXPECT_LT(norm(sum.force[i] - on[i]), 1e-11 * energy) << i;
}

}  // namespace
}  // namespace nanoweft::test
