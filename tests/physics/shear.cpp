/// Shear of the periodic box, whose images slide (model.md 21).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "nanoweft/base/hdf5.hpp"
#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/lattice.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::gigapascal;
constexpr double T = tube::length;

/// Tilts the box of a state file: slides along x across y, along x across z, along y across z.
void setTilt(const std::string& file, const std::vector<double>& tilt) {
  h5::Handle f(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  if (H5Aexists(group, "tilt") > 0) H5Adelete(group, "tilt");
  ASSERT_TRUE(h5::writeAttribute(group, "tilt", tilt));
}

const std::string fileScene =
    "-scene file -scene_file in.h5 -progress_interval 0 -box_monitor ascii:box.csv "
    "-energy_monitor ascii:energy.csv ";

/// Forces on the segments of in.h5, by their rows, and the energy.
struct Still {
  std::vector<Vec3d> force;
  double energy;
};
Still standing(const Folder& folder, int ranks) {
  const auto outcome = run(folder,
                           fileScene +
                               "-ts_max_steps 0 -start_unchecked -pair_allow_overlap -state_forces "
                               "-state_output out.h5 -overwrite",
                           ranks);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return {readVectors(folder / "out.h5", "/state/force"),
          readCsv(folder / "energy.csv").at("total").back()};
}

/// Fibres of four segments at random in a region.
std::vector<FibreInput> randomFibres(const Vec3d& size, int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part;
  std::normal_distribution<double> any;
  std::vector<FibreInput> fibres;
  for (int k = 0; k < count; ++k) {
    const Vec3d start{size.x * part(random), size.y * part(random), size.z * part(random)};
    Vec3d along{any(random), any(random), any(random)};
    fibres.push_back(straightFibre(start, (1.0 / norm(along)) * along, 4));
  }
  return fibres;
}

TEST(Shear, ATiltOfHalfTheBoxIsAStraightBoxOfTwice) {
  const Vec3d size{160, 170, 180};
  struct {
    std::vector<double> tilt;
    Vec3d copy;    // where the second copy of the tilted box lies
    Vec3d length;  // of the straight box of both
    int ranks;
  } cases[] = {{{80, 0, 0}, {80, 170, 0}, {160, 340, 180}, 3},
               {{0, -80, 0}, {-80, 0, 180}, {160, 170, 360}, 1},
               // A whole turn is none.
               {{0, 0, 255}, {0, 85, 180}, {160, 170, 360}, 1}};
  for (const auto& c : cases) {
    const Folder tilted, straight;
    auto fibres = randomFibres(size, 40);
    writeState(tilted / "in.h5", fibres, {{0, 0, 0}, {size.x, size.y, size.z}, {true, true, true}});
    setTilt(tilted / "in.h5", c.tilt);
    const std::size_t half = fibres.size();
    for (std::size_t k = 0; k < half; ++k) {
      FibreInput copy = fibres[k];
      for (Vec3d& x : copy.position) x = x + c.copy;
      fibres.push_back(copy);
    }
    writeState(straight / "in.h5", fibres,
               {{0, 0, 0}, {c.length.x, c.length.y, c.length.z}, {true, true, true}});
    const Still one = standing(tilted, c.ranks), two = standing(straight, 1);
    EXPECT_NE(one.energy, 0);
    EXPECT_EQ(readCsv(tilted / "box.csv").at("strain_x").back(), 0);
    EXPECT_NEAR(2.0 * one.energy / two.energy, 1.0, 1e-12);
    ASSERT_EQ(2 * one.force.size(), two.force.size());
    double largest = 0;
    for (const Vec3d& f : one.force) largest = std::max(largest, norm(f));
    for (std::size_t i = 0; i < two.force.size(); ++i)
      EXPECT_LT(norm(two.force[i] - one.force[i % one.force.size()]), 1e-10 * largest);
  }
}

const std::string springs = fileScene +
                            "-pair none -link_law spring -link_stretch 2 -deform_xy rate "
                            "-deform_thickness 10 -deform_interval 1 ";

TEST(Shear, ATriangularLatticeOfSpringsHasItsShearModulus) {
  // Springs of the constant k: mu = sqrt(3)/4 k over the thickness.
  const Folder folder;
  writeLattice(folder / "in.h5", 0);
  const auto outcome = run(folder,
                           springs +
                               "-deform_xy_rate 1e-6 -deform_xy_until 2e-4 -ts_dt 10 "
                               "-ts_max_steps 40 -monitor_interval 40",
                           2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto box = readCsv(folder / "box.csv"), energy = readCsv(folder / "energy.csv");
  const double mu = std::sqrt(3) / 4 * 2 / 10, strain = 2e-4;
  EXPECT_NEAR(box.at("strain_xy").back(), strain, 1e-12);
  EXPECT_NEAR(box.at("xy_GPa").back() * gigapascal / (mu * strain), 1.0, 1e-3);
  EXPECT_NEAR(box.at("xx_GPa").back() * gigapascal, 0.0, 1e-3 * mu * strain);
  const double work = 0.5 * mu * strain * strain * Lattice::area * 10;
  EXPECT_NEAR(energy.at("total").back() / work, 1.0, 1e-3);
  EXPECT_NEAR(energy.at("external").back() / work, 1.0, 1e-3);
}

TEST(Shear, TheServoBringsTheLatticeToItsShearStress) {
  const double mu = std::sqrt(3) / 4 * 2 / 10, stress = 2e-4 * mu / gigapascal;
  const Folder folder;
  writeLattice(folder / "in.h5", 0);
  const auto outcome =
      run(folder, fileScene +
                      "-pair none -link_law spring -link_stretch 2 -deform_thickness 10 "
                      "-damping_local 0.3 -deform_xy stress -deform_modulus 13.9 "
                      "-deform_time 1000 -ts_dt 10 -ts_max_steps 3000 -monitor_interval "
                      "100 -deform_xy_stress " +
                      std::to_string(stress));
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto box = readCsv(folder / "box.csv");
  EXPECT_NEAR(box.at("xy_GPa").back() / stress, 1.0, 1e-3);
  EXPECT_NEAR(box.at("strain_xy").back() / 2e-4, 1.0, 2e-3);
}

TEST(Shear, AFreeSegmentFliesStraightThroughTheSlidingFace) {
  // Two segments far apart; velocities are those beside the box's motion.
  const double rate = 1e-4, dt = 5, length = 300, steps = 6000;
  const Vec3d start{100, 200, 150}, velocity{2e-3, 0.05, 1e-3};
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre(start, {1, 0, 0}, 1), straightFibre({20, 30, 40}, {1, 0, 0}, 1)},
             {{0, 0, 0}, {length, length, length}, {true, true, true}});
  setMotion(
      folder / "in.h5", [&](std::size_t i, const Vec3d&) { return i == 0 ? velocity : Vec3d{}; },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const auto outcome = run(folder, fileScene +
                                       "-pair none -deform_xy rate -deform_xy_rate 1e-4 -ts_dt 5 "
                                       "-ts_max_steps 6000 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const double strain = readCsv(folder / "box.csv").at("strain_xy").back();
  EXPECT_NEAR(strain, rate * dt * steps, 1e-9);
  const auto position = readVectors(folder / "out.h5", "/state/position"),
             image = readVectors(folder / "out.h5", "/state/image"),
             then = readVectors(folder / "in.h5", "/state/position");
  EXPECT_GT(image[0].y, 3);
  const double tilt = std::remainder(strain * length, length), time = dt * steps;
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3d v = i == 0 ? velocity : Vec3d{};
    const double x = position[i].x + image[i].x * length + image[i].y * tilt,
                 y = position[i].y + image[i].y * length;
    EXPECT_NEAR(y, then[i].y + v.y * time, 1e-6);
    const double flow = rate * (then[i].y - 0.5 * length) * time;
    EXPECT_NEAR(x, then[i].x + v.x * time + flow, 1e-6);
  }
  EXPECT_NEAR(readVectors(folder / "out.h5", "/state/velocity")[0].x,
              velocity.x - strain * velocity.y, 1e-9);
}

TEST(Shear, AFibreBondedThroughTheSlidingFaceIsStretchedByTheTilt) {
  constexpr int n = 40;
  constexpr double tilt = 30, lean = tilt / (n * T);
  const double strain = std::hypot(lean, 1.0) - 1.0;
  const struct {
    std::string name;
    std::size_t along, across;
  } pairs[] = {{"xy", 0, 1}, {"xz", 0, 2}, {"yz", 1, 2}};
  for (const auto& [name, along, across] : pairs) {
    std::array<double, 3> start{0.3, 0.3, 0.3}, direction{};
    start[along] = 100, direction[across] = 1;
    FibreInput fibre = straightFibre({start[0], start[1], start[2]},
                                     {direction[0], direction[1], direction[2]}, n);
    fibre.closed = true;
    BoxInput box{{-100, -100, -100}, {100, 100, 100}, {false, false, false}};
    box.lower[along] = box.lower[across] = 0;
    box.upper[along] = 200, box.upper[across] = n * T;
    box.periodic[along] = box.periodic[across] = true;
    const Folder folder;
    writeState(folder / "in.h5", {fibre}, box);
    const std::string deform = " -deform_" + name;
    const auto outcome = run(folder,
                             fileScene + "-pair none -damping_local 0.3" + deform + " rate" +
                                 deform + "_rate 2e-5" + deform + "_until " + std::to_string(lean) +
                                 " -ts_dt 10 -ts_max_steps 8000 -state_output out.h5",
                             2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const double expected = 0.5 * tube::ES * strain * strain * n * T;
    EXPECT_NEAR(readCsv(folder / "energy.csv").at("total").back() / expected, 1.0, 2e-3) << name;
    // At rest it has the shear stress of a rope that leans.
    const double force = tube::ES * strain * lean / std::hypot(lean, 1.0);
    const auto table = readCsv(folder / "box.csv");
    EXPECT_NEAR(table.at(name + "_GPa").back() * gigapascal * 200 * 200 / force, 1.0, 5e-3) << name;
    EXPECT_NEAR(table.at("strain_" + name).back(), lean, 1e-6) << name;
  }
}

TEST(Shear, OfATiltedStateThatIsStretchedIsNone) {
  const Folder folder;
  BoxInput box{{0, 0, -100}, {200, 200, 100}, {true, true, false}};
  writeState(folder / "in.h5", {straightFibre({50, 100, 0}, {1, 0, 0}, 4)}, box);
  setTilt(folder / "in.h5", {40, 0, 0});
  const auto outcome =
      run(folder,
          fileScene +
              "-pair none -deform_interval 1 -deform_x rate -deform_x_rate 1e-6 -deform_xy program "
              "-deform_xy_program 0.1,1e-12 -ts_dt 10 -ts_max_steps 1000 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto table = readCsv(folder / "box.csv");
  EXPECT_NEAR(table.at("strain_x").back(), 0.01, 1e-9);
  EXPECT_NEAR(table.at("strain_xy").back(), 0.0, 1e-7);
  // The images slide with the box.
  h5::Handle f(H5Fopen((folder / "out.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  h5::Handle group(H5Gopen2(f, "state", H5P_DEFAULT), H5Gclose);
  EXPECT_NEAR(h5::readReals(group, "tilt").value().at(0), 40 * 1.01, 1e-5);
}

TEST(Shear, WhatCannotBeMeantIsRefused) {
  const Folder folder;
  const std::string weave = "-weave_fibres 2,2 -weave_segments 12 -ts_max_steps 1 ",
                    periodic = weave + "-weave_periodic ";
  const struct {
    std::string options;
    std::vector<std::string> says;
  } cases[] = {{weave + "-deform_xy rate -deform_xy_rate 1e-6", {"-deform_xy", "open", "x"}},
               {periodic + "-deform_xz rate -deform_xz_rate 1e-6", {"-deform_xz", "open", "z"}},
               {periodic + "-deform_xy rate -deform_xy_rate 1e-6 -deform_yz free",
                {"-deform_xy", "-deform_yz", "one pair"}},
               {periodic + "-deform_yx rate", {"-deform_yx"}},
               {periodic + "-deform_xy rate", {"-deform_xy_rate"}},
               {periodic + "-deform_xy rate -deform_xy_rate fast", {"-deform_xy_rate", "fast"}},
               {periodic + "-deform_xy rate -deform_xy_rate 1e-6 -walls floor -floor_axis 0,0,1 "
                           "-floor_modulus 10 -floor_point 0,0,-50",
                {"-deform_xy", "-walls"}}};
  for (const auto& c : cases) expectRefused(run(folder, c.options), c.says);

  writeState(folder / "in.h5", {straightFibre({50, 50, 50}, {1, 0, 0}, 2)},
             {{0, 0, 0}, {300, 300, 300}, {true, true, true}});
  setTilt(folder / "in.h5", {40, 0, 0});
  const std::string file = "-scene file -scene_file in.h5 -ts_max_steps 1 ";
  expectRefused(run(folder, file + "-domain_periodic 0,0,0"), {"-domain_periodic", "tilted"});
  expectRefused(run(folder, file + "-deform_xz free"), {"-deform_xz", "xy"});
  setTilt(folder / "in.h5", {40, 10, 0});
  expectRefused(run(folder, file), {"tilt", "at most one"});
}

TEST(Shear, WorkThatIsBookedTooSeldomIsNamedAsTheCause) {
  // A fibre across the slide rings undamped, faster than its stress is measured.
  const Folder folder;
  auto fibre = straightFibre({60, 5, 60}, {0, 1, 0}, 40);
  for (std::size_t k = 0; k < 40; ++k) fibre.position[k].y = 5 + 10 * static_cast<double>(k);
  fibre.closed = true;
  BoxInput box;
  box.upper = {120, 400, 120};
  box.lower = {0, 0, 0};
  box.periodic = {true, true, true};
  writeState(folder / "in.h5", {fibre}, box);
  const auto outcome = run(folder,
                           fileScene +
                               "-pair none -fibre_segment_length 10 -deform_xy rate "
                               "-deform_xy_rate 1e-6 -deform_xy_until "
                               "0.1 -ts_max_time 104000",
                           2);
  EXPECT_EQ(outcome.status, 2) << outcome.output;
  EXPECT_TRUE(says(outcome,
                   "take a smaller -ts_dt or -deform_interval (the box books its work "
                   "every 20 steps)"))
      << outcome.output;
  EXPECT_EQ(run(folder,
                fileScene + "-pair none -fibre_segment_length 10 -deform_xy rate -deform_xy_rate "
                            "1e-6 -deform_xy_until 0.1 "
                            "-deform_interval 1 -damping_local 0.3 -ts_max_time 104000 -overwrite",
                2)
                .status,
            0);
}

}  // namespace
}  // namespace nanoweft::test
