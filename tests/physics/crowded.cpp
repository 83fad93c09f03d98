/// Knots, loops and boxes that leave little room.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::pi;

const std::string fromFile = "-scene file -scene_file in.h5 -start_unchecked ";

/// An untwisted fibre along a curve, one bond length from segment to segment.
FibreInput fibreAlong(const std::function<Vec3d(double)>& curve, double from, double to) {
  FibreInput fibre;
  fibre.position.push_back(curve(from));
  for (double t = from;;) {
    double low = t, high = t;
    while (high < to && norm(curve(high) - fibre.position.back()) < tube::length) high += 1e-3;
    if (high >= to) break;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (norm(curve(middle) - fibre.position.back()) < tube::length ? low : high) = middle;
    }
    t = high;
    fibre.position.push_back(curve(t));
  }
  const std::size_t n = fibre.position.size();
  Vec3d side{0, 1, 0};
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3d along = fibre.position[std::min(k + 1, n - 1)] - fibre.position[k == 0 ? 0 : k - 1];
    const Vec3d e1 = (1 / norm(along)) * along;
    side -= dot(side, e1) * e1;
    side = (1 / norm(side)) * side;
    fibre.orientation.push_back(quaternionFromAxes(e1, side, cross(e1, side)));
  }
  return fibre;
}

/// Gauss's double integral of a chain with itself: about 3.4 for an open trefoil knot, near 0 for a
/// chain without one. A passage of one strand through another changes it by 2.
double writhe(const std::vector<Vec3d>& x) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3d r = 0.5 * ((x[i + 1] + x[i]) - (x[j + 1] + x[j]));
      sum += 2 * dot(cross(x[i + 1] - x[i], x[j + 1] - x[j]), r) / std::pow(norm(r), 3);
    }
  return sum / (4 * pi);
}

std::string around(const char* name, const Vec3d& x) {
  char text[300];
  std::snprintf(text, sizeof text, "-%s_region %.9g,%.9g,%.9g,%.9g,%.9g,%.9g ", name, x.x - 1,
                x.y - 1, x.z - 1, x.x + 1, x.y + 1, x.z + 1);
  return text;
}

std::string vectorOption(const char* name, const Vec3d& v) {
  char text[200];
  std::snprintf(text, sizeof text, "-%s %.17g,%.17g,%.17g ", name, v.x, v.y, v.z);
  return text;
}

/// A long trefoil (overhand) knot whose ends are pulled apart until they are `distance` contour
/// lengths from each other, and then held until the fibre rests.
struct Pulled {
  int status;
  std::string output;
  double before, after, strain, tension, pairEnergy;  ///< writhe before and after
};
Pulled pullKnot(double distance, const std::string& options) {
  const Folder folder;
  const FibreInput knot = fibreAlong(
      [](double t) {
        const double t2 = t * t;
        return Vec3d{80 * t * (t2 - 3), 40 * t2 * (t2 - 4), 10 * t * (t2 * t2 - 10)};
      },
      -2.2, 2.2);
  BoxInput box;
  box.lower = {-3000, -3000, -3000};
  box.upper = {3000, 3000, 3000};
  writeState(folder / "in.h5", {knot}, box);
  const Vec3d first = knot.position.front(), last = knot.position.back();
  const double apart = norm(last - first),
               contour = tube::length * static_cast<double>(knot.position.size() - 1);
  const Vec3d pull = (1 / apart) * (last - first);
  const double speed = 0.02, time = (distance * contour - apart) / (2 * speed);
  auto outcome = run(folder, fromFile + "-bc a,b " + around("a", first) + around("b", last) +
                                 vectorOption("a_velocity", -speed * pull) +
                                 vectorOption("b_velocity", speed * pull) +
                                 "-damping_local 0.4 -ts_max_time " + std::to_string(time) +
                                 " -state_output pulled.h5 " + options);
  Pulled p{outcome.status, outcome.output, writhe(knot.position), 0, 0, 0, 0};
  if (p.status != 0) return p;
  const auto pulled = readVectors(folder / "pulled.h5", "/state/position");
  outcome = run(folder, "-scene file -scene_file pulled.h5 -bc a,b " + around("a", pulled.front()) +
                            around("b", pulled.back()) +
                            "-a_fix 1,1,1 -b_fix 1,1,1 -damping_local 0.7 -ts_max_steps 20000 "
                            "-state_output out.h5 -state_forces -energy_monitor "
                            "ascii:energy.csv " +
                            options);
  p.status = outcome.status;
  p.output = outcome.output;
  if (p.status != 0) return p;
  const auto x = readVectors(folder / "out.h5", "/state/position"),
             f = readVectors(folder / "out.h5", "/state/force");
  p.after = writhe(x);
  p.strain = norm(x.back() - x.front()) / contour - 1;
  p.tension = 0.5 * (dot(f.front(), pull) - dot(f.back(), pull));
  p.pairEnergy = readCsv(folder / "energy.csv").at("pair").back();
  return p;
}

