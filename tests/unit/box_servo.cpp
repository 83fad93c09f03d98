/// The law of the box's servo, on boxes that answer strain at once.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "nanoweft/motion/box_servo.hpp"

namespace nanoweft::test {
namespace {

constexpr BoxServo::Law usual{10, 2000, 1e-5, 400};

/// A box of a stiffness whose stress, besides, changes by itself.
struct SpringBox {
  double stiffness;
  std::function<double(int)> noise = [](int) { return 0.0; };
  BoxServo servo = {};
  double strain = 0, before = 0, strained = 0;
  int count = 0;

  /// Measures the missing stress, follows it for an interval, and returns the rate.
  double follow(const BoxServo::Law& law, double target) {
    const double missing = target - stiffness * strain - noise(count++);
    const double rate = servo.rate(law, {before, missing, strained});
    EXPECT_LE(std::abs(rate), law.mostRate);
    before = missing;
    strained = rate * law.interval;
    strain += strained;
    return rate;
  }
};

TEST(BoxServo, BringsBoxesOfAnyStiffnessToTheirStress) {
  for (const double stiffness : {10.0, 40.0, 95.0, 150.0, 300.0, 1e3, 1e4, 1e5})
    for (const double time : {2000.0, 200.0, 20.0}) {
      BoxServo::Law law = usual;
      law.time = time;
      SpringBox box{stiffness};
      for (int k = 0; k < 200; ++k) box.follow(law, 1);
      EXPECT_NEAR(stiffness * box.strain, 1, 1e-10) << stiffness << " in " << time;
    }
}

TEST(BoxServo, StrainsNoFasterThanItMay) {
  for (const double target : {1.0, -1.0}) {  // 5e-5 by the viscosity of 20000
    SpringBox box{0.01};
    EXPECT_EQ(box.follow(usual, target), target * usual.mostRate);
    EXPECT_EQ(box.follow(usual, target), target * usual.mostRate);
  }
}

TEST(BoxServo, LeavesABoxAloneThatDoesNotOvershoot) {
  std::mt19937 random(1);
  std::normal_distribution<double> any;
  // Noise that the box follows looks like stiffness now and then.
  const struct Case {
    double stiffness, noise, mayDiffer;
  } cases[] = {{1, 0, 0}, {10, 0, 0}, {40, 0, 0}, {1, 0.1, 0.1}, {10, 0.1, 0.1}};
  for (const Case& one : cases) {
    SpringBox box{one.stiffness};
    box.noise = [&](int) { return one.noise * any(random); };
    int differ = 0;
    for (int k = 0; k < 10000; ++k) {
      const double rate = box.follow(usual, 0.5);
      const bool same = rate == box.before / (usual.modulus * usual.time);
      if (std::abs(rate) < usual.mostRate && !same) ++differ;
    }
    EXPECT_LE(differ, 10000 * one.mayDiffer) << one.stiffness;
  }
}

TEST(BoxServo, ForgetsAStressThatAlternatedByItself) {
  SpringBox box{10};
  box.noise = [](int k) { return k < 1000 ? std::cos(2.5 * k) : 0.0; };
  for (int k = 0; k < 1000; ++k) box.follow(usual, 0.5);
  EXPECT_LT(std::abs(box.stiffness * box.strain - 0.5), 0.5);
  for (int k = 0; k < 300; ++k) box.follow(usual, 0.5);
  EXPECT_NEAR(box.stiffness * box.strain, 0.5, 1e-6);
}

}  // namespace
}  // namespace nanoweft::test
