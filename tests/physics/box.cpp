/// The periodic box as a testing machine (model.md 21).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/lattice.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::gigapascal;
constexpr double T = tube::length;

/// A fibre of 40 segments through a box 200 x 200 wide, closed on itself.
const std::string through =
    "-scene fibre -fibre_segments 40 -fibre_closed -domain_lower 0,-100,-100 -domain_upper "
    "542.4,100,100 -domain_periodic 1,0,0 -pair none -ts_dt 20 -progress_interval 0 "
    "-box_monitor ascii:box.csv -energy_monitor ascii:energy.csv -monitor_interval 20 ";
constexpr double section = 200 * 200;

TEST(Box, MayShrinkUntilNothingIsLeftForTheSkin) {
  // The skin that a run chooses by itself, 13.56 A at first, gives way: pairs reach 54.24 A, so a
  // box of 114 A is wide enough, and one of 106 A is not.
  const std::string shrinking =
      "-scene fibre -fibre_segments 14 -domain_lower 0,-95,-100 -domain_upper "
      "189.84,95,100 -domain_periodic 0,1,0 -ts_dt 20 -progress_interval 0 -deform_y rate "
      "-deform_y_rate -2e-6 -ts_max_steps 12000 -deform_y_until ";
  const Folder folder;
  const auto outcome = run(folder, shrinking + "-0.4", 2);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto thin = run(folder, shrinking + "-0.44");
  EXPECT_EQ(thin.status, 2) << thin.output;
  EXPECT_NE(thin.output.find("the periodic box has become too thin"), std::string::npos)
      << thin.output;
}

TEST(Box, AFibreThatIsStrainedWithItFeelsHookesStress) {
  const Folder folder;
  const auto outcome = run(folder,
                           through +
                               "-deform_x rate -deform_x_rate 1e-6 -deform_x_until 0.005 "
                               "-ts_max_steps 400",
                           2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto box = readCsv(folder / "box.csv"), energy = readCsv(folder / "energy.csv");
  for (std::size_t k = 0; k < box.at("step").size(); ++k) {
    const double strain = std::min(0.005, 1e-6 * 20 * box.at("step")[k]);
    EXPECT_NEAR(box.at("strain_x")[k], strain, 1e-12);
    EXPECT_NEAR(box.at("xx_GPa")[k], tube::ES * strain / section / gigapascal, 1e-12);
    const double expected = 0.5 * tube::ES * strain * strain * 40 * T;
    EXPECT_NEAR(energy.at("total")[k], expected, 1e-8);
    // The work is that of the stress, of second order in the interval of its measurement.
    EXPECT_NEAR(energy.at("external")[k], expected, 1e-4 * (0.2 + expected));
  }
}

TEST(Box, AProgramComesBackToWhereItBegan) {
  const Folder folder;
  const auto outcome =
      run(folder, through +
                      "-deform_x program -deform_x_program 0.004,1e-6,-0.002,1e-6,0,1e-6 "
                      "-ts_max_steps 2000");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto box = readCsv(folder / "box.csv"), energy = readCsv(folder / "energy.csv");
  EXPECT_NEAR(*std::ranges::max_element(box.at("strain_x")), 0.004, 1e-4);
  EXPECT_NEAR(*std::ranges::min_element(box.at("strain_x")), -0.002, 1e-4);
  EXPECT_NEAR(box.at("strain_x").back(), 0, 1e-12);
  EXPECT_NEAR(box.at("xx_GPa").back(), 0, 1e-12);
  EXPECT_NEAR(energy.at("external").back(), 0, 1e-4);
}

TEST(Box, TheServoBringsItToItsStress) {
  const Folder folder;
  const auto outcome =
      run(folder, through +
                      "-deform_x stress -deform_x_stress 0.004 -deform_modulus 0.9178 "
                      "-deform_time 1000 -ts_max_steps 800");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto box = readCsv(folder / "box.csv");
  EXPECT_NEAR(box.at("xx_GPa").back(), 0.004, 1e-6);
  EXPECT_NEAR(box.at("strain_x").back(), 0.004 * section * gigapascal / tube::ES, 1e-5);
}

/// The fibre in a box of another width; its modulus is 1468 GPa at 10 A.
std::string throughWidth(int width) {
  const std::string half = std::to_string(width / 2);
  return through + "-domain_lower 0,-" + half + ",-" + half + " -domain_upper 542.4," + half + "," +
         half + " -deform_x stress -deform_x_stress 1 ";
}

TEST(Box, TheServoOfABoxMuchStifferThanItsModulusComesToRestAtItsStress) {
  for (const int width : {10, 2}) {
    const Folder folder;
    const auto outcome = run(folder, throughWidth(width) + "-ts_max_steps 2000");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto box = readCsv(folder / "box.csv");
    for (std::size_t k = 80; k < box.at("step").size(); ++k)
      EXPECT_NEAR(box.at("xx_GPa")[k], 1, 1e-4) << width << " at " << box.at("step")[k];
  }
}

TEST(Box, ItsWorkIsNoEnergyOutOfNothingBetweenMeasurements) {
  // The end and the rows of the table lie between the steps at which the stress is measured.
  const Folder folder;
  const std::string strained =
      "-scene fibre -fibre_segments 20 -fibre_closed -domain_lower 0,-100,-100 -domain_upper "
      "271.2,100,100 -domain_periodic 1,0,0 -pair none -deform_x rate -deform_x_rate 1e-6 ";
  auto outcome = run(folder, strained + "-ts_max_steps 10");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(folder, strained +
                            "-ts_max_steps 500 -energy_monitor ascii:e.csv "
                            "-monitor_interval 7 -checkpoint_file c.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(folder, "-restart c.h5 -ts_max_steps 513 -overwrite");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
}

TEST(Box, TheServoOfAStiffUndampedFilmMakesNoEnergy) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-weave_fibres 6,6 -weave_segments 42 -weave_periodic -weave_rest shaped -deform_x free "
          "-deform_y free -deform_thickness 17.1 -ts_dt 20 -ts_max_steps 600 -progress_interval 0 "
          "-energy_monitor ascii:energy.csv -monitor_interval 20");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // A box that yields takes energy out, once it has measured how stiff the film is.
  const auto energy = readCsv(folder / "energy.csv");
  const auto& external = energy.at("external");
  EXPECT_LT(*std::ranges::max_element(external), 0.1 * energy.at("total")[0]);
  EXPECT_LT(external.back(), 0);
}