TEST(Crowded, KnotDrawnTightHoldsAndPressesOnItself) {
  // The loops of so tight a knot are shorter than 20 segments, the default -pair_exclude.
  const Pulled p = pullKnot(1.03, "-pair_exclude 5 -ts_dt 10");
  ASSERT_EQ(p.status, 0) << p.output;
  EXPECT_GT(p.before, 3);
  EXPECT_GT(p.after, 3);
  EXPECT_GT(p.pairEnergy, 10);
  // What the knot takes of the length the rest must give: without it, the tension would be
  // ES strain.
  EXPECT_NEAR(p.strain, 0.03, 1e-3);
  EXPECT_GT(p.tension, 1.5 * tube::ES * p.strain);
}

TEST(Crowded, KnotWithLoopsLongerThanTheExclusionHoldsByDefault) {
  const Pulled p = pullKnot(0.7, "-ts_dt 10");
  ASSERT_EQ(p.status, 0) << p.output;
  EXPECT_GT(p.after, 3);
  EXPECT_GT(p.tension, 0);
}

TEST(Crowded, KnotPullsOutOnceItsLoopsAreShorterThanTheExclusion) {
  // A known limit of the model: places less than -pair_exclude (20) apart pass through each other.
  const Pulled p = pullKnot(1.03, "-ts_dt 10");
  ASSERT_EQ(p.status, 0) << p.output;
  EXPECT_LT(std::abs(p.after), 1);
  EXPECT_NEAR(p.tension / (tube::ES * p.strain), 1, 0.01);
}

/// A straight fibre along x, its ends held upright and moved together by `shortening` (of its
/// length) at `speed` each, then held.
struct Pressed {
  Outcome outcome;
  std::vector<Vec3d> position, force;
  std::map<std::string, std::vector<double>> energies;
};
Pressed press(const Folder& folder, int segments, double shortening, double speed, int rest,
              const std::string& options) {
  const double end = (segments - 1) * tube::length, each = 0.5 * shortening * end;
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, segments)});
  Pressed p;
  p.outcome = run(folder, fromFile + "-scene_perturb 0.1 -bc a,b " + around("a", {0, 0, 0}) +
                              around("b", {end, 0, 0}) + vectorOption("a_velocity", {speed, 0, 0}) +
                              vectorOption("b_velocity", {-speed, 0, 0}) +
                              "-a_fix_rotation -b_fix_rotation -ts_max_time " +
                              std::to_string(each / speed) +
                              " -state_output pressed.h5 -energy_monitor ascii:energy.csv "
                              "-monitor_interval 10 " +
                              options);
  if (p.outcome.status != 0) return p;
  p.energies = readCsv(folder / "energy.csv");
  p.position = readVectors(folder / "pressed.h5", "/state/position");
  if (rest == 0) return p;
  p.outcome = run(folder, "-scene file -scene_file pressed.h5 -bc a,b " +
                              around("a", p.position.front()) + around("b", p.position.back()) +
                              "-a_fix 1,1,1 -b_fix 1,1,1 -a_fix_rotation -b_fix_rotation "
                              "-state_output out.h5 -state_forces -ts_max_steps " +
                              std::to_string(rest) + " " + options);
  if (p.outcome.status != 0) return p;
  p.position = readVectors(folder / "out.h5", "/state/position");
  p.force = readVectors(folder / "out.h5", "/state/force");
  return p;
}

