/// The step limit that the program estimates must part stable runs from unstable ones within 10 %,
/// and a run that goes unstable must say so. Displacements of 1e-4 A keep to linear theory: Verlet
/// is stable while w dt < 2 for the highest frequency w.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nanoweft/base/hdf5.hpp"
#include "nanoweft/base/units.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

const std::string perturbed = " -scene_perturb 1e-4";

/// The limit in the header of a run: "stable below X now".
double printedLimit(const Folder& folder, const std::string& scene) {
  const auto outcome = run(folder, scene + perturbed + " -ts_dt 1 -ts_max_steps 1");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const std::string words = "stable below ";
  const auto at = outcome.output.find(words);
  return at == std::string::npos ? NAN : std::stod(outcome.output.substr(at + words.size()));
}

double energyAtRest(const Folder& folder, const std::string& scene) {
  const auto outcome =
      run(folder, scene + " -ts_max_steps 0 -energy_monitor ascii:rest.csv -overwrite");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return readCsv(folder / "rest.csv").at("total").front();
}

Outcome runAt(const Folder& folder, const std::string& scene, double dt, const std::string& more) {
  return run(folder, scene + perturbed + " -ts_dt " + std::to_string(dt) + " " + more);
}

/// `scene` rests in a stable equilibrium. Returns the limit.
double expectLimitSeparates(const Folder& folder, const std::string& scene, int steps = 2000) {
  const double limit = printedLimit(folder, scene), rest = energyAtRest(folder, scene);
  EXPECT_TRUE(limit > 1 && limit < 100);
  for (double part : {0.5, 0.9}) {
    const auto outcome = runAt(folder, scene, part * limit,
                               "-ts_max_steps " + std::to_string(steps) +
                                   " -energy_monitor ascii:run.csv -monitor_interval 1 -overwrite");
    EXPECT_EQ(outcome.status, 0) << part << " of the limit: " << outcome.output;
    if (outcome.status != 0) continue;
    const auto total = readCsv(folder / "run.csv").at("total");
    // Of a mode of frequency w Verlet keeps p^2/2 + (1 - (w dt/2)^2) w^2 q^2/2, so that its energy
    // grows by 1/(1 - part^2) at most. 10 % and round-off of 1e-13 on top for what is not linear.
    const double excess = total.front() - rest;
    EXPECT_GT(excess, 0);
    EXPECT_LT(*std::ranges::max_element(total) - rest,
              1.1 * excess / (1 - part * part) + 1e-13 * std::abs(rest))
        << part << " of the limit";
  }
  // On the limit itself either is right, but an end in order.
  const auto between = runAt(folder, scene, limit, "-ts_max_steps 300 -ts_dt_unsafe");
  EXPECT_TRUE(between.status == 0 || between.status == 2) << between.output;
  const auto refused = runAt(folder, scene, 1.1 * limit, "-ts_max_steps 3000");
  EXPECT_EQ(refused.status, 1) << refused.output;
  const auto beyond = runAt(folder, scene, 1.1 * limit, "-ts_max_steps 3000 -ts_dt_unsafe");
  EXPECT_EQ(beyond.status, 2) << beyond.output;
  int step = 0, fibre = -1, segment = -1;
  const auto at = beyond.output.find("unstable at step");
  EXPECT_EQ(std::sscanf(at == std::string::npos ? "" : beyond.output.c_str() + at,
                        "unstable at step %d: fibre %d segment %d", &step, &fibre, &segment),
            3)
      << beyond.output;
  EXPECT_GT(step, 0);
  EXPECT_GE(fibre, 0);
  EXPECT_GE(segment, 0);
  return limit;
}

/// Lets `scene` come to rest; the state is at.h5, whose scene is returned.
std::string relaxed(const Folder& folder, const std::string& scene, int steps) {
  const auto outcome = run(folder, scene + " -damping_local 0.7 -ts_dt 15 -ts_max_steps " +
                                       std::to_string(steps) + " -state_output rest.h5 -overwrite");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  stopMotion(folder / "rest.h5");
  return "-scene file -scene_file rest.h5";
}

