/// Walls (model.md 20): contact, motion, forces and friction.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::gigapascal;
using tube::pi;
constexpr double T = tube::length, rf = tube::rf;

const std::string fromFile = "-scene file -scene_file in.h5 -pair none -progress_interval 0 ";
const std::string floorWall =
    "-walls floor -floor_point 0,0,0 -floor_axis 0,0,1 -floor_modulus 20 ";

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

TEST(Walls, AFibrePressedOnAFloorSinksInByHertzLine) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, rf}, {1, 0, 0}, 10)});
  const double press = 0.01;
  const auto outcome = run(
      folder, fromFile + floorWall +
                  "-bc all -all_region -1000,-10,-10,1000,10,20 -all_force 0,0," + number(-press) +
                  " -damping_local 0.5 -ts_dt 10 -ts_max_steps 10000 -state_output out.h5 "
                  "-wall_monitor ascii:walls.csv -monitor_interval 1000");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const double overlap = press / (pi / 4 * 20 * gigapascal * T);
  for (const Vec3d& x : readVectors(folder / "out.h5", "/state/position"))
    EXPECT_NEAR(x.z, rf - overlap, 1e-8);
  const auto walls = readCsv(folder / "walls.csv");
  EXPECT_NEAR(walls.at("floor_force_z").back(), -10 * press, 1e-8);
  // About the floor's point, which lies below the first centre.
  EXPECT_NEAR(walls.at("floor_torque_y").back(), 10 * press * 4.5 * T, 1e-6);
}

/// Energies while a wall that moves upwards meets a fibre above it.
std::map<std::string, std::vector<double>> collide(const std::string& wall, double dt,
                                                   double height) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({-4.3 * T, 0, height}, {1, 0, 0}, 10)});
  const auto outcome =
      run(folder, fromFile + "-walls w -w_modulus 20 " + wall + " -ts_dt " + number(dt) +
                      " -ts_max_time 12000 -energy_monitor ascii:e.csv "
                      "-monitor_interval 10");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return readCsv(folder / "e.csv");
}

TEST(Walls, MovingOnesPutInWhatTheFibresGain) {
  const struct {
    std::string wall;
    double height;
  } cases[] = {
      {"-w_point 0,0,0 -w_axis 0,0,1", rf + 0.2},
      {"-w_shape cylinder -w_radius 40 -w_point 0,0,-40 -w_axis 0,1,0", rf + 0.2},
      {"-w_shape sphere -w_radius 30 -w_point 0,0,-30", rf + 0.2},
      {"-w_shape cylinder -w_inside -w_radius 200 -w_point 0,0,200 -w_axis 1,0,0", rf + 0.2}};
  for (const auto& c : cases) {
    double drift[2];
    for (int k = 0; k < 2; ++k) {
      const auto e = collide("-w_velocity 0,0,3e-4 " + c.wall, k == 0 ? 16 : 8, c.height);
      EXPECT_GT(*std::ranges::max_element(e.at("walls")), 1e-4) << c.wall << ": it was not met";
      EXPECT_GT(e.at("external").back(), 1e-3);
      drift[k] = 0;
      for (std::size_t n = 0; n < e.at("total").size(); ++n)
        drift[k] = std::max(
            drift[k], std::abs(e.at("total")[n] - e.at("external")[n]) / e.at("external").back());
    }
    EXPECT_LT(drift[0], 0.06) << c.wall;
    EXPECT_NEAR(std::log2(drift[0] / drift[1]), 2.0, 0.3) << c.wall;
  }
}

