/// What header and summary say where people measure forces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "support/program.hpp"

using namespace nanoweft::test;

namespace {

const std::string pulled =
    "-scene fibre -fibre_segments 30 -tension_rate 1e-5 -tension_ramp 0 -tension_grip 30 "
    "-tension_width 10 -progress_interval 0 ";

/// The number behind `words`.
double numberAfter(const std::string& text, const std::string& words) {
  const auto at = text.find(words);
  return at == std::string::npos ? -1e300 : std::atof(text.c_str() + at + words.size());
}

class SummaryOnRanks : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Summary, SummaryOnRanks, testing::Values(1, 3));

TEST_P(SummaryOnRanks, SaysWhatShareOfTheWorkDampingTook) {
  const Folder folder;
  for (const auto& [options, noticed] : std::vector<std::pair<std::string, bool>>{
           {"-damping_local 0.5 -ts_max_steps 300", true},
           {"-damping_local 0.05 -ts_max_steps 300", false}}) {
    const Outcome outcome = run(folder, pulled + options, GetParam());
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const double damped = numberAfter(outcome.output, "(damped "),
                 work = numberAfter(outcome.output, ", external ");
    ASSERT_GT(work, 0.0) << outcome.output;
    const double share = 100 * damped / work;
    EXPECT_NEAR(numberAfter(outcome.output, "damping took "), share, 0.01 * share)
        << outcome.output;
    EXPECT_EQ(share > 5, noticed) << outcome.output;
    EXPECT_EQ(outcome.output.find("remark: -damping_local") != std::string::npos, noticed)
        << outcome.output;
  }
}

TEST(Summary, DoesNotBlameDampingForWhatElseTakesEnergy) {
  const Folder folder;
  // Its crimp is bent, and gives more than the grips do.
  const std::string pulledWeave =
      "-scene weave -weave_fibres 3,3 -weave_segments 24 -damping_local 0.3 -tension_rate 1e-5 "
      "-tension_ramp 0 -ts_max_steps 80 -progress_interval 0 ";
  for (const std::string& options :
       {// Nearly all of the work is plastic.
        pulled + "-fibre_yield_strain 0.001 -damping_local 0.01 -ts_max_steps 400",
        pulled + "-fibre_retardation 20 -damping_local 0.01 -ts_max_steps 300", pulledWeave,
        pulledWeave + "-temperature 0 -temperature_damping 1e-3 -weave_rest shaped",
        pulledWeave +
            "-pair vdw,contact -contact_modulus 20 -contact_restitution 0.5 -weave_rest shaped"}) {
    const Outcome outcome = run(folder, options);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_GT(numberAfter(outcome.output, "(damped "), 0.0);
    EXPECT_GT(numberAfter(outcome.output, ", external "), 0.0);
    EXPECT_EQ(outcome.output.find("damping took"), std::string::npos) << outcome.output;
    EXPECT_EQ(outcome.output.find("remark: -damping_local"), std::string::npos) << outcome.output;
  }
}

TEST(Summary, SaysThatDampingTookTheRecoilOfWhatBroke) {
  const Folder folder;
  const std::string pull =
      "-scene fibre -fibre_segments 20 -pair none -tension_rate 1e-5 -tension_max_strain 0.06 "
      "-tension_width 10 -tension_grip 13.56 -ts_dt 15 -damping_local 0.4 -progress_interval 0 ";
  const Outcome torn = run(folder, pull + "-break_strain_mean 0.03 -break_strain_std 0.002");
  ASSERT_EQ(torn.status, 0) << torn.output;
  EXPECT_GT(numberAfter(torn.output, "damping took "), 5.0) << torn.output;
  EXPECT_NE(torn.output.find("the recoil of what broke"), std::string::npos) << torn.output;
  const Outcome whole = run(folder, pull);
  ASSERT_EQ(whole.status, 0) << whole.output;
  EXPECT_EQ(whole.output.find("recoil"), std::string::npos) << whole.output;
}