TEST(StepLimit, SeparatesForAStraightFibre) {
  const Folder folder;
  expectLimitSeparates(folder, "-scene fibre -fibre_segments 40 -pair none");
}

TEST(StepLimit, SeparatesForAStretchedFibre) {
  const Folder folder;
  expectLimitSeparates(
      folder,
      "-scene fibre -fibre_segments 40 -fibre_closed -fibre_strain 0.05 -pair none "
      "-domain_lower 0,-100,-100 -domain_upper 569.52,100,100 "
      "-domain_periodic 1,0,0");
}

TEST(StepLimit, SeparatesForABentFibre) {
  const Folder folder;
  expectLimitSeparates(
      folder,
      "-scene fibre -fibre_segments 24 -fibre_closed -fibre_bend 6.283185307179586 -pair none");
}

TEST(StepLimit, SeparatesForATwistedFibre) {
  // Three turns over 47 bonds, 0.4 rad each. Stretched by 5 %, it bears a couple of
  // 2 sqrt(EJ ES 0.05) = 2020 eV before it buckles; its own is B4 sin(0.4) = 570 eV.
  const Folder folder;
  expectLimitSeparates(folder,
                       "-scene fibre -fibre_segments 47 -fibre_closed -fibre_strain 0.05 "
                       "-fibre_twist 18.849555921538759 -pair none -domain_lower 0,-100,-100 "
                       "-domain_upper 669.186,100,100 -domain_periodic 1,0,0");
}

TEST(StepLimit, SeparatesForABundle) {
  // Seven tubes side by side through a periodic boundary, six around one.
  const Folder folder;
  std::vector<FibreInput> tubes;
  for (int k = 0; k < 7; ++k) {
    const double angle = std::acos(-1.0) / 3 * k, radius = k == 0 ? 0 : 17.07;
    tubes.push_back(
        straightFibre({0, radius * std::cos(angle), radius * std::sin(angle)}, {1, 0, 0}, 12));
    tubes.back().closed = true;
  }
  BoxInput box;
  box.lower = {0, -200, -200};
  box.upper = {12 * 13.56, 200, 200};
  box.periodic = {true, false, false};
  writeState(folder / "in.h5", tubes, box);
  expectLimitSeparates(folder,
                       relaxed(folder, "-scene file -scene_file in.h5 -scene_perturb 0.05", 8000));
}

TEST(StepLimit, SeparatesForASqueezedBundle) {
  // A hexagonal packing that fills a periodic box with 16 A from tube to tube, in the linear
  // repulsion: six contacts a segment, of stiffness 2k/3 and more, bring the limit of free chains,
  // 48 fs, well down. The short cutoff only saves time.
  const Folder folder;
  std::vector<FibreInput> tubes;
  const double row = 8 * std::sqrt(3.0);
  for (int j = 0; j < 6; ++j)
    for (int k = 0; k < 5; ++k) {
      tubes.push_back(straightFibre({0, 16 * (k + 0.5 * (j % 2)), row * j}, {1, 0, 0}, 6));
      tubes.back().closed = true;
    }
  BoxInput box;
  box.lower = {0, 0, 0};
  box.upper = {6 * 13.56, 80, 6 * row};
  box.periodic = {true, true, true};
  writeState(folder / "in.h5", tubes, box);
  const std::string law = " -pair_switch 20 -pair_cutoff 25";
  const double limit = expectLimitSeparates(
      folder,
      relaxed(folder, "-scene file -scene_file in.h5 -scene_perturb 0.02" + law, 6000) + law, 400);
  EXPECT_LT(limit, 40);
}

TEST(StepLimit, SeparatesForAWeave) {
  const Folder folder;
  expectLimitSeparates(
      folder, relaxed(folder, "-weave_fibres 2,2 -weave_segments 12 -weave_periodic", 20000));
}