TEST(Walls, DrivenOnesKeepTheEnergyBalanceToSecondOrder) {
  const std::string driven = "-w_point 0,0,0 -w_axis 0,0,1 -w_mass 2e4 -w_force ";
  auto worst = [&](const std::string& more, double dt) {
    const auto e = collide(driven + more, dt, rf + 0.05);
    EXPECT_GT(e.at("kinetic").back(), 1e-3) << "the fibre was not met";
    double largest = 0;
    for (std::size_t n = 0; n < e.at("total").size(); ++n) {
      const double out = e.count("friction") ? e.at("damped")[n] + e.at("friction")[n] : 0.0;
      largest = std::max(largest, std::abs(e.at("total")[n] + out - e.at("external")[n]));
    }
    return largest / e.at("external").back();
  };
  // The second is drawn along the fibre too, by friction.
  for (const char* more : {"0,0,0.05", "0.05,0,0.05 -w_friction 0.3 -w_restitution 0.5"}) {
    const std::string pushed = std::string(more) + " -w_ramp 4000";
    const double coarse = worst(pushed, 16), fine = worst(pushed, 2);
    EXPECT_LT(coarse, 1e-4) << more;
    EXPECT_NEAR(std::log2(coarse / fine) / 3, 2.0, 0.3) << more;
  }
}

TEST(Walls, APlateThatAForceDrivesRestsWhereTheFibresBearIt) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, rf}, {1, 0, 0}, 10)});
  const auto outcome =
      run(folder, fromFile +
                      "-walls floor,lid -floor_point 0,0,0 -floor_axis 0,0,1 -floor_modulus 20 "
                      "-lid_point 0,0,13.7 -lid_axis 0,0,-1 -lid_modulus 20 -lid_force 0,0,-0.2 "
                      "-lid_mass 20000 -lid_drag 2000 -damping_local 0.3 -ts_dt 10 -ts_max_steps "
                      "20000 -wall_monitor ascii:w.csv -monitor_interval 5000 -state_output o.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto walls = readCsv(folder / "w.csv");
  EXPECT_NEAR(walls.at("lid_force_z").back(), 0.2, 1e-4);
  EXPECT_NEAR(walls.at("floor_force_z").back(), -0.2, 1e-4);
  const double overlap = 0.02 / (pi / 4 * 20 * gigapascal * T);
  EXPECT_NEAR(walls.at("lid_way_z").back(), 2 * rf - 2 * overlap - 13.7, 1e-3);
}

/// A limp fibre over a fixed rod by half a turn, drawn by 1 at one end and by `pull` at the other.
/// Returns how fast the drawn end goes at last.
double speedOver(double pull, double R) {
  const Folder folder;
  const double r = R + rf - 0.02, straight = 14 * T, half = pi * r;
  FibreInput fibre;
  for (int k = 0; (k + 0.5) * T < 2 * straight + half; ++k) {
    const double s = (k + 0.5) * T - straight, turned = std::clamp(s / r, 0.0, pi);
    const Vec3d along{std::cos(turned), -std::sin(turned), 0};
    const double beyond = s < 0 ? s : std::max(0.0, s - half);
    fibre.position.push_back(r * Vec3d{std::sin(turned), std::cos(turned), 0} + beyond * along);
    fibre.orientation.push_back(rotation(Vec3d{0, 0, -turned}));
  }
  writeState(folder / "in.h5", {fibre});
  std::vector<double> group(fibre.position.size(), 0);
  group.front() = 1;
  group.back() = 2;
  setDataset(folder / "in.h5", "group", group, 1);
  const auto outcome =
      run(folder, fromFile +
                      "-start_unchecked -fibre_bond_stiffness 60,20,-4,1.5 -walls rod -rod_shape "
                      "cylinder -rod_point 0,0,0 -rod_axis 0,0,1 -rod_modulus 50 -rod_friction 0.3 "
                      "-rod_restitution 0.5 -bc a,b -a_group 0 -a_force -1,0,0 -a_ramp 200000 "
                      "-b_group 1 -b_ramp 200000 -damping_local 0.5 -ts_dt 10 -ts_max_steps 60000 "
                      "-state_output out.h5 -rod_radius " +
                      number(R) + " -b_force " + number(-pull) + ",0,0");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return norm(readVectors(folder / "out.h5", "/state/velocity").back());
}

TEST(Walls, AFibreOverARodHoldsToTheCapstanEquationWithinOnePercent) {
  // Friction acts at the rod's surface, tension at the fibre's axis.
  const double R = 150, most = std::exp(0.3 * pi * R / (R + rf));
  EXPECT_LT(speedOver(0.99 * most, R), 1e-6);
  EXPECT_GT(speedOver(1.01 * most, R), 2e-6);
}

