/// Relaxation by FIRE: the algorithm against a second implementation, and rest where it is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nanoweft/base/hdf5.hpp"
#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"

namespace nanoweft::test {
namespace {

using namespace tube;

/// Largest force, or torque over segment length, of /state/force and torque from row `first` on.
double largestForce(const std::string& file, std::size_t first = 0) {
  const auto force = readDataset(file, "/state/force"), torque = readDataset(file, "/state/torque");
  double largest = 0;
  for (std::size_t k = 3 * first; k + 3 <= force.size(); k += 3)
    largest = std::max({largest, std::hypot(force[k], force[k + 1], force[k + 2]),
                        std::hypot(torque[k], torque[k + 1], torque[k + 2]) / length});
  return largest;
}

TEST(Fire, StretchAndTwistOfOneBondStepByStep) {
  // Two segments part by 2u and turn by 2p about their axis: U = B1/2 (2u)^2 - B4 (cos 2p - 1).
  constexpr double longest = 20;
  double u = 0.005 * length, p = 0.4, v = 0, w = 0, dt = 0.25 * longest, mixing = 0.1;
  double time = 0, damped = 0;
  int downhill = 0, uphill = 0;
  auto force = [&] { return -2 * B1 * u; };
  auto torque = [&] { return -B4 * std::sin(2 * p); };
  auto motion = [&] { return mass * v * v + inertia * w * w; };  // of both segments

  const Folder folder;
  const auto outcome = run(folder,
                           "-scene fibre -fibre_segments 2 -fibre_strain 0.01 -fibre_twist 0.8 "
                           "-pair none -relax_method fire -ts_dt 20 -ts_max_steps 100 "
                           "-energy_monitor ascii:energy.csv -monitor_interval 1");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto csv = readCsv(folder / "energy.csv");
  ASSERT_EQ(csv.at("step").size(), 101u);
  const double scale = csv.at("total").front();
  EXPECT_NEAR(scale, 2 * B1 * u * u + B4 * (1 - std::cos(2 * p)), 1e-6 * scale);
  for (std::size_t k = 1; k <= 100; ++k) {
    v += 0.5 * dt / mass * force(), w += 0.5 * dt / inertia * torque();
    u += dt * v, p += dt * w, time += dt;
    v += 0.5 * dt / mass * force(), w += 0.5 * dt / inertia * torque();
    const double before = motion();
    if (force() * v + torque() * w >= 0) {
      const double ratio =
          std::sqrt(motion() / (force() * force() / mass + torque() * torque() / inertia));
      v = (1 - mixing) * v + mixing * ratio * force() / mass;
      w = (1 - mixing) * w + mixing * ratio * torque() / inertia;
      if (++downhill > 5) dt = std::min(1.1 * dt, longest), mixing *= 0.99;
    } else {
      v = w = 0, downhill = 0, mixing = 0.1, ++uphill;
      dt = std::max(0.5 * dt, 0.02 * longest);
    }
    damped += before - motion();
    // Round-off of both, grown over 100 steps; the parameters' own digits agree to 1e-9.
    EXPECT_NEAR(csv.at("time_fs")[k], time, 1e-9 * time) << k;
    EXPECT_NEAR(csv.at("stretch")[k], 2 * B1 * u * u, 1e-7 * scale) << k;
    EXPECT_NEAR(csv.at("torsion")[k], B4 * (1 - std::cos(2 * p)), 1e-7 * scale) << k;
    EXPECT_NEAR(csv.at("kinetic")[k], mass * v * v, 1e-7 * scale) << k;
    EXPECT_NEAR(csv.at("rotational")[k], inertia * w * w, 1e-7 * scale) << k;
    EXPECT_NEAR(csv.at("damped")[k], damped, 1e-7 * scale) << k;
  }
  EXPECT_GE(uphill, 2);
}

TEST(Fire, BentFibreBecomesStraight) {
  const double tolerance = 1e-7;
  const int segments = 40;
  const std::string scene =
      "-scene fibre -fibre_segments 40 -fibre_bend 1.5 -fibre_twist 1 -fibre_strain 0.01 -pair "
      "none "
      "-ts_max_steps 100000 -relax_force 1e-7 -state_output out.h5 -state_forces ";
  // What is left in a mode of frequency W is g^2/(2 W^2), g^2 = F^2/m + t^2/I with |F| and |t|/T
  // below the tolerance; no mode lies below the first bending of a free beam of at most L = n T.
  const double modes = std::pow(4.730041 / (segments * length), 4) * EJ * length;  // m W^2
  const double left =
      segments * tolerance * tolerance * (1 + mass * length * length / inertia) / (2 * modes);
  for (const char* method : {"-relax_method fire", "-damping_local 0.1"}) {
    const Folder folder;
    const auto outcome = run(folder, scene + method + " -energy_monitor ascii:energy.csv");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("converged: no force"), std::string::npos) << outcome.output;
    EXPECT_LE(largestForce(folder / "out.h5"), tolerance);
    const auto csv = readCsv(folder / "energy.csv");
    EXPECT_LT(csv.at("step").back(), 100000);
    double elastic = 0;
    for (const char* part : {"stretch", "shear", "bending", "torsion"})
      elastic += csv.at(part).back();
    EXPECT_LE(elastic, left);
  }
}

TEST(Fire, CantileverUnderItsLoad) {
  // Held at the first of 21 segments; 1e-3 eV/A at the tip.
  const Folder folder;
  const double load = 1e-3, tolerance = 1e-9, L = 20 * length;
  const auto outcome = run(
      folder,
      "-scene fibre -fibre_segments 21 -pair none -relax_method fire -relax_force 1e-9 "
      "-ts_max_steps 100000 -bc root,tip -root_region -1,-1,-1,1,1,1 -root_fix 1,1,1 "
      "-root_fix_rotation -tip_region 270,-1,-1,272,1,1 -tip_force 0,0,1e-3 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("converged: no force"), std::string::npos) << outcome.output;
  const auto x = readDataset(folder / "out.h5", "/state/position"),
             q = readDataset(folder / "out.h5", "/state/orientation");
  for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(x[c], 0.0);
  EXPECT_EQ(q[0], 1.0);
  const double deflection = load * L * L * L / (3 * EJ), tip = x[3 * 20 + 2];
  // Forces and torques left on all nodes act at the tip at worst; large deflections add the
  // square of the slope.
  const double slope = load * L * L / (2 * EJ);
  const double left = 20 * tolerance / load * (1 + 1.5 * length / L) + slope * slope;
  EXPECT_NEAR(tip, deflection, left * deflection);
}

TEST(Fire, TwoEndlessTubesFindTheirDistance) {
  const int n = 20;
  const Folder folder;
  BoxInput box;
  box.lower = {0, -200, -200}, box.upper = {n * length, 200, 200}, box.periodic[0] = true;
  auto first = straightFibre({0, 0, 0}, {1, 0, 0}, n), second = first;
  for (Vec3d& x : second.position) x += Vec3d{3, 20, 0};
  first.closed = second.closed = true;
  writeState(folder / "in.h5", {first, second}, box);
  const double tolerance = 1e-6;
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const auto outcome =
        run(folder,
            std::string(
                "-scene file -scene_file in.h5 -pair_points 3 -relax_method fire -relax_force 1e-6 "
                "-ts_max_steps 20000 -overwrite -state_output out.h5 -energy_monitor "
                "ascii:energy.csv -ts_dt ") +
                (k == 0 ? "10" : "5"));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("converged: no force"), std::string::npos) << outcome.output;
    const auto x = readDataset(folder / "out.h5", "/state/position");
    const double slide = x[3 * n] - x[0], distance = std::hypot(x[3 * n + 1] - x[1], x[3 * n + 2]);
    // Force between the tubes for each segment, and how it changes with their distance.
    auto force = [&](double d) {
      double sum = 0;
      for (int i = -6; i <= 6; ++i)
        sum += pair({0, 0, 0}, {1, 0, 0, 0}, {slide + i * length, d, 0}, {1, 0, 0, 0}).forceJ.y;
      return sum;
    };
    const double stiffness = (force(distance - 1e-4) - force(distance + 1e-4)) / 2e-4;
    EXPECT_GT(stiffness, 1.0);
    EXPECT_LE(std::abs(force(distance)), 2 * tolerance);  // the table agrees to 1e-11
    EXPECT_NEAR(distance, 17.07, 0.05);                   // endless tubes without points: 17.0716
    const auto csv = readCsv(folder / "energy.csv");
    errors[k] = csv.at("total").back() + csv.at("damped").back() - csv.at("total").front();
  }
  // What FIRE takes out is counted exactly, so the balance has Verlet's error alone.
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.35);
}