/// Two parallel tubes out of each other's reach that are pushed together: free chains stay stable
/// up to steps of 48 fs, tubes pressed together (contact stiffness 2k/3 a pair of segments) do not.
std::string pushedTogether(const Folder& folder) {
  writeState(folder / "in.h5",
             {straightFibre({0, -35, 0}, {1, 0, 0}, 12), straightFibre({0, 35, 0}, {1, 0, 0}, 12)});
  return "-scene file -scene_file in.h5 -bc left,right "
         "-left_region -1000,-40,-10,1000,-30,10 -left_force 0,0.5,0 "
         "-right_region -1000,30,-10,1000,40,10 -right_force 0,-0.5,0 -scene_perturb 0.01 ";
}

TEST(StepLimit, IsThatOfTheKindsThatAreThere) {
  const Folder folder;
  const std::string fibre =
      "-kinds heavy,light -heavy_fibre_segment_mass 26490 -scene fibre -fibre_segments 20 -pair "
      "none -fibre_kind ";
  // A tube's moment of inertia is its mass times rf^2.
  const double light = expectLimitSeparates(folder, fibre + "light"),
               heavy = printedLimit(folder, fibre + "heavy");
  EXPECT_NEAR(heavy / light, std::sqrt(10.0), 0.02);
}

TEST(StepLimit, CheckpointBeforeTheInstabilityIsNamedAndReadable) {
  const Folder folder;
  const auto outcome = run(folder, pushedTogether(folder) +
                                       "-ts_dt 46 -ts_max_steps 5000 -checkpoint_file safe/c.h5 "
                                       "-checkpoint_interval 20");
  ASSERT_EQ(outcome.status, 2) << outcome.output;
  const auto at = outcome.output.find("unstable at step"),
             named = outcome.output.find("the checkpoint safe/c.h5 of step");
  ASSERT_NE(at, std::string::npos) << outcome.output;
  ASSERT_NE(named, std::string::npos) << outcome.output;
  int failed = 0, saved = 0;
  std::sscanf(outcome.output.c_str() + at, "unstable at step %d", &failed);
  std::sscanf(outcome.output.c_str() + named, "the checkpoint safe/c.h5 of step %d", &saved);
  EXPECT_GT(saved, 0);
  EXPECT_LT(saved, failed);
  EXPECT_EQ(saved % 20, 0);
  const auto read = run(folder,
                        "-scene file -scene_file safe/c.h5 -ts_max_steps 0 -pair_allow_overlap "
                        "-energy_monitor ascii:energy.csv");
  ASSERT_EQ(read.status, 0) << read.output;
  EXPECT_TRUE(std::isfinite(readCsv(folder / "energy.csv").at("total").front()));
}

/// The step at which a run said that it was unstable, or -1.
int unstableStep(const Outcome& outcome) {
  const auto at = outcome.output.find("unstable at step");
  int step = -1;
  if (at != std::string::npos)
    std::sscanf(outcome.output.c_str() + at, "unstable at step %d", &step);
  return step;
}

TEST(StepLimit, EnergyOutOfNothingEndsARunBeforeDisplacementsDo) {
  const Folder folder;
  const std::string options =
      pushedTogether(folder) + "-ts_dt 46 -ts_max_steps 5000 -energy_alarm ";
  const auto silent = run(folder, options + "0"), alarmed = run(folder, options + "0.25");
  EXPECT_EQ(silent.status, 2) << silent.output;
  EXPECT_EQ(alarmed.status, 2) << alarmed.output;
  EXPECT_GT(unstableStep(alarmed), 0) << alarmed.output;
  EXPECT_LT(unstableStep(alarmed), unstableStep(silent));
  EXPECT_NE(alarmed.output.find("energy has risen"), std::string::npos) << alarmed.output;
}