TEST(Box, TheServoKeepsWhatItMeasuredAcrossARestart) {
  const std::string outputs =
      "-box_monitor ascii:box.csv -energy_monitor ascii:energy.csv -monitor_interval 20 "
      "-state_output out.h5 ";
  const Folder whole, pieces;
  auto outcome = run(whole, throughWidth(10) + "-state_output out.h5 -ts_max_steps 400");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, throughWidth(10) + "-checkpoint_file c.h5 -ts_max_steps 90");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = run(pieces, outputs + "-restart c.h5 -ts_max_steps 400");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* file : {"out.h5", "energy.csv", "box.csv"})
    EXPECT_TRUE(readFile(pieces / file) == readFile(whole / file)) << file;
}

TEST(Box, ATriangularLatticeOfSpringsHasItsElasticConstants) {
  // Single segments as nodes, springs of the constant k between neighbours: lambda = mu =
  // sqrt(3)/4 k over the thickness.
  const double k = 2.0, thickness = 10, strain = 1e-4;
  for (const char* axis : {"x", "y"}) {
    const Folder folder;
    writeLattice(folder / "in.h5", 0);
    const std::string mode = std::string("-deform_") + axis;
    const auto outcome =
        run(folder,
            "-scene file -scene_file in.h5 -pair none -link_law spring -link_stretch " +
                std::to_string(k) + " " + mode + " rate " + mode + "_rate 1e-6 " + mode +
                "_until " + std::to_string(strain) +
                " -deform_thickness 10 -ts_dt 10 -ts_max_steps 40 -progress_interval 0 "
                "-box_monitor ascii:box.csv -monitor_interval 40",
            2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto box = readCsv(folder / "box.csv");
    const double lame = std::sqrt(3) / 4 * k / thickness / gigapascal;
    const bool x = axis[0] == 'x';
    EXPECT_NEAR(box.at(x ? "xx_GPa" : "yy_GPa").back() / (3 * lame * strain), 1.0, 1e-3);
    EXPECT_NEAR(box.at(x ? "yy_GPa" : "xx_GPa").back() / (lame * strain), 1.0, 1e-3);
    EXPECT_NEAR(box.at("xy_GPa").back(), 0.0, 1e-4 * lame * strain);
  }
}

TEST(Box, AHeldSheetHasItsStressOverItsThickness) {
  auto stress = [](const std::string& options) {
    const Folder folder;
    const auto outcome = run(folder,
                             "-weave_fibres 4,4 -weave_segments 24 -weave_periodic -ts_max_steps 0 "
                             "-box_monitor ascii:box.csv " +
                                 options);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return readCsv(folder / "box.csv").at("xx_GPa").back();
  };
  const double ofBox = stress(""), thin = stress("-deform_thickness 10"),
               thick = stress("-deform_thickness 40");
  ASSERT_NE(ofBox, 0);
  EXPECT_NEAR(thin / thick, 4.0, 1e-9);
  EXPECT_GT(std::abs(thin), std::abs(ofBox));
}

/// The largest error of the energy balance of a lattice out of order, whose nodes do not simply
/// follow the box, over `time` in steps of `dt`.
double worstBalance(const std::string& deforms, double time, double dt) {
  const Folder folder;
  writeLattice(folder / "in.h5", 12);
  const auto steps = std::lround(time / dt);
  const auto outcome = run(
      folder,
      "-scene file -scene_file in.h5 -pair none -link_law spring -link_stretch 2 "
      "-deform_thickness 10 " +
          deforms + " -ts_dt " + std::to_string(dt) + " -ts_max_steps " + std::to_string(steps) +
          " -progress_interval 0 -energy_monitor ascii:energy.csv -monitor_interval " +
          std::to_string(steps / 50));
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto energy = readCsv(folder / "energy.csv");
  double error = 0;
  for (std::size_t k = 0; k < energy.at("total").size(); ++k)
    error = std::max(error, std::abs(energy.at("total")[k] - energy.at("external")[k]));
  EXPECT_GT(energy.at("external").back(), 100 * error);
  return error;
}

TEST(Box, ItsWorkBalancesToSecondOrder) {
  // The third stretches and shears the box at once; the last measures the stress so rarely that the
  // volume changes from one measurement to the next.
  const std::string stretches = "-deform_x rate -deform_x_rate 1e-5 ",
                    shears = "-deform_xy rate -deform_xy_rate 1e-5 ",
                    always = "-deform_interval 1 ", free = "-deform_y free ";
  const struct {
    std::string deforms;
    double time, dt;
  } cases[] = {{stretches + free + always, 40000, 40},
               {shears + always, 40000, 40},
               {stretches + free + shears + always, 40000, 40},
               {stretches + shears + "-deform_interval 20", 20000, 10}};
  for (const auto& [deforms, time, dt] : cases) {
    const double coarse = worstBalance(deforms, time, dt),
                 middle = worstBalance(deforms, time, dt / 2),
                 fine = worstBalance(deforms, time, dt / 4);
    EXPECT_GT(coarse / middle, 3) << deforms;
    EXPECT_GT(middle / fine, 3) << deforms;
  }
}

TEST(Box, GrowsIntoItsRate) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 40 -fibre_closed -domain_lower 0,-100,-100 -domain_upper "
          "542.4,100,100 -domain_periodic 1,0,0 -pair none -ts_dt 2 -deform_x rate -deform_x_rate "
          "1e-6 -deform_ramp 4000 -ts_max_steps 1000 -progress_interval 0 -box_monitor "
          "ascii:box.csv -monitor_interval 1000");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NEAR(readCsv(folder / "box.csv").at("strain_x").back(), 1e-6 * 2000 * 2000 / 8000, 1e-6);
}