TEST(Summary, SaysThePressureOfATestThatPresses) {
  const Folder folder;
  const std::string options =
      "-scene fibre -fibre_segments 6 -pair none -tension_ramp 5000 -tension_width 10 "
      "-tension_grip 13.56 -ts_dt 15 -progress_interval 0 -monitor_interval 10 -overwrite "
      "-checkpoint_file c.h5 -state_output s.h5 -stress_monitor ascii:s.csv ";
  auto meanOf = [&](std::size_t row) {
    const auto table = readCsv(folder / "s.csv");
    return 0.5 * (table.at("stress_left_GPa")[row] + table.at("stress_right_GPa")[row]);
  };
  for (const char* course : {"-tension_rate -1e-5 -tension_max_strain -0.02",
                             "-tension_program -0.02,1e-5,-0.01,1e-5"}) {
    const Outcome half = run(folder, options + course + " -ts_max_steps 100");
    ASSERT_EQ(half.status, 0) << half.output;
    EXPECT_LT(meanOf(readCsv(folder / "s.csv").at("strain").size() - 1), -1.0);
    const Outcome whole = run(folder, options + course + " -restart c.h5");
    ASSERT_EQ(whole.status, 0) << whole.output;
    double lowest = 0;
    for (std::size_t row = 0; row < readCsv(folder / "s.csv").at("strain").size(); ++row)
      lowest = std::min(lowest, meanOf(row));
    EXPECT_LT(lowest, -10.0);
    EXPECT_NEAR(numberAfter(whole.output, "%, largest pressure "), -lowest, -1e-3 * lowest)
        << whole.output;
  }
  // The next stage goes back, but does not pull: it knows the largest pressure of the first one.
  const Outcome back =
      run(folder,
          "-scene file -scene_file s.h5 -pair none -tension_rate 1e-5 -tension_max_strain "
          "-0.005 -ts_dt 15 -tension_ramp 0 -progress_interval 0");
  ASSERT_EQ(back.status, 0) << back.output;
  EXPECT_GT(numberAfter(back.output, "%, largest pressure "), 10.0) << back.output;
  // A test that has been pulled before has its strength, whatever a later stage does.
  const Outcome pull = run(folder, options + "-tension_rate 1e-5 -tension_max_strain 0.01");
  ASSERT_EQ(pull.status, 0) << pull.output;
  const Outcome press = run(folder,
                            "-scene file -scene_file s.h5 -pair none -tension_rate -1e-5 "
                            "-tension_max_strain -0.005 -ts_dt 15 -progress_interval 0");
  ASSERT_EQ(press.status, 0) << press.output;
  EXPECT_EQ(press.output.find("largest pressure"), std::string::npos) << press.output;
}

TEST(Summary, SaysTheStressOfAPieceThatIsReleasedFromPressure) {
  // All rows are of pressure: the largest stress is the one next to none, but not none.
  const Folder folder;
  const Outcome outcome = run(folder,
                              "-scene fibre -fibre_segments 6 -fibre_strain -0.02 -pair none "
                              "-tension_rate 1e-6 -tension_max_strain 0.005 -tension_width 10 "
                              "-tension_grip 13.56 -ts_dt 15 -progress_interval 0");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_LT(numberAfter(outcome.output, "%, strength "), -5.0) << outcome.output;
}

TEST(Header, SaysTheHighestRateOfATestThatIsShortForItsRamp) {
  const Folder folder;
  const std::string options =
      "-scene fibre -fibre_segments 11 -pair none -tension_width 10 -tension_grip 13.56 -ts_dt 15 "
      "-ts_max_steps 1 -progress_interval 0 -overwrite ";
  for (const auto& [course, said] : std::vector<std::pair<std::string, std::string>>{
           // sqrt(2 * 0.001/0.01) of it.
           {"1e-6 -tension_max_strain 0.001",
            "rate 1e-06 (4.47e-07 at most: the way is short for "
            "its ramp) 1/fs"},
           {"-1e-6 -tension_max_strain -0.001",
            "rate -1e-06 (-4.47e-07 at most: the way is short "
            "for its ramp) 1/fs"},
           {"1e-6 -tension_max_strain 0.005", "rate 1e-06 1/fs"},
           {"1e-6 -tension_max_strain 0.001 -tension_ramp 0", "rate 1e-06 1/fs"}}) {
    const Outcome outcome = run(folder, options + "-tension_rate " + course);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find(said), std::string::npos) << outcome.output;
  }
}