TEST(Fire, AFibreThatFallsFarComesToRestOnOthers) {
  // The loads of 0.5 eV/A on each of ten segments are at work over 8000 A.
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({-70, -40, 0}, {1, 0, 0}, 11),
                                straightFibre({-70, 40, 0}, {1, 0, 0}, 11),
                                straightFibre({0, -61, 8000}, {0, 1, 0}, 10)});
  const std::string options =
      "-scene file -scene_file in.h5 -pair contact -contact_modulus 20 -relax_method fire "
      "-relax_force 1e-6 -ts_max_steps 30000 -overwrite -group_monitor ascii:groups.csv "
      "-bc hold,load -hold_region -99,-99,-9,99,99,9 -hold_fix 1,1,1 -hold_fix_rotation "
      "-load_region -99,-99,7000,99,99,9000 -load_fix 1,1,0 -load_force 0,0,-0.5";
  const auto braked = run(folder, options);
  ASSERT_EQ(braked.status, 0) << braked.output;
  EXPECT_NE(braked.output.find("converged: no force"), std::string::npos) << braked.output;
  EXPECT_NEAR(readCsv(folder / "groups.csv").at("hold_force_z").back(), 5.0, 1e-4);
  // Without a limit it would be too fast to be stopped.
  const auto free = run(folder, options + " -fire_max_move 1000");
  EXPECT_NE(free.status, 0);
  EXPECT_NE(free.output.find("unstable at step"), std::string::npos) << free.output;
}