TEST(Box, WhatCannotBeMeantIsRefused) {
  const Folder folder;
  const std::string weave = "-weave_fibres 2,2 -weave_segments 12 -ts_max_steps 1 ";
  const struct {
    std::string options;
    std::vector<std::string> says;
  } cases[] = {
      {"-deform_x rate -deform_x_rate 1e-6", {"-deform_x", "open"}},
      {"-weave_periodic -deform_x rate", {"-deform_x_rate"}},
      {"-weave_periodic -deform_x_rate 1e-6", {"-deform_x_rate", "held"}},
      {"-weave_periodic -deform_x rate -deform_x_rate 1e-6 -deform_x_until -0.1",
       {"-deform_x_until"}},
      {"-weave_periodic -deform_x free -deform_ramp 100", {"-deform_ramp"}},
      {"-weave_periodic -deform_x program", {"-deform_x_program"}},
      {"-weave_periodic -deform_x program -deform_x_program 0.1", {"-deform_x_program", "odd"}},
      {"-weave_periodic -deform_x free -deform_x_stress 1", {"-deform_x_stress"}},
      {"-weave_periodic -deform_x free -relax_method fire", {"-deform_x"}},
      {"-weave_periodic -deform_x free -units si -fibre_preset carbon_t300", {"-deform_time"}}};
  for (const auto& c : cases) expectRefused(run(folder, weave + c.options), c.says);
}

TEST(BoxDrive, ThatBouncesAtTheStartIsNotTakenForUnstable) {
  // Stiff contacts let go within the first interval between measurements of the stress.
  const Folder folder;
  const auto outcome =
      run(folder,
          "-units si -fibre_preset carbon_t300 -fibre_segment_length 3.5e-6 -pair contact "
          "-contact_friction 0.3 -contact_restitution 0.3 -scene weave -weave_fibres 2,2 "
          "-weave_filaments 4,1 -weave_segments 28 -weave_periodic -weave_rest shaped "
          "-damping_local 0.2 -deform_x free -deform_y free -deform_thickness 1.4e-5 "
          "-deform_modulus 20 -deform_time 2e-9 -deform_most_rate 1e5 -ts_max_steps 400 "
          "-fibre_bond_stiffness 2.529e6,3.098e-6,-5.332e-7,3.367e-8 -contact_modulus 75 "
          "-progress_interval 0");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
}

}  // namespace
}  // namespace nanoweft::test
