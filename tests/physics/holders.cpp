/// Groups that are held, turned and loaded: the motion that is prescribed, and the table of what
/// they do to the fibres (model.md 15).
#include <gtest/gtest.h>

#include <cmath>

#include "support/formulas.hpp"
#include "support/program.hpp"

namespace nanoweft::test {
namespace {

using Table = std::map<std::string, std::vector<double>>;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

Vec3d turned(const Vec3d& v, const Vec3d& axis, double angle) {
  return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
         ((1 - std::cos(angle)) * dot(axis, v)) * axis;
}

std::vector<Vec3d> positionsOf(const std::string& file) {
  const auto x = readDataset(file, "state/position");
  std::vector<Vec3d> positions;
  for (std::size_t i = 0; i < x.size(); i += 3) positions.push_back({x[i], x[i + 1], x[i + 2]});
  return positions;
}

TEST(Holders, ASpunGroupStaysOnItsCirclesAndTurnsAsARigidBody) {
  const Folder folder;
  const Vec3d axis = (1.0 / 3.0) * Vec3d{1, 2, 2}, centre{5, 10, -3}, velocity{3e-4, 0, -2e-4};
  const double spin = -2e-4, dt = 20, steps = 2000, ramp = 8000;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 5 -pair none -progress_interval 0 -ts_dt 20 -ts_max_steps "
          "2000 -bc all -all_region -100,-100,-100,100,100,100 -all_spin -2e-4 -all_axis 1,2,2 "
          "-all_centre 5,10,-3 -all_velocity 3e-4,0,-2e-4 -all_ramp 8000 -state_output out.h5 "
          "-energy_monitor ascii:energy.csv");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const double time = steps * dt - 0.5 * ramp;
  const auto x = positionsOf(folder / "out.h5");
  ASSERT_EQ(x.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    const Vec3d start{static_cast<double>(i) * tube::length, 0, 0};
    const Vec3d expected = centre + time * velocity + turned(start - centre, axis, spin * time);
    EXPECT_LT(norm(x[i] - expected), 1e-9) << i;
  }
  // The segments have turned alike, so nothing is strained.
  const auto energies = readCsv(folder / "energy.csv");
  for (const char* part : {"stretch", "shear", "bending", "torsion"})
    EXPECT_LT(std::abs(energies.at(part).back()), 1e-9) << part;
  // All energy is that of the motion, which the holder brought in.
  EXPECT_NEAR(energies.at("total").back() / energies.at("external").back(), 1, 1e-9);
}

TEST(Holders, ATwistedTubeIsHeldByTheTorqueOfItsTorsion) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 21 -pair none -progress_interval 0 -ts_dt 15 -ts_max_steps "
          "5000 -bc root,tip -root_region -1,-1,-1,1,1,1 -root_fix 1,1,1 -root_fix_rotation "
          "-tip_region 270,-1,-1,272,1,1 -tip_spin 2e-5 -tip_axis 1,0,0 -tip_centre 0,0,0 "
          "-tip_ramp 25000 -group_monitor ascii:g.csv -energy_monitor ascii:e.csv "
          "-monitor_interval 25");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Table g = readCsv(folder / "g.csv"), e = readCsv(folder / "e.csv");
  double ratio = 0, reaction = 0;
  int rows = 0;
  for (std::size_t k = 0; k < g.at("step").size(); ++k) {
    const double angle = 2e-5 * (g.at("time_fs")[k] - 12500);
    const double work = g.at("tip_work")[k] + g.at("root_work")[k];
    EXPECT_NEAR(work, e.at("total")[k], 1e-5 * e.at("total").back());
    EXPECT_NEAR(work, e.at("external")[k], 1e-12 * e.at("total").back());
    EXPECT_LT(std::abs(g.at("tip_force_x")[k]) + std::abs(g.at("tip_displacement_x")[k]), 1e-9);
    if (angle < 0.5) continue;
    // Twenty bonds of B4 sin(angle/20) each.
    ratio += g.at("tip_torque_x")[k] / (tube::B4 * std::sin(angle / 20));
    reaction += g.at("root_torque_x")[k] / g.at("tip_torque_x")[k];
    ++rows;
  }
  ASSERT_GT(rows, 50);
  EXPECT_NEAR(ratio / rows, 1, 2e-3);
  EXPECT_NEAR(reaction / rows, -1, 5e-3);
}