TEST(Walls, ATurningFloorDragsWhatSlidesOnItByItsFriction) {
  const Folder folder;
  const double press = 0.01, time = 1e4;
  const double overlap = press / (pi / 4 * 20 * gigapascal * T);
  writeState(folder / "in.h5", {straightFibre({100, 0, rf - overlap}, {1, 0, 0}, 1)});
  const auto outcome =
      run(folder, fromFile + floorWall +
                      "-floor_friction 0.3 -floor_restitution 0.3 -floor_spin 1e-5 -bc all "
                      "-all_region 90,-10,-10,110,10,20 -all_fix_rotation -all_force 0,0," +
                      number(-press) + " -ts_dt 10 -ts_max_time 10000 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // It is far slower than the floor, 1e-3 A/fs, and so slides all the time.
  EXPECT_NEAR(
      readVectors(folder / "out.h5", "/state/velocity")[0].y / (0.3 * press / tube::mass * time),
      1.0, 0.02);
}

TEST(Walls, WhatIsThrownAtThemReboundsByTheirRestitution) {
  for (const double restitution : {1.0, 0.5, 0.2}) {
    const Folder folder;
    const double speed = 1e-4;
    writeState(folder / "in.h5", {straightFibre({0, 0, rf + 0.05}, {1, 0, 0}, 1)});
    setMotion(
        folder / "in.h5",
        [&](std::size_t, const Vec3d&) {
          return Vec3d{0, 0, -speed};
        },
        [](std::size_t, const Vec3d&) { return Vec3d{}; });
    const auto outcome =
        run(folder, fromFile + floorWall + "-floor_restitution " + number(restitution) +
                        " -ts_dt 1 -ts_max_time 6000 -state_output out.h5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    // The overlap d and its rate, in steps far finer: the dashpot for this restitution pulls by no
    // more than the load, and pushes by no more.
    const double k = pi / 4 * 20 * gigapascal * T, h = 0.01,
                 part = restitution < 1
                            ? -std::log(restitution) / std::hypot(pi, std::log(restitution))
                            : 0.0,
                 viscosity = 2 * part * std::sqrt(k * tube::mass);
    double d = 0, rate = speed;
    do {
      const double load = k * d;
      rate -= h / tube::mass * (load + std::clamp(viscosity * rate, -load, load));
      d += h * rate;
    } while (d > 0);
    const Vec3d now = readVectors(folder / "out.h5", "/state/velocity")[0];
    EXPECT_NEAR(now.z / -rate, 1.0, 0.01) << restitution;
    EXPECT_LT(std::abs(now.x) + std::abs(now.y), 1e-12);
    EXPECT_LT(-rate, restitution < 1 ? 0.99 * speed : 1.01 * speed);
  }
}

TEST(Walls, TheirMotionEndsWhenItIsSaid) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, 50}, {1, 0, 0}, 2)});
  auto outcome = run(folder, fromFile +
                                 "-walls w -w_point 0,0,0 -w_axis 0,0,1 -w_modulus 20 -w_velocity "
                                 "0,0,3e-4 -w_ramp 1000 -w_stop 4000 -ts_dt 10 -ts_max_time 8000 "
                                 "-wall_monitor ascii:w.csv -monitor_interval 100");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto table = readCsv(folder / "w.csv");
  for (std::size_t k = 0; k < table.at("step").size(); ++k) {
    const double time = 10 * table.at("step")[k], moving = std::min(time, 4000.0);
    const double way = 3e-4 * (moving < 1000 ? moving * moving / 2000 : moving - 500);
    EXPECT_NEAR(table.at("w_way_z")[k], way, 1e-12) << time;
  }
  // A floor that turns drags what lies on it along, and holds it up once it has stopped.
  const double overlap = 0.01 / (pi / 4 * 20 * gigapascal * T);
  writeState(folder / "in.h5", {straightFibre({100, 0, rf - overlap}, {1, 0, 0}, 1)});
  auto speedAt = [&](const std::string& time) {
    outcome = run(folder, fromFile + floorWall +
                              "-floor_friction 0.3 -floor_restitution 0.3 -floor_spin 1e-5 "
                              "-floor_stop 5000 -bc all -all_region 90,-10,-10,110,10,20 "
                              "-all_fix_rotation -all_force 0,0,-0.01 -ts_dt 10 -state_output "
                              "out.h5 -overwrite -ts_max_time " +
                              time);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return readVectors(folder / "out.h5", "/state/velocity")[0].y;
  };
  const double most = 0.3 * 0.01 / tube::mass * 5000;
  EXPECT_NEAR(speedAt("5000") / most, 1.0, 0.02);
  EXPECT_NEAR(speedAt("7500") / most, 0.5, 0.02);
}