TEST(StepLimit, ARunTooShortForALookAtItsEnergiesIsJudgedAtItsEnd) {
  const Folder folder;
  for (const auto& [dt, status] : {std::pair{"20", 0}, std::pair{"47", 2}}) {
    const auto outcome =
        run(folder, std::string("-scene bundle -bundle_fibres 7 -bundle_segments 10 "
                                "-bundle_gap 15 -ts_dt_unsafe -ts_limit_interval 0 "
                                "-ts_max_steps 99 -ts_dt ") +
                        dt);
    EXPECT_EQ(outcome.status, status) << outcome.output;
  }
}

TEST(StepLimit, TheEnergyAlarmGoesOnInARestart) {
  const Folder folder;
  const std::string options =
      pushedTogether(folder) + "-ts_dt 20 -overwrite -checkpoint_file c.h5 -ts_max_steps ";
  auto watch = [&](const std::string& what) {
    const auto outcome = run(folder, what);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    const h5::Handle file(H5Fopen((folder / "c.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT),
                          H5Fclose),
        record(H5Gopen2(file, "/run", H5P_DEFAULT), H5Gclose);
    return h5::readReals(record, "energy_watch").value_or(std::vector<double>());
  };
  const auto whole = watch(options + "600");
  watch(options + "300");
  ASSERT_EQ(whole.size(), 6u);
  EXPECT_EQ(watch("-restart c.h5 -checkpoint_file c.h5 -ts_max_steps 600"), whole);
  // A minimiser's steps are its own.
  const std::string fire =
      "-scene weave -weave_fibres 4,4 -weave_segments 20 -relax_method fire -ts_dt 20 -overwrite "
      "-checkpoint_file c.h5 -ts_max_steps ";
  const auto relaxed = watch(fire + "300");
  watch(fire + "30");
  EXPECT_EQ(watch("-restart c.h5 -checkpoint_file c.h5 -ts_max_steps 300"), relaxed);
  // Whoever goes on with another step judges that one from there.
  watch(options + "300");
  const auto anew = watch("-restart c.h5 -checkpoint_file c.h5 -ts_dt 10 -ts_max_steps 600");
  EXPECT_NEAR(anew.at(4), 300 * 20, 1e-9);
  EXPECT_NEAR(whole.at(4), 0, 1e-9);
}

TEST(StepLimit, SamePushIsStableWithTheStepForPressedTubes) {
  // So that it is the step that made the runs above unstable. The energy's error while the tubes
  // are pressed together, 5 % of what they store then, is no instability: it goes as they part.
  const Folder folder;
  const auto outcome = run(folder, pushedTogether(folder) + "-ts_dt 20 -ts_max_steps 1200");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
}

TEST(StepLimit, ForPressedFibresAddsTheStiffnessesOfTheirLaws) {
  const Folder folder;
  // Squared frequency over that of the free chain, by which laws raise it.
  auto raised = [&](const std::string& laws) {
    const auto outcome = run(folder,
                             "-weave_fibres 2,2 -weave_segments 12 -ts_max_steps 1 "
                             "-ts_dt 1 -pair " +
                                 laws);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    double chain = 0, pressed = 0;
    const auto at = outcome.output.find(" now, ");
    EXPECT_NE(at, std::string::npos) << outcome.output;
    if (at != std::string::npos)
      std::sscanf(outcome.output.c_str() + at, " now, %lf for a free chain, about %lf", &chain,
                  &pressed);
    return 1 / (pressed * pressed) - 1 / (chain * chain);
  };
  const std::string contact = "contact -contact_modulus 500";
  const double both = raised("vdw," + contact);
  EXPECT_GT(both, 0);
  EXPECT_NEAR((raised("vdw") + raised(contact)) / both, 1.0, 0.01);
}

/// Long segments turn where they are pressed, and many points do not make a line softer.
TEST(StepLimit, OfLongSegmentsOrManyPointsHoldsForABundleThatFallsTogether) {
  for (const char* bundle :
       {"-bundle_segments 10 -bundle_gap 19 -fibre_segment_length 54.24 -ts_max_steps 300",
        "-bundle_segments 8 -bundle_gap 88 -fibre_preset amyloid -pair vdw -pair_points 30 "
        "-pair_far_points 3 -ts_max_steps 700"}) {
    const auto outcome = run(Folder(), std::string("-scene bundle -bundle_fibres 19 ") + bundle);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
  }
}

/// Contacts of long segments that overlap by a twentieth of a radius: the pressed limit is theirs.
TEST(StepLimit, OfPressedLongSegmentsIsThatOfTheOverlapItNames) {
  const auto outcome = run(Folder(),
                           "-scene bundle -bundle_fibres 19 -bundle_segments 6 -bundle_gap 78 "
                           "-fibre_preset amyloid -pair contact -pair_allow_overlap "
                           "-fibre_segment_length 800 -ts_max_steps 1");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  double now = 0, chain = 0, pressed = 0;
  const auto at = outcome.output.find("stable below ");
  ASSERT_NE(at, std::string::npos) << outcome.output;
  ASSERT_EQ(
      std::sscanf(outcome.output.c_str() + at,
                  "stable below %lf now, %lf for a free chain, about %lf", &now, &chain, &pressed),
      3);
  EXPECT_NEAR(pressed / now, 1.0, 0.02);
}

TEST(StepLimit, OfFreeAndPressedChainsCountsTheirViscosity) {
  const Folder folder;
  auto limits = [&](const std::string& options) {
    const auto outcome =
        run(folder, "-scene fibre -fibre_segments 60 -ts_max_steps 1 -ts_dt 1 " + options);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    std::array<double, 3> read{};
    const auto at = outcome.output.find("stable below ");
    if (at != std::string::npos)
      std::sscanf(outcome.output.c_str() + at,
                  "stable below %lf now, %lf for a free chain, about %lf", &read[0], &read[1],
                  &read[2]);
    return read;
  };
  const double time = 40;
  const auto plain = limits(""), viscous = limits("-fibre_retardation 40");
  EXPECT_NEAR(viscous[1] / viscous[0], 1.0, 0.01);
  // x'' = -w^2 x - time b^2 x' with the frequencies w of pressed and b of free chains, and the
  // viscous force of half a step earlier, is stable up to 4 = 2 time b^2 dt + w^2 dt^2.
  for (const int k : {1, 2}) {
    const auto of = static_cast<std::size_t>(k);
    const double b2 = 4 / (plain[1] * plain[1]), w2 = 4 / (plain[of] * plain[of]), dt = viscous[of];
    EXPECT_NEAR((2 * time * b2 * dt + w2 * dt * dt) / 4, 1.0, 2e-3) << k;
  }
  // Without a law nothing is pressed.
  EXPECT_EQ(limits("-pair none")[2], 0.0);
}

TEST(StepLimit, ForPressedFibresThatStickIsLower) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, -6.7, 0}, {1, 0, 0}, 12),
                                straightFibre({0, 6.7, 0}, {1, 0, 0}, 12)});
  auto limits = [&](const std::string& friction) {
    const auto outcome = run(folder,
                             "-scene file -scene_file in.h5 -ts_max_steps 1 -ts_dt 1 -pair contact "
                             "-contact_modulus 5000 " +
                                 friction);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    std::array<double, 3> read{};
    const auto at = outcome.output.find("stable below ");
    EXPECT_NE(at, std::string::npos) << outcome.output;
    if (at != std::string::npos)
      std::sscanf(outcome.output.c_str() + at,
                  "stable below %lf now, %lf for a free chain, about %lf", &read[0], &read[1],
                  &read[2]);
    return read;
  };
  const auto slipping = limits(""),
             sticking = limits("-contact_friction 0.5 -contact_tangential 1"),
             soft = limits("-contact_friction 0.5");
  auto raised = [](const std::array<double, 3>& l) {
    return 1 / (l[2] * l[2]) - 1 / (l[1] * l[1]);
  };
  EXPECT_NEAR(raised(sticking) / raised(slipping), 2.0, 0.02);
  EXPECT_NEAR(raised(soft) / raised(slipping), 1.0, 0.01);
  EXPECT_NEAR(sticking[0] / slipping[0], 1.0, 1e-3);
}