TEST(Holders, TheTorqueOfATwistedRopeIsTheSlopeOfItsEnergy) {
  const Folder folder;
  // Three tubes that touch, about the x axis.
  const double apart = 17.0716, radius = apart / std::sqrt(3.0);
  std::vector<FibreInput> tubes;
  for (int k = 0; k < 3; ++k) {
    const double a = 2 * tube::pi * k / 3;
    tubes.push_back(straightFibre({0, radius * std::cos(a), radius * std::sin(a)}, {1, 0, 0}, 21));
  }
  writeState(folder / "rope.h5", tubes);
  const double spin = 1e-5, ramp = 20000;
  const auto outcome =
      run(folder,
          "-scene file -scene_file rope.h5 -progress_interval 0 -ts_dt 12 -ts_max_steps 6000 "
          "-bc root,tip -root_region -1,-20,-20,1,20,20 -root_fix 1,1,1 -root_fix_rotation "
          "-tip_region 270,-20,-20,272,20,20 -tip_spin " +
              number(spin) + " -tip_ramp " + number(ramp) +
              " -tip_axis 1,0,0 -tip_centre 0,0,0 -group_monitor ascii:g.csv -energy_monitor "
              "ascii:e.csv -monitor_interval 10");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Table g = readCsv(folder / "g.csv"), e = readCsv(folder / "e.csv");
  auto angle = [&](std::size_t k) {
    const double t = g.at("time_fs")[k];
    return spin * (t < ramp ? t * t / (2 * ramp) : t - ramp / 2);
  };
  const auto& total = e.at("total");
  const auto& torque = g.at("tip_torque_x");
  const double gain = total.back() - total.front();
  EXPECT_GT(gain, 10);  // three tubes twisted and bent
  double integral = 0;
  constexpr std::size_t window = 60;
  double windowed = 0;
  int windows = 0;
  for (std::size_t k = 1; k < torque.size(); ++k) {
    const double part = 0.5 * (torque[k] + torque[k - 1]) * (angle(k) - angle(k - 1));
    integral += part;
    windowed += part;
    EXPECT_NEAR(g.at("tip_work")[k] + g.at("root_work")[k], total[k] - total[0], 1e-4 * gain);
    if (k % window) continue;
    // dE/dphi from one window to the next.
    EXPECT_NEAR(windowed, total[k] - total[k - window], 2e-3 * gain) << k;
    windowed = 0;
    ++windows;
  }
  EXPECT_EQ(windows, 10);
  EXPECT_NEAR(integral / gain, 1, 2e-3);
  // A tube on a helix of this angle bends and twists; the rope is stiffer than three tubes apart.
  EXPECT_GT(torque.back(), 3 * tube::GJp / (20 * tube::length) * angle(torque.size() - 1));
}

TEST(Holders, LoadsDoTheWorkThatTheTableSays) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 11 -pair none -progress_interval 0 -ts_dt 10 -ts_max_steps "
          "2000 -bc root,tip,slide -root_region -1,-1,-1,1,1,1 -root_fix 1,1,1 -root_fix_rotation "
          "-tip_region 135,-1,-1,136,1,1 -tip_force 0.2,0,0.01 -tip_torque 0,0,0.3 -tip_ramp 4000 "
          "-slide_region 60,-1,-1,136,1,1 -slide_fix 0,1,0 -group_monitor ascii:g.csv "
          "-energy_monitor ascii:e.csv -monitor_interval 100");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const Table g = readCsv(folder / "g.csv"), e = readCsv(folder / "e.csv");
  EXPECT_NEAR(g.at("tip_force_x").back(), 0.2, 1e-15);
  EXPECT_NEAR(g.at("tip_force_z").back(), 0.01, 1e-15);
  EXPECT_NEAR(g.at("tip_torque_z").back(), 0.3, 1e-15);
  EXPECT_NEAR(g.at("tip_displacement_x").back(), g.at("tip_position_x").back() - 135.6, 1e-9);
  EXPECT_GT(g.at("tip_displacement_z").back(), 0.001);
  for (std::size_t k = 0; k < g.at("step").size(); ++k) {
    EXPECT_NEAR(g.at("tip_work")[k] + g.at("root_work")[k] + g.at("slide_work")[k],
                e.at("external")[k], 1e-12);
    EXPECT_EQ(g.at("root_work")[k], 0);
    EXPECT_EQ(g.at("slide_displacement_y")[k], 0);
  }
  // The couple bends the tube in the plane in which the slide holds it straight.
  EXPECT_NEAR(g.at("slide_torque_z").back(), -0.3, 0.02);
}

