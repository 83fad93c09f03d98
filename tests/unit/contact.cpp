/// Contacts where axes come closest (model.md 18).
#include "nanoweft/force/contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "helpers.hpp"
#include "nanoweft/force/contact_force.hpp"
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

}  // namespace
}  // namespace nanoweft::test