/// Two parallel tubes at rest side by side, which a growing force of up to 30 eV/A a segment
/// presses into their linear repulsion.
std::string pressedSlowly(const Folder& folder) {
  writeState(folder / "in.h5", {straightFibre({0, -8.55, 0}, {1, 0, 0}, 12),
                                straightFibre({0, 8.55, 0}, {1, 0, 0}, 12)});
  return "-scene file -scene_file in.h5 -bc left,right -damping_local 0.7 "
         "-left_region -1000,-10,-10,1000,-1,10 -left_force 0,30,0 -left_ramp 6000 "
         "-right_region -1000,1,-10,1000,10,10 -right_force 0,-30,0 -right_ramp 6000 "
         "-scene_perturb 0.001 ";
}

TEST(StepLimit, LimitIsFollowedDuringTheRunAndDisturbsNothing) {
  // Side by side at rest, tubes are stable at 44 fs, pressed together they are not: a warning.
  const std::string warning = "is beyond the stable step of the present state";
  const Folder folder;
  const auto fast = run(folder, pressedSlowly(folder) +
                                    "-ts_dt 44 -ts_max_steps 250 -ts_limit_interval 5 "
                                    "-energy_alarm 0 -progress_interval 0 -checkpoint_file c.h5");
  EXPECT_NE(fast.output.find(warning), std::string::npos) << fast.output;
  // What went on with a warning goes on so after a restart.
  const auto on = run(folder, "-restart c.h5 -ts_max_steps 252 -energy_alarm 0");
  EXPECT_EQ(on.status, 0) << on.output;
  EXPECT_NE(on.output.find("is beyond the stable step of this state"), std::string::npos)
      << on.output;
  const std::string slow =
      pressedSlowly(folder) +
      "-ts_dt 20 -ts_max_steps 400 -state_output out.h5 -overwrite -ts_limit_interval ";
  const auto once = run(folder, slow + "0");
  ASSERT_EQ(once.status, 0) << once.output;
  const std::string expected = readFile(folder / "out.h5");
  const auto followed = run(folder, slow + "5");
  ASSERT_EQ(followed.status, 0) << followed.output;
  EXPECT_EQ(followed.output.find(warning), std::string::npos) << followed.output;
  EXPECT_TRUE(readFile(folder / "out.h5") == expected);
  // A contact of stiffness 2k/3 between two segments adds 2 (400/3)/m at most to the square of the
  // highest frequency, 2/48.4 fs: not below 38.6 fs then, and the summary says how far down.
  double first = 0, lowest = 0;
  const auto at = followed.output.find("stable step: ");
  ASSERT_NE(at, std::string::npos) << followed.output;
  EXPECT_EQ(std::sscanf(followed.output.c_str() + at,
                        "stable step: %lf fs at the start, %lf at the lowest", &first, &lowest),
            2);
  EXPECT_GT(first, 46);
  EXPECT_GT(lowest, 38.6);
  EXPECT_LT(lowest, 44);
}