TEST(Holders, ALoadOnWhatOthersHoldIsWarnedOfAndDoesNotCount) {
  const Folder folder;
  const std::string options =
      "-scene fibre -fibre_segments 5 -pair none -progress_interval 0 -ts_dt 20 -ts_max_steps 4000 "
      "-monitor_interval 4000 -damping_local 0.5 -group_monitor ascii:g.csv -overwrite "
      "-load_region -1,-1,-1,100,1,1 -load_force 0.1,0,0 -load_torque 0,0,0.5 ";
  for (const int ranks : {1, 3}) {
    const auto outcome = run(folder,
                             options +
                                 "-bc hold,load -hold_region -1,-1,-1,1,1,1 -hold_fix 1,1,1 "
                                 "-hold_fix_rotation",
                             ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("of the 5 segments that load loads, hold holds 1 against"),
              std::string::npos)
        << outcome.output;
    const Table g = readCsv(folder / "g.csv");
    EXPECT_NEAR(g.at("load_force_x").back(), 0.4, 1e-12);
    EXPECT_NEAR(g.at("hold_force_x").back(), -0.4, 1e-9);
    EXPECT_NEAR(g.at("load_torque_z").front(), 2, 1e-12);
    EXPECT_NEAR(g.at("hold_torque_z").back(), -2, 0.05);
  }
  const auto gripped =
      run(folder, options + "-bc load -tension_rate 1e-6 -tension_grip 13.56 -tension_width 10");
  ASSERT_EQ(gripped.status, 0) << gripped.output;
  for (const char* grip : {"lower", "upper"})
    EXPECT_NE(gripped.output.find(std::string("the ") + grip + " grip of the tension test holds 2"),
              std::string::npos)
        << gripped.output;
  EXPECT_NEAR(readCsv(folder / "g.csv").at("load_force_x").front(), 0.1, 1e-12);
  // What is held in another component only is loaded.
  const auto free = run(folder, options +
                                    "-load_torque 0,0,0 -bc slide,load -slide_fix 0,1,0 "
                                    "-slide_region -1,-1,-1,1,1,1");
  EXPECT_EQ(free.output.find("warning: of the"), std::string::npos) << free.output;
  EXPECT_NEAR(readCsv(folder / "g.csv").at("load_force_x").front(), 0.5, 1e-12);
}

TEST(Holders, TorqueIsAboutTheMeanPositionOrTheGivenCentre) {
  const Folder folder;
  const std::string options =
      "-scene fibre -fibre_segments 11 -pair none -progress_interval 0 -ts_max_steps 1 -bc all "
      "-all_region -1,-1,-1,136,1,1 -all_force 0,0,0.01 -group_monitor ascii:g.csv -overwrite ";
  ASSERT_EQ(run(folder, options).status, 0);
  EXPECT_NEAR(readCsv(folder / "g.csv").at("all_torque_y")[0], 0, 1e-12);
  ASSERT_EQ(run(folder, options + "-all_centre 0,0,0").status, 0);
  EXPECT_NEAR(readCsv(folder / "g.csv").at("all_torque_y")[0], -0.01 * 11 * 67.8, 1e-12);
}

TEST(Holders, AGroupIsMeasuredAlongFibresThatFilesHaveWrapped) {
  // A fibre through the boundary of a periodic box, as it runs on, or each segment in the box;
  // outsiders give no images.
  const Folder folder;
  BoxInput box;
  box.lower = {0, 0, -100};
  box.upper = {200, 200, 100};
  box.periodic = {true, true, false};
  const auto fibre = straightFibre({160, 180, 0}, {0.8, 0.6, 0}, 8);
  auto wrapped = fibre;
  for (Vec3d& x : wrapped.position) x.x -= x.x > 200 ? 200 : 0, x.y -= x.y > 200 ? 200 : 0;
  for (const auto& input : {fibre, wrapped})
    for (const int ranks : {1, 3}) {
      writeState(folder / "in.h5", {straightFibre({20, 20, 50}, {1, 0, 0}, 5), input}, box);
      const auto outcome =
          run(folder,
              "-scene file -scene_file in.h5 -pair none -progress_interval 0 -ts_max_steps 1 -bc "
              "all -all_region -1,-1,-10,201,201,10 -all_force 0,0.02,0.01 -group_monitor "
              "ascii:g.csv -overwrite",
              ranks);
      ASSERT_EQ(outcome.status, 0) << outcome.output;
      const auto table = readCsv(folder / "g.csv");
      EXPECT_NEAR(table.at("all_position_x")[0], 160 + 0.8 * 3.5 * 13.56, 1e-9);
      EXPECT_NEAR(table.at("all_position_y")[0], 180 + 0.6 * 3.5 * 13.56, 1e-9);
      EXPECT_NEAR(table.at("all_torque_z")[0], 0, 1e-9);
    }
}

TEST(Holders, ThatContradictEachOtherAreRefused) {
  const Folder folder;
  for (const int ranks : {1, 3}) {
    const auto outcome =
        run(folder,
            "-scene fibre -fibre_segments 11 -pair none -ts_max_steps 1 -bc a,b -a_region "
            "-1,-1,-1,60,1,1 -a_velocity 1e-4,0,0 -b_region 50,-1,-1,136,1,1 -b_fix 1,0,0",
            ranks);
    EXPECT_EQ(outcome.status, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("hold the x velocity of 1 segment in different ways"),
              std::string::npos)
        << outcome.output;
  }
}

}  // namespace
}  // namespace nanoweft::test