/// Does a run with these options say so?
void expectSaid(const std::string& options, const std::string& text, bool said) {
  const Folder folder;
  const Outcome outcome = run(folder, options + " -progress_interval 0");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find(text) != std::string::npos, said) << options << "\n"
                                                                  << outcome.output;
}

const std::string drift = "of the energy that there was to turn into motion",
                  coarse = "external, damped and heat lose what a step adds";

TEST(Summary, WarnsOfABalanceThatDrifts) {
  const std::string options =
      "-scene bundle -bundle_fibres 7 -bundle_segments 20 -scene_perturb 0.3 -energy_alarm 0 "
      "-ts_max_steps 301 -ts_dt ";
  expectSaid(options + "32", drift, true);
  expectSaid(options + "5", drift, false);
}

TEST(Summary, WarnsOfADriftThatIsSmallBesideTheStiffnessOfTheBonds) {
  // A carbon fibre falls on a wall so hard that a bounce lasts one step. Its energies are 1e-13 of
  // B1 T^2.
  const std::string options =
      "-units si -scene fibre -fibre_preset carbon_t300 -fibre_segments 10 -pair none -walls floor "
      "-floor_point 0,0,-3.6e-6 -floor_axis 0,0,1 -bc all -all_region -1,-1,-1,1,1,1 -all_force "
      "0,0,-1e-11 ";
  expectSaid(options + "-floor_modulus 4000 -ts_max_time 1.5e-4", drift, true);
  expectSaid(options + "-floor_modulus 4 -ts_max_time 1.5e-4", drift, false);
  // When the fibre has hardly any energy, its accounts' loss is a large share, but less than this.
  expectSaid(options + "-floor_modulus 400 -ts_max_time 2e-4", coarse, false);
}

TEST(Summary, WarnsOfAccountsThatAreTooCoarse) {
  const std::string options =
      "-units si -fibre_preset glass_e -scene fibre -fibre_segments 21 -pair none -bc all "
      "-all_region -1,-1,-1,1,1,1 -ts_max_time 2e-5 -all_force 0,0,";
  expectSaid(options + "1e-13", coarse, true);
  expectSaid(options + "1e-9", coarse, false);
}

TEST(Summary, IsSilentOfAccountsWhereARunHasComeToRest) {
  const Folder folder;
  const auto outcome = run(folder,
                           "-scene fibre -fibre_segments 20 -fibre_bend 1 -pair none "
                           "-damping_local 0.5 -ts_max_steps 100000 -progress_interval 0");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("warning"), std::string::npos) << outcome.output;
}

TEST(Summary, FindsTheForceOfGripsThatHoldAWideAndLightPiece) {
  const Folder folder;
  const auto outcome = run(folder,
                           "-units si -fibre_preset collagen -scene fibre -fibre_segments 30 "
                           "-pair none -tension_rate 2e3 -tension_max_strain 1e-6 "
                           "-tension_width 1e-3 -tension_thickness 1e-3");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("the grips have felt no force"), std::string::npos)
      << outcome.output;
}

TEST(Summary, IsSilentWhereNothingIsDampedOrNoWorkIsDone) {
  const Folder folder;
  for (const std::string& options :
       {pulled + "-ts_max_steps 50",
        std::string("-scene weave -weave_fibres 3,3 -weave_segments 24 -damping_local 0.3 "
                    "-ts_max_steps 50 -progress_interval 0")}) {
    const Outcome outcome = run(folder, options);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("damping took"), std::string::npos) << outcome.output;
  }
}

}  // namespace