TEST(StepLimit, WarnsAtTheEndOfLocalDampingNearTheLowest) {
  // 32 fs are less than 0.7 of the first stable step, which is above 46 fs, and more than 0.7 of
  // the lowest, which is below 44 fs.
  const std::string sticks = "slow motion sticks with -damping_local";
  const Folder folder;
  const auto outcome =
      run(folder, pressedSlowly(folder) + "-ts_dt 32 -ts_max_steps 250 -ts_limit_interval 5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto end = outcome.output.find("stable step: ");
  ASSERT_NE(end, std::string::npos) << outcome.output;
  EXPECT_GT(outcome.output.find(sticks), end) << outcome.output;
  EXPECT_NE(outcome.output.find(sticks), std::string::npos) << outcome.output;
  const auto undamped = run(folder, pressedSlowly(folder) +
                                        "-damping_local 0.1 -ts_dt 32 -ts_max_steps 250 "
                                        "-ts_limit_interval 5 -energy_alarm 0");
  EXPECT_EQ(undamped.output.find(sticks), std::string::npos) << undamped.output;
}

TEST(StepLimit, OfSegmentsThatNothingHoldsIsThatOfAChain) {
  // Rods of one segment, far from each other: there is no stiffness, but there may be.
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 1), straightFibre({0, 3e6, 0}, {1, 0, 0}, 1)});
  const auto outcome =
      run(folder, "-scene file -scene_file in.h5 -fibre_preset glass_e -ts_max_steps 3", 2);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  double dt = 0, chain = 0;
  const auto at = outcome.output.find("time step ");
  ASSERT_NE(at, std::string::npos) << outcome.output;
  ASSERT_EQ(std::sscanf(outcome.output.c_str() + at, "time step %lf fs; stable below inf now, %lf",
                        &dt, &chain),
            2)
      << outcome.output;
  EXPECT_NEAR(dt / chain, 0.4, 1e-3);
}