TEST(Walls, ANewStageForgetsHowItsFibresClungToWalls) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, rf}, {1, 0, 0}, 2)});
  const std::string rough = floorWall +
                            "-floor_friction 0.5 -floor_restitution 0.3 -bc all -all_region "
                            "-100,-100,-100,100,100,100 -all_fix_rotation "
                            "-wall_monitor ascii:w.csv -overwrite -ts_dt 10 ";
  auto outcome = run(folder, fromFile + rough +
                                 "-damping_local 0.3 -all_force 0,0.02,-0.1 -ts_max_steps 20000 "
                                 "-monitor_interval 1000 -state_output rest.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NEAR(readCsv(folder / "w.csv").at("floor_force_y").back(), 0.04, 1e-5);
  stopMotion(folder / "rest.h5");
  outcome = run(folder, "-scene file -scene_file rest.h5 -pair none " + rough +
                            "-all_force 0,0,-0.1 -ts_max_steps 1 -monitor_interval 1");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto table = readCsv(folder / "w.csv");
  EXPECT_NEAR(table.at("floor_force_z").back(), -0.2, 1e-4);
  EXPECT_NEAR(table.at("floor_force_y").back(), 0, 1e-6);
}

TEST(Walls, FibresInsideThemAreRefusedAndDeepContactsWarnOnce) {
  const Folder folder;
  for (const int ranks : {1, 3}) {
    writeState(folder / "in.h5",
               {straightFibre({0, 0, 9}, {1, 0, 0}, 6), straightFibre({0, 30, -1}, {1, 0, 0}, 6)});
    expectRefused(run(folder, fromFile + floorWall + "-ts_max_steps 10", ranks),
                  {"fibre 1 segment 0", "wall floor", "-start_unchecked"});
    writeState(folder / "in.h5", {straightFibre({0, 0, 9}, {1, 0, 0}, 6),
                                  straightFibre({0, 30, 0.5 * rf}, {1, 0, 0}, 6)});
    const auto outcome = run(folder, fromFile + floorWall + "-ts_max_steps 300 -ts_dt 5", ranks);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    const std::string words = "fibre 1 segment 0 is 50 % of a radius deep in the wall floor";
    const auto first = outcome.output.find(words);
    EXPECT_NE(first, std::string::npos) << outcome.output;
    EXPECT_EQ(outcome.output.find("deep in the wall", first + words.size()), std::string::npos);
    EXPECT_NE(outcome.output.find("wall floor: plane through 0,0,0"), std::string::npos);
  }
  // A standing fibre whose lowest centre is less deep than its radius, and whose tip is deeper.
  writeState(folder / "in.h5", {straightFibre({0, 0, 3}, {0, 0, 1}, 6)});
  expectRefused(run(folder, fromFile + floorWall + "-ts_max_steps 10"),
                {"fibre 0 segment 0 is 1.3", "wall floor"});
}

TEST(Walls, ThatAreThinnerThanPointsLieApartAreWarnedOf) {
  const Folder folder;
  for (const auto& [length, warned] : {std::pair{"13.56", false}, std::pair{"135.6", true}}) {
    const auto outcome = run(
        folder, std::string("-scene fibre -fibre_segments 6 -pair none -ts_max_steps 0 -walls rod "
                            "-rod_shape cylinder -rod_axis 0,1,0 -rod_point 0,0,-20 -rod_radius 9 "
                            "-rod_modulus 20 -fibre_segment_length ") +
                    length);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(outcome.output.find("too coarse for a wall") != std::string::npos, warned)
        << outcome.output;
  }
}