TEST(Relaxation, WaitsForALoadThatGrows) {
  // A straight fibre is at rest until the load at its tip has grown.
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 11 -pair none -relax_method fire -relax_force 1e-6 "
          "-ts_max_steps 100000 -bc root,tip -root_region -1,-1,-1,1,1,1 -root_fix 1,1,1 "
          "-root_fix_rotation -tip_region 135,-1,-1,136,1,1 -tip_force 0,0.01,0 -tip_ramp 2000 "
          "-state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // F L^3/(3 EJ) with EJ = 22350 eV A, and a little shear.
  const double L = 10 * 13.56;
  EXPECT_NEAR(
      readDataset(folder / "out.h5", "/state/position")[31] / (0.01 * L * L * L / (3 * 22350)), 1,
      0.03);
}

TEST(Relaxation, DoesNotConvergeWhileALoadGrowsOrAWallIsOnItsWay) {
  const Folder folder;
  auto expectConverged = [&](const std::string& options, int least) {
    const auto outcome = run(folder, "-ts_max_steps 20000 -ts_dt 20 -overwrite " + options);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("converged"), std::string::npos) << outcome.output;
    const auto at = outcome.output.find("\nsteps ");
    ASSERT_NE(at, std::string::npos) << outcome.output;
    int steps = 0;
    std::sscanf(outcome.output.c_str() + at, "\nsteps %d", &steps);
    EXPECT_GT(steps, least) << outcome.output;
    EXPECT_LT(steps, 20000) << outcome.output;
  };
  // The load has grown after 8000 steps.
  expectConverged(
      "-scene fibre -fibre_segments 30 -bc root,tip -root_region -1,-1,-1,1,1,1 -root_fix 1,1,1 "
      "-root_fix_rotation -tip_region 390,-1,-1,400,1,1 -tip_force 0,0,0.005 -damping_local 0.2 "
      "-tip_ramp 160000 -relax_tolerance 0.1 -relax_interval 100",
      7999);
  // The wall that comes to a stretched fibre stops after 1000.
  expectConverged(
      "-scene fibre -fibre_segments 10 -fibre_strain 0.01 -bc all -all_region "
      "-1000,-9,-9,1000,9,9 -all_fix 1,1,0 -damping_local 0.3 -walls w -w_point 0,0,-25 -w_axis "
      "0,0,1 -w_velocity 0,0,0.001 -w_stop 20000 -w_modulus 20 -relax_tolerance 1e-3 "
      "-relax_interval 100",
      999);
}