TEST(StepLimit, OfWhatIsFarTooStiffIsRefused) {
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 4), straightFibre({0, 12, 0}, {1, 0, 0}, 4)});
  const auto outcome =
      run(folder,
          "-scene file -scene_file in.h5 -pair hertz -hertz_stiffness 1e16 -ts_dt 1 "
          "-ts_max_steps 3",
          2);
  EXPECT_EQ(outcome.status, 1) << outcome.output;
  EXPECT_NE(outcome.output.find("the stable step cannot be estimated"), std::string::npos)
      << outcome.output;
}

TEST(StepLimit, OfFewSegmentsIsTheSameInAllUnits) {
  // Two segments have so few modes that the search for the highest one comes to an end.
  const Folder folder;
  for (const char* segments : {"2", "3"}) {
    const std::string fibre = std::string("-scene fibre -fibre_segments ") + segments;
    const double nano = printedLimit(folder, fibre);
    const auto outcome =
        run(folder, fibre + " -units si -scene_perturb 1e-14 -ts_dt 1e-15 -ts_max_steps 1");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const std::string words = "stable below ";
    const auto at = outcome.output.find(words);
    ASSERT_NE(at, std::string::npos) << outcome.output;
    EXPECT_NEAR(1e15 * std::stod(outcome.output.substr(at + words.size())) / nano, 1, 2e-3)
        << segments;
  }
}

TEST(StepLimit, OfAViscosityWithALongTimeIsThatOfTheDashpots) {
  // x'' = -w^2 x - t w^2 x' up to dt = 2/(t w^2), for w t without bound.
  const Folder folder;
  const std::string fibre = "-scene fibre -fibre_segments 20 -pair none ";
  const double free = printedLimit(folder, fibre);
  for (const double time : {1e4, 1e10}) {
    char steps[96];
    std::snprintf(steps, sizeof steps, "-fibre_retardation %.17g -ts_dt %.17g -ts_dt_unsafe", time,
                  0.3 * free * free / time);
    const auto outcome = run(folder, fibre + "-ts_max_steps 1 " + steps);
    const std::string words = "stable below ";
    const auto at = outcome.output.find(words);
    ASSERT_NE(at, std::string::npos) << outcome.output;
    EXPECT_NEAR(std::stod(outcome.output.substr(at + words.size())) / (0.5 * free * free / time), 1,
                1e-3);
  }
}