TEST(Crowded, PressedFibreBucklesAtEulersLoad) {
  // Clamped at both ends: P = 4 pi^2 EJ/L^2 (1 + s/2) with s the part of the shortening by bending.
  const Folder folder;
  const int segments = 30;
  const Pressed p =
      press(folder, segments, 0.03, 0.001, 60000, "-pair none -damping_local 0.6 -ts_dt 20");
  ASSERT_EQ(p.outcome.status, 0) << p.outcome.output;
  const double l = (segments - 1) * tube::length, euler = 4 * pi * pi * tube::EJ / (l * l),
               load = -p.force.front().x;
  const double bent = 1 - (p.position.back().x - p.position.front().x) / l - load / tube::ES;
  EXPECT_GT(bent, 0.02);
  // The load shortens the fibre first, and a chain measures slopes along chords: both raise it. The
  // bond's energy, in cosines of angles of 0.07 rad, and the next term in `bent` change it by 0.05
  // %.
  const double chord = pi / (segments - 1), sinc = std::sin(chord) / chord;
  const double expected = euler * (1 + bent / 2) / ((1 - load / tube::ES) * sinc * sinc);
  EXPECT_NEAR(load / expected, 1, 2e-3);
  EXPECT_NEAR(p.force.back().x / load, 1, 1e-3);
}

TEST(Crowded, PressedFibreFoldsOntoItselfWithItsEnergyAudited) {
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    const Pressed p = press(folder, 80, 0.97, 0.01, 0,
                            k ? "-damping_local 0.3 -ts_dt 5" : "-damping_local 0.3 -ts_dt 10");
    ASSERT_EQ(p.outcome.status, 0) << p.outcome.output;
    const auto& e = p.energies;
    EXPECT_GT(std::abs(e.at("pair").back()), 1);  // arms touch
    double worst = 0;
    for (std::size_t i = 0; i < e.at("step").size(); ++i)
      worst = std::max(worst, std::abs(e.at("total")[i] + e.at("damped")[i] - e.at("external")[i] -
                                       e.at("total")[0]));
    errors[k] = worst / e.at("external").back();
    // No two places beyond the exclusion are inside each other's walls (2 rf).
    double nearest = 1e9;
    for (std::size_t i = 0; i < 80; ++i)
      for (std::size_t j = i + 20; j < 80; ++j)
        nearest = std::min(nearest, norm(p.position[j] - p.position[i]));
    EXPECT_GT(nearest, 2 * tube::rf);
  }
  EXPECT_LT(errors[0], 1e-3);
  EXPECT_LT(errors[1], 0.4 * errors[0]);
}

/// Three wavy closed tubes along a periodic x, around the edge where the box's four lower corners
/// in y and z meet: `copies` periods of 11 segments in a box `width` wide.
void writeTubes(const std::string& file, int copies, double width) {
  const double period = 11 * tube::length;
  std::vector<FibreInput> tubes;
  for (int f = 0; f < 3; ++f) {
    FibreInput tube;
    tube.closed = true;
    const double angle = 2 * pi / 3 * f + 0.3;
    for (int k = 0; k < 11 * copies; ++k) {
      const double phase = 2 * pi * k / 11 + f;
      tube.position.push_back({tube::length * k, 9.5 * std::cos(angle) + 0.8 * std::sin(phase),
                               9.5 * std::sin(angle) + 0.8 * std::cos(2 * phase)});
      tube.orientation.push_back(rotation({0, 0.02 * std::sin(phase), 0.02 * std::cos(phase)}));
    }
    tubes.push_back(tube);
  }
  BoxInput box;
  box.lower = {0, 0, 0};
  box.upper = {copies * period, width, width};
  box.periodic = {true, true, true};
  writeState(file, tubes, box);
}

TEST(Crowded, BoxBarelyTwoListRangesWideGivesTheForcesOfAWideOne) {
  // Points reach 54.24 A + 2/3 T = 63.28 A; with a skin of 5 A two list ranges are 136.56 A.
  const std::string options =
      fromFile +
      "-pair_points 3 -pair_skin 5 -ts_dt 10 -ts_max_steps 200 -energy_monitor "
      "ascii:energy.csv -state_output out.h5 -state_forces";
  std::vector<Vec3d> force[2], velocity[2];
  double first[2], last[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    writeTubes(folder / "in.h5", k ? 2 : 1, k ? 400 : 136.57);
    const auto outcome = run(folder, options);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    force[k] = readVectors(folder / "out.h5", "/state/force");
    velocity[k] = readVectors(folder / "out.h5", "/state/velocity");
    const auto csv = readCsv(folder / "energy.csv");
    first[k] = csv.at("pair").front() / (k ? 2 : 1);
    last[k] = csv.at("total").back() / (k ? 2 : 1);
  }
  EXPECT_GT(std::abs(first[0]), 20);
  // The same sums of numbers that differ by the rounding of wrapped positions, 1e-14 A of contacts
  // of 400 eV/A^2, for 200 steps.
  EXPECT_NEAR(first[0], first[1], 1e-10);
  EXPECT_NEAR(last[0], last[1], 1e-8);
  for (std::size_t f = 0; f < 3; ++f)
    for (std::size_t i = 0; i < 22; ++i) {
      EXPECT_LT(norm(force[0][11 * f + i % 11] - force[1][22 * f + i]), 1e-8);
      EXPECT_LT(norm(velocity[0][11 * f + i % 11] - velocity[1][22 * f + i]), 1e-11);
    }
}