TEST(Relaxation, DoesNotConvergeWhileTheBoxIsOnItsWay) {
  const Folder folder;
  const std::string options =
      "-scene weave -weave_periodic -weave_fibres 4,4 -weave_segments 24 -damping_local 0.3 "
      "-deform_thickness 17.1 -ts_dt 20 -relax_interval 100 -relax_tolerance 0.2 -overwrite "
      "-box_monitor ascii:b.csv -monitor_interval 100 -progress_interval 0 -ts_max_steps 20000 ";
  // A servo that is slow beside the interval, and a strain that is reached after 2500 steps.
  for (const std::string& drive :
       {std::string("-deform_x stress -deform_x_stress 5 -deform_y free -deform_modulus 1000"),
        std::string("-deform_x rate -deform_x_rate 1e-7 -deform_x_until 0.005"),
        std::string("-deform_x program -deform_x_program 0.005,1e-7")}) {
    const auto outcome = run(folder, options + drive);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("converged"), std::string::npos) << outcome.output;
    const auto table = readCsv(folder / "b.csv");
    if (drive.find("stress") != std::string::npos)
      EXPECT_NEAR(table.at("xx_GPa").back(), 5, 0.2) << outcome.output;
    else
      EXPECT_NEAR(table.at("strain_x").back(), 0.005, 1e-9) << outcome.output;
  }
}

TEST(Relaxation, DoesNotConvergeUnderAPlateThatHasYetToLand) {
  // Nothing has happened to the fibre in the 2000 steps before the plate touches it.
  const Folder folder;
  const std::string plate =
      "-scene fibre -fibre_segments 10 -pair none -damping_local 0.3 -ts_dt 20 -ts_max_steps 4000 "
      "-relax_tolerance 1e-3 -relax_interval 100 -bc all -all_region -1000,-9,-9,1000,9,9 -all_fix "
      "1,1,0 -walls top -top_point 0,0,60 -top_axis 0,0,-1 -top_modulus 10 ";
  // The second is bent a little, and so has energy beside which the plate's is nothing.
  for (const char* start : {"", "-fibre_shape arc -fibre_bend 0.3 -all_fix_rotation "}) {
    const auto outcome = run(folder, plate + start + "-top_force 0,0,-1e-4 -top_mass 1e5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("\nconverged"), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find("\nnot converged"), std::string::npos) << outcome.output;
  }
}

TEST(Relaxation, AnEnergyThatIsTooOldIsNotComparedWith) {
  // A stretch without -relax_tolerance goes past a step at which it would have looked.
  const Folder folder;
  auto kept = [&](const std::string& what) {
    expectDone(run(folder, what + " -checkpoint_file c.h5"));
    const h5::Handle file(H5Fopen((folder / "c.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT),
                          H5Fclose),
        record(H5Gopen2(file, "/run", H5P_DEFAULT), H5Gclose);
    return h5::readReals(record, "relax_elastic").value().at(0);
  };
  EXPECT_GT(kept("-scene fibre -fibre_segments 6 -fibre_bend 1 -pair none "
                 "-relax_tolerance 1e-12 -ts_max_steps 6000"),
            0);
  EXPECT_GT(kept("-restart c.h5 -ts_max_steps 9000"), 0);
  EXPECT_EQ(kept("-restart c.h5 -ts_max_steps 11000"), -1);
}

TEST(Relaxation, ADrivenBoxCannotBeGivenAnEndAtRestByARestart) {
  const Folder folder;
  expectDone(run(folder,
                 "-scene weave -weave_fibres 4,4 -weave_segments 40 -weave_periodic "
                 "-deform_x free -deform_thickness 17 -damping_local 0.4 -ts_max_steps 20 "
                 "-checkpoint_file c.h5"));
  expectRefused(run(folder, "-restart c.h5 -relax_force 100 -ts_max_steps 50"),
                {"-relax_force", "box that is driven"});
}

}  // namespace
}  // namespace nanoweft::test