TEST(Walls, FrictionThatHoldsAFibreIsPartOfItsEquilibrium) {
  // Pressed down and drawn aside by less than friction bears: at rest, and the run ends so.
  const Folder folder;
  const auto outcome = run(
      folder,
      "-scene fibre -fibre_segments 3 -pair none -walls floor -floor_point 0,0,-6.7 -floor_axis "
      "0,0,1 -floor_modulus 10 -floor_friction 0.5 -floor_restitution 0.5 -bc all -all_region "
      "-100,-100,-100,100,100,100 -all_fix_rotation -all_force 0,0.02,-0.1 -damping_local 0.3 "
      "-ts_dt 10 "
      "-relax_force 1e-4 -ts_max_steps 200000");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("converged: no force"), std::string::npos) << outcome.output;
}

TEST(Walls, ThatCannotBeMeantAreRefused) {
  const Folder folder;
  const std::string fibre = "-scene fibre -fibre_segments 5 -pair none -ts_max_steps 1 ";
  const struct {
    std::string options;
    std::vector<std::string> says;
  } cases[] = {
      {"-walls w", {"-w_point"}},
      {"-walls w -w_point 0,0,0", {"-w_axis"}},
      {"-walls w -w_point 0,0,0 -w_axis 0,0,0", {"-w_axis"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1", {"-w_modulus"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_radius 3", {"-w_radius"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_inside", {"-w_inside"}},
      {"-walls w -w_point 0,0,-90 -w_shape sphere -w_modulus 10", {"-w_radius"}},
      {"-walls w -w_point 0,0,-90 -w_shape sphere -w_radius 9 -w_modulus 10 -w_friction 1 -w_spin "
       "1e-5",
       {"-walls w", "-w_axis"}},
      {"-walls w -w_point 0,0,-90 -w_shape sphere -w_radius 9 -w_modulus 10 -w_axis 0,0,1",
       {"-w_axis", "does not turn"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_spin 1e-5",
       {"-w_spin", "-w_friction"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_force 0,0,1", {"-w_mass"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_friction -1", {"-w_friction"}},
      {"-walls w,w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10", {"-walls", "twice"}},
      {"-walls dm -dm_point 0,0,-20 -dm_axis 0,0,1 -dm_modulus 10", {"-walls", "PETSc"}},
      {"-walls w -w_shape sphere -w_radius 3 -w_point 0,0,-90 -w_modulus 10 -bc w -w_region "
       "-1,-1,-1,1,1,1 -w_force 0,0,1 -w_mass 3",
       {"-walls w", "-bc"}},
      {"-wall_monitor ascii:w.csv", {"-wall_monitor", "-walls"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_velocity 0,0,1 -relax_method fire",
       {"wall w"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_drag 1", {"-w_drag", "-w_force"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_force 0,0,1 -w_mass 9 -w_stop 5",
       {"-w_stop", "not used"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_ramp 5", {"-w_ramp", "still"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_force 0,0,1 -w_mass 9 -w_drag 1e9",
       {"-ts_dt", "-w_drag"}},
      {"-walls w -w_point 0,0,-20 -w_axis 0,0,1 -w_modulus 10 -w_velocity 0,0,1e-5 -relax_force 1",
       {"-relax_force", "wall w"}},
      {"-domain_periodic 0,0,1 -domain_lower -90,-90,-90 -domain_upper 90,90,90 -walls w -w_point "
       "0,0,-20 -w_axis 0,0,1 -w_modulus 10",
       {"-walls w", "periodic along z"}},
      {"-domain_periodic 0,0,1 -domain_lower -90,-90,-90 -domain_upper 90,90,90 -walls w -w_point "
       "0,60,0 -w_axis 0,1,1 -w_shape cylinder -w_radius 9 -w_modulus 10",
       {"-walls w", "periodic along z", "axis"}},
      {"-domain_periodic 0,0,1 -domain_lower -90,-90,-90 -domain_upper 90,90,90 -walls w -w_point "
       "0,0,0 -w_inside -w_shape sphere -w_radius 95 -w_modulus 10",
       {"-w_radius 95", "periodic along z", "half"}}};
  for (const auto& c : cases) expectRefused(run(folder, fibre + c.options), c.says);
}

}  // namespace
}  // namespace nanoweft::test