TEST(StepLimit, IsThatOfALightWallWhichAForceDrives) {
  // A lid presses a fibre on a floor. It is far lighter than what it touches, and bound to it by
  // (pi/4) E* T a segment.
  const Folder folder;
  constexpr double segments = 10, press = 0.2, mass = 0.75, modulus = 20;
  const double stiffness = segments * tube::pi / 4 * modulus * tube::gigapascal * tube::length,
               overlap = press / stiffness;
  writeState(folder / "in.h5", {straightFibre({0, 0, tube::rf - overlap}, {1, 0, 0}, 10)});
  auto scene = [&](double m) {
    return "-scene file -scene_file in.h5 -pair none -walls floor,lid -floor_point 0,0,0 "
           "-floor_axis 0,0,1 -floor_modulus 20 -lid_axis 0,0,-1 -lid_modulus 20 -lid_force 0,0," +
           std::to_string(-press) + " -lid_mass " + std::to_string(m) + " -lid_point 0,0," +
           std::to_string(2 * tube::rf - 2 * overlap);
  };
  const double heavy = printedLimit(folder, scene(1e12)), light = printedLimit(folder, scene(mass));
  const double ofLid = stiffness / (mass * nanoUnits().mass);
  EXPECT_NEAR(light, 2 / std::sqrt(4 / (heavy * heavy) + ofLid), 1e-3 * light);
  EXPECT_LT(light, heavy / 5);
  auto most = [&](double dt) {
    const auto outcome = runAt(folder, scene(mass), dt,
                               "-ts_dt_unsafe -energy_alarm 0 -ts_max_steps 400 -energy_monitor "
                               "ascii:lid.csv -monitor_interval 1 -overwrite");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    const auto total = readCsv(folder / "lid.csv").at("total");
    return *std::ranges::max_element(total) - total.front();
  };
  EXPECT_LT(most(0.9 * light), 1e-4);
  EXPECT_GT(most(1.1 * light), 1e-2);
}

TEST(StepLimit, WarnsOfLocalDampingNearIt) {
  // Of 48.4 fs.
  const auto warned = [](const std::string& dt, const std::string& damping) {
    const Folder folder;
    const auto outcome = run(folder,
                             "-scene fibre -fibre_segments 40 -pair none -ts_max_steps 1 "
                             "-ts_dt " +
                                 dt + " -damping_local " + damping);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return outcome.output.find("slow motion sticks with -damping_local") != std::string::npos;
  };
  EXPECT_TRUE(warned("36", "0.4"));
  EXPECT_FALSE(warned("33", "0.4"));
  EXPECT_FALSE(warned("40", "0.1"));
  EXPECT_FALSE(warned("40", "0"));
}

TEST(StepLimit, EnergyThatDampingHidesIsNoticed) {
  // Local damping takes out what the unstable contact brings in, so that nothing moves far: only
  // the balance of all accounts shows it.
  const Folder folder;
  const std::string options = pressedSlowly(folder) + "-ts_dt 44 -ts_max_steps 400 ";
  EXPECT_EQ(run(folder, options + "-energy_alarm 0").status, 0);
  const auto alarmed = run(folder, options);
  EXPECT_EQ(alarmed.status, 2) << alarmed.output;
  EXPECT_NE(alarmed.output.find("energy has risen"), std::string::npos) << alarmed.output;
}

TEST(StepLimit, RestartWithAnUnsafeStepNamesTheCheckpointItCameFrom) {
  const Folder folder;
  const std::string scene = "-scene fibre -fibre_segments 20 -pair none";
  const std::string file = " -checkpoint_file c.h5 -checkpoint_interval 1000000";
  auto outcome = run(folder, scene + perturbed + file + " -ts_max_steps 50");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const std::string kept = readFile(folder / "c.h5");
  outcome =
      run(folder, "-restart c.h5 -pair none -ts_dt 55 -ts_dt_unsafe -ts_max_steps 5000" + file);
  ASSERT_EQ(outcome.status, 2) << outcome.output;
  EXPECT_NE(outcome.output.find("unstable at step"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.output.find("the checkpoint c.h5 of step 50 is good"), std::string::npos)
      << outcome.output;
  EXPECT_EQ(readFile(folder / "c.h5"), kept);
  outcome = run(folder, "-restart c.h5 -pair none -ts_max_steps 60" + file);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
}

}  // namespace
}  // namespace nanoweft::test