TEST(Crowded, BoxNarrowerThanTwoListRangesIsRefused) {
  const Folder folder;
  writeTubes(folder / "in.h5", 1, 136.5);
  const auto outcome = run(folder, fromFile + "-pair_points 3 -pair_skin 5 -ts_max_steps 1");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.output.find("too thin along y: 136.5 A"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("136.56"), std::string::npos) << outcome.output;
}

TEST(Crowded, SegmentsThatFlyOutOfAnOpenBoxAreKept) {
  // Six fibres leave the box in six directions at 0.1 A/fs and are 15 box lengths away in the end.
  const double speed = 0.1;
  const Vec3d directions[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                               {0, -1, 0}, {0, 0, 1},  {0.6, 0.8, 0}};
  std::string bytes;
  const Folder folder;
  std::vector<FibreInput> fibres;
  BoxInput box;
  for (std::size_t f = 0; f < 6; ++f)
    fibres.push_back(
        straightFibre(25.0 * directions[f] + Vec3d{0, 0, f == 5 ? 40.0 : 0}, directions[f], 5));
  box.lower = {-100, -100, -100}, box.upper = {100, 100, 100};
  writeState(folder / "in.h5", fibres, box);
  setMotion(
      folder / "in.h5", [&](std::size_t i, const Vec3d&) { return speed * directions[i / 5]; },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  for (int ranks : {1, 2, 4}) {
    const auto outcome =
        run(folder, fromFile + "-ts_dt 20 -ts_max_steps 1500 -state_output out.h5", ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto x = readVectors(folder / "out.h5", "/state/position"),
               v = readVectors(folder / "out.h5", "/state/velocity");
    ASSERT_EQ(x.size(), 30u);
    Vec3d momentum, expected;
    for (std::size_t i = 0; i < 30; ++i) {
      momentum += v[i];
      expected += speed * directions[i / 5];
    }
    EXPECT_LT(norm(momentum - expected), 1e-12);
    for (const Vec3d& p : x) EXPECT_GT(norm(p), 2800);
    const std::string now = readFile(folder / "out.h5");
    if (ranks > 1) {
      EXPECT_TRUE(now == bytes) << ranks << " ranks";
    }
    bytes = now;
  }
}

TEST(Crowded, AllSegmentsOnOneOfFourRanks) {
  // A heap no larger than the cutoff, in the corner of a large periodic box: it fits in one cell of
  // the grid that is shared out, so three ranks have nothing.
  const Folder folder;
  std::vector<FibreInput> heap;
  for (int f = 0; f < 3; ++f) {
    heap.push_back(straightFibre({5, 8 + 18.0 * f, 10}, {1, 0.02 * f, 0}, 4));
    heap.push_back(straightFibre({8 + 18.0 * f, 5, 28}, {0, 1, 0.02 * f}, 4));
  }
  BoxInput box;
  box.lower = {0, 0, 0};
  box.upper = {2000, 2000, 2000};
  box.periodic = {true, true, true};
  writeState(folder / "in.h5", heap, box);
  const std::string options = fromFile + "-ts_max_steps 200 -state_output out.h5 ";
  const auto alone = run(folder, options);
  ASSERT_EQ(alone.status, 0) << alone.output;
  const std::string expected = readFile(folder / "out.h5");
  const auto outcome = run(folder, options, 4);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("imbalance 4.000"), std::string::npos) << outcome.output;
  EXPECT_TRUE(readFile(folder / "out.h5") == expected);
}

}  // namespace
}  // namespace nanoweft::test
