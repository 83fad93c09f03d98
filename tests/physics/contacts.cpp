/// Contacts with friction in motion (model.md 18, 19).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

constexpr double T = tube::length;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

/// A bar of 12 segments across two fixed rods, as deep as it rests, pressed on them by `press` a
/// segment.
class Bar {
 public:
  Bar() {
    std::vector<FibreInput> fibres{straightFibre({2.3 * T, -3 * T, 0}, {0, 1, 0}, 7),
                                   straightFibre({8.7 * T, -3 * T, 0}, {0, 1, 0}, 7),
                                   straightFibre({0, 0, 2 * tube::rf - 0.0915}, {1, 0, 0}, 12)};
    writeState(folder_ / "in.h5", fibres);
    std::vector<double> group(14, 1);
    group.resize(26, 2);
    setDataset(folder_ / "in.h5", "group", group, 1);
  }
  /// Drawn along itself by `ratio` of what presses it on the rods.
  void draw(double ratio, int steps, const std::string& more = "") {
    const auto outcome =
        run(folder_,
            "-scene file -scene_file in.h5 -pair contact -contact_modulus 20 "
            "-contact_friction 0.3 -contact_restitution 0.1 -bc rods,bar -rods_group 0 "
            "-rods_fix 1,1,1 -rods_fix_rotation -bar_group 1 -bar_force " +
                std::to_string(ratio * press) + ",0," + std::to_string(-press) +
                " -ts_dt 10 -ts_max_steps " + std::to_string(steps) +
                " -progress_interval 0 -energy_monitor ascii:e.csv -monitor_interval 100 "
                "-state_output out.h5 -overwrite " +
                more);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
  }
  double place() const {
    return readVectors(folder_ / "out.h5", "/state/position").back().x - 11 * T;
  }
  double speed() const { return readVectors(folder_ / "out.h5", "/state/velocity").back().x; }
  auto energies() const { return readCsv(folder_ / "e.csv"); }
  static constexpr double press = 0.002;

 private:
  Folder folder_;
};

TEST(Friction, HoldsABarBelowItsAngleAndLetsItSlideAboveIt) {
  // Below it the bar rests after its spring has yielded; 0.5 % above it, it would go on.
  Bar soon, late;
  soon.draw(0.3 * 0.995, 90000);
  late.draw(0.3 * 0.995, 110000);
  EXPECT_NEAR(late.place(), soon.place(), 0.01);
  // Above it the bar falls with what the force exceeds friction by; the spring of the contacts
  // yields first, which is over after half of the time.
  const double ratio = 0.3 * 1.2;
  Bar half, whole;
  half.draw(ratio, 10000);
  whole.draw(ratio, 20000);
  EXPECT_NEAR((whole.speed() - half.speed()) / (1e5 * (ratio - 0.3) * Bar::press / tube::mass), 1.0,
              0.005);
  const auto energies = whole.energies();
  const double work = 0.3 * 12 * Bar::press * whole.place();
  EXPECT_NEAR(energies.at("friction").back() / work, 1.0, 0.01);
  EXPECT_NEAR(energies.at("total").back() + energies.at("damped").back() +
                  energies.at("friction").back() - energies.at("external").back(),
              energies.at("total").front(), 1e-7);
}

TEST(Friction, OfWhatIsHeldAndSlidesIsMuNWithAndWithoutDamping) {
  // The load does not change, so the spring keeps its length once it has yielded.
  for (const std::string restitution : {"1", "0.5"}) {
    const Folder folder;
    writeState(folder / "in.h5", {straightFibre({-3 * T, 0, 0}, {1, 0, 0}, 7),
                                  straightFibre({0, -3 * T, 2 * tube::rf - 0.2}, {0, 1, 0}, 7)});
    setDataset(folder / "in.h5", "group", {1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2}, 1);
    const auto outcome =
        run(folder,
            "-scene file -scene_file in.h5 -scene_file_edited -pair contact -contact_modulus 20 "
            "-contact_friction 0.3 -bc a,b -a_group 0 -a_fix 1,1,1 -a_fix_rotation -b_group 1 "
            "-b_velocity 1e-4,0,0 -b_fix_rotation -ts_dt 20 -ts_max_steps 3000 -group_monitor "
            "ascii:g.csv -monitor_interval 1 -progress_interval 0 -contact_restitution " +
                restitution);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto table = readCsv(folder / "g.csv");
    const auto &x = table.at("a_force_x"), &z = table.at("a_force_z");
    for (std::size_t k = x.size() / 2; k < x.size(); ++k)
      ASSERT_NEAR(std::abs(x[k] / z[k]), 0.3, 1e-6) << k << " restitution " << restitution;
  }
}

TEST(Friction, AHeldBarDoesNotCreep) {
  Bar bar;
  bar.draw(0.25, 30000);
  const double before = bar.place();
  Bar later;
  later.draw(0.25, 150000);
  EXPECT_NEAR(later.place(), before, 1e-6);
}

/// By how much a bar that a turning rod carries along lags behind the rod's surface, drawn back by
/// a third of what friction can bear. It goes at 1e-3 A/fs, a segment in 1356 steps.
double lagOfCarriedBar(int steps) {
  const Folder folder;
  const double load = 12 * 2e-3, speed = 1e-3,
               overlap = std::pow(load / (4.0 / 3 * 20 * tube::gigapascal * std::sqrt(tube::rf)),
                                  2.0 / 3);
  writeState(folder / "in.h5", {straightFibre({8.7 * T, -2.7 * T, 0}, {0, 1, 0}, 7),
                                straightFibre({0, 0, 2 * tube::rf - overlap}, {1, 0, 0}, 12)});
  std::vector<double> group(7, 1);
  group.resize(19, 2);
  setDataset(folder / "in.h5", "group", group, 1);
  setMotion(
      folder / "in.h5",
      [=](std::size_t row, const Vec3d&) {
        return Vec3d{row < 7 ? 0 : speed, 0, 0};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const auto outcome =
      run(folder,
          "-scene file -scene_file in.h5 -pair contact -contact_modulus 20 -contact_friction 0.3 "
          "-contact_restitution 0.1 -bc rod,bar -bar_group 1 -bar_fix 0,1,0 -bar_fix_rotation "
          "-bar_force -2e-4,0,-2e-3 -rod_group 0 -rod_axis 0,1,0 -rod_centre " +
              number(8.7 * T) + ",0,0 -rod_spin " + number(speed / (tube::rf - 0.5 * overlap)) +
              " -ts_dt 10 -ts_max_steps " + std::to_string(steps) +
              " -progress_interval 0 -state_output out.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return 10 * steps * speed - readVectors(folder / "out.h5", "/state/position")[7].x;
}

TEST(Friction, AContactThatRollsFromSegmentToSegmentKeepsItsSpring) {
  // The contact gives way by 0.03 A, then the bar rolls over three and six borders of segments. It
  // would fall behind by 0.1 A at each border if the spring were lost there.
  const double soon = lagOfCarriedBar(4000), late = lagOfCarriedBar(8000);
  EXPECT_NEAR(soon, 0.03, 0.03);
  EXPECT_NEAR(late, 0.03, 0.03);
}

TEST(Friction, OptionsThatCannotBeMeantAreRefused) {
  const Folder folder;
  const std::string weave = "-weave_fibres 2,2 -weave_segments 12 -ts_max_steps 1 -pair contact ";
  expectRefused(run(folder, weave), {"-contact_modulus", "-fibre_transverse_young"});
  expectRefused(run(folder, weave + "-contact_modulus -3"), {"-contact_modulus"});
  expectRefused(run(folder, weave + "-contact_modulus 10 -contact_friction -0.1"),
                {"-contact_friction"});
  expectRefused(run(folder, weave + "-contact_modulus 10 -contact_restitution 1.5"),
                {"-contact_restitution"});
  expectRefused(run(folder,
                    "-weave_fibres 2,2 -weave_segments 12 -ts_max_steps 1 "
                    "-contact_friction 0.2"),
                {"-contact_friction", "not used"});
}

/// Two fibres that cross at a right angle, `gap` apart, and meet at `speed` each.
struct Meeting {
  std::map<std::string, std::vector<double>> energies;
  double above = 0;   ///< by how much the upper one is above the lower one at the end
  double worst = 0;   ///< largest change of the energy
  double moving = 0;  ///< what the energy of pairs changed by at most
};

Meeting meet(double gap, double speed, const std::string& options) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({-5.3 * T, 0, 0}, {1, 0, 0}, 11),
                                straightFibre({0, -4.7 * T, 2 * tube::rf + gap}, {0, 1, 0}, 10)});
  setMotion(
      folder / "in.h5",
      [=](std::size_t row, const Vec3d&) {
        return Vec3d{0, 0, row < 11 ? speed : -speed};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const auto outcome = run(folder, "-scene file -scene_file in.h5 -contact_modulus 20 " + options +
                                       " -progress_interval 0 -energy_monitor ascii:e.csv "
                                       "-monitor_interval 10 -state_output out.h5");
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  Meeting m;
  m.energies = readCsv(folder / "e.csv");
  const auto x = readVectors(folder / "out.h5", "/state/position");
  m.above = x[16].z - x[5].z;
  for (const double e : m.energies["total"])
    m.worst = std::max(m.worst, std::abs(e - m.energies["total"][0]));
  const auto [least, most] = std::ranges::minmax_element(m.energies["pair"]);
  m.moving = *most - *least;
  return m;
}

/// Largest change of the energy of two fibres that collide, without damping, over that at the
/// start.
double driftAt(double dt) {
  Meeting m = meet(0.1, 2e-4, "-pair contact -ts_max_time 16000 -ts_dt " + std::to_string(dt));
  EXPECT_GT(m.moving, 0.01) << "they have not met";
  EXPECT_LT(m.energies["pair"].back(), 1e-12) << "they have not parted";
  return m.worst / m.energies["kinetic"][0];
}

TEST(Contacts, OfFastDeepAndStickyFibresKeepTheirEnergyAndSides) {
  // 1.2 km/s, 39 times the speed sqrt(kT/m) of a segment at 300 K: their surfaces overlap by 1.25
  // radii.
  const Meeting fast = meet(0.5, 6e-3, "-pair contact -ts_dt 10 -ts_max_time 8000");
  EXPECT_GT(fast.moving, 40);
  EXPECT_LT(fast.worst, 5e-5 * fast.moving);
  EXPECT_GT(fast.above, 2 * tube::rf);
  // A radius inside each other at the start.
  const Meeting deep =
      meet(-tube::rf, 0, "-pair contact -start_unchecked -ts_dt 10 -ts_max_time 8000");
  EXPECT_GT(deep.moving, 20);
  EXPECT_LT(deep.worst, 5e-4 * deep.moving);
  EXPECT_GT(deep.above, 2 * tube::rf);
  // Wet, they stick; the contact alone bears what the liquid draws.
  Meeting sticky = meet(2, 5e-4,
                        "-pair capillary,contact -capillary_volume 1000 -capillary_tension 0.0045 "
                        "-ts_dt 10 -ts_max_time 30000");
  EXPECT_LT(sticky.energies["pair"].back(), -1);
  EXPECT_LT(sticky.worst, 5e-4 * sticky.moving);
  EXPECT_GT(sticky.above, 0.8 * 2 * tube::rf);
}

TEST(Contacts, ViscousDampingSlowsWhatTouches) {
  // However much weaker the contact itself is than the damping.
  const double drag = 1, time = 100;
  for (const auto& [modulus, speed] : {std::pair{"20", 1e-5}, std::pair{"1e-5", 1e-2}}) {
    const Folder folder;
    writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 1),
                                  straightFibre({0, 0, 2 * tube::rf - 0.05}, {0, 1, 0}, 1)});
    setMotion(
        folder / "in.h5",
        [&, u = speed](std::size_t i, const Vec3d&) {
          return Vec3d{i ? u : 0, 0, 0};
        },
        [](std::size_t, const Vec3d&) { return Vec3d{}; });
    const auto outcome = run(
        folder, std::string("-scene file -scene_file in.h5 -scene_file_edited -pair contact "
                            "-damping_viscous 1 -ts_dt 1 -ts_max_steps 100 -progress_interval 0 "
                            "-state_output out.h5 -contact_modulus ") +
                    modulus);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto v = readVectors(folder / "out.h5", "/state/velocity");
    const double lost = 1 - (v[1].x - v[0].x) / speed;
    EXPECT_NEAR(lost / (2 * drag * time / tube::mass), 1.0, 0.02) << modulus;
  }
}

TEST(Contacts, WhatAFileSaysOfFreeEndsIsFoundAnew) {
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 6),
                                straightFibre({0, 0, 2 * tube::rf - 0.05}, {0, 1, 0}, 6)});
  const std::string options =
      "-scene file -scene_file_edited -pair contact -contact_modulus 20 -ts_dt 1 -ts_max_steps 10 "
      "-state_output out.h5 -overwrite -scene_file ";
  ASSERT_EQ(run(folder, options + "in.h5").status, 0);
  const auto expected = readDataset(folder / "out.h5", "/state/position");
  setDataset(folder / "in.h5", "free_ends", std::vector<double>(12, 40.0), 1);
  const auto outcome = run(folder, options + "in.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(readDataset(folder / "out.h5", "/state/position"), expected);
}

TEST(Contacts, ACollisionKeepsItsEnergyToSecondOrder) {
  const double coarse = driftAt(16), fine = driftAt(8);
  EXPECT_LT(coarse, 0.02);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.5);
}

TEST(Contacts, WhatTheyGainByABreakUnderThemIsBookedWithIt) {
  // A fibre lies across the bond between two segments that move apart. Before it breaks each of
  // them bears half of the contact, and all of it afterwards.
  const Folder folder;
  writeState(folder / "in.h5", {straightFibre({-0.5 * T, 0, 0}, {1, 0, 0}, 2),
                                straightFibre({0, -3 * T, 2 * tube::rf - 1}, {0, 1, 0}, 7)});
  setMotion(
      folder / "in.h5",
      [](std::size_t row, const Vec3d& x) {
        return Vec3d{row < 2 ? std::copysign(5e-4, x.x) : 0.0, 0, 0};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  const auto outcome =
      run(folder,
          "-scene file -scene_file in.h5 -start_unchecked -pair contact -contact_modulus 20 "
          "-break_strain_mean 0.001 -break_strain_std 0.00001 -ts_dt 0.5 -ts_max_steps 200 "
          "-progress_interval 0 -energy_monitor ascii:e.csv -monitor_interval 1",
          2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto e = readCsv(folder / "e.csv");
  double gained = 0, worst = 0;
  for (std::size_t k = 1; k < e.at("total").size(); ++k) {
    gained = std::max(gained, e.at("pair")[k] - e.at("pair")[k - 1]);
    worst = std::max(worst, std::abs(e.at("total")[k] + e.at("broken")[k] - e.at("total")[0]));
  }
  EXPECT_GT(gained, 0.1);
  EXPECT_LT(worst, 0.002);
}

/// A fibre pressed on a fixed one, in motion without damping: largest error of its energy balance
/// over the energy that it moves with.
double errorOf(double degrees, const VectorField& velocity, const VectorField& spin, double dt) {
  const Folder folder;
  const double angle = degrees * tube::pi / 180;
  const Vec3d along{std::cos(angle), std::sin(angle), 0};
  writeState(folder / "in.h5",
             {straightFibre({-7 * T, 0, 0}, {1, 0, 0}, 15),
              straightFibre(Vec3d{0, 0, 2 * tube::rf - 0.1} + (-3.3 * T) * along, along, 8)});
  std::vector<double> group(15, 1);
  group.resize(23, 2);
  setDataset(folder / "in.h5", "group", group, 1);
  auto ofUpper = [](const VectorField& field) {
    return [field](std::size_t row, const Vec3d& x) { return row < 15 ? Vec3d{} : field(row, x); };
  };
  setMotion(folder / "in.h5", ofUpper(velocity), ofUpper(spin));
  const auto outcome =
      run(folder,
          "-scene file -scene_file in.h5 -start_unchecked -pair contact -contact_modulus 20 "
          "-bc floor,bar -floor_group 0 -floor_fix 1,1,1 -floor_fix_rotation -bar_group 1 "
          "-bar_force 0,0,-0.002 -progress_interval 0 -energy_monitor ascii:e.csv "
          "-monitor_interval 20 -ts_max_time 60000 -ts_dt " +
              std::to_string(dt));
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  const auto e = readCsv(folder / "e.csv");
  double worst = 0;
  for (std::size_t k = 0; k < e.at("total").size(); ++k)
    worst = std::max(worst, std::abs(e.at("total")[k] - e.at("external")[k] - e.at("total")[0]));
  return worst / (e.at("kinetic")[0] + e.at("rotational")[0] + 0.05);
}

TEST(Contacts, KeepTheirEnergyWhileTheyRollOverAndSlideOffEnds) {
  const auto none = [](std::size_t, const Vec3d&) { return Vec3d{}; };
  const struct {
    const char* name;
    double degrees;
    VectorField velocity, spin;
  } cases[] = {
      // From 30 degrees through the range where the crossing gives way to the line and beyond.
      {"turns", 30,
       [](std::size_t, const Vec3d& x) {
         return 2e-5 * Vec3d{x.y, -x.x, 0};
       },
       [](std::size_t, const Vec3d&) {
         return Vec3d{0, 0, -2e-5};
       }},
      {"slides along", 2,
       [](std::size_t, const Vec3d&) {
         return Vec3d{2.5e-3, 0, 0};
       },
       none},
      {"slides across", 75,
       [](std::size_t, const Vec3d&) {
         return Vec3d{2.5e-3, 0, 0};
       },
       none}};
  for (const auto& c : cases) {
    const double coarse = errorOf(c.degrees, c.velocity, c.spin, 16),
                 fine = errorOf(c.degrees, c.velocity, c.spin, 8);
    EXPECT_LT(coarse, 0.02) << c.name;
    EXPECT_LT(fine, 0.5 * coarse) << c.name;
  }
}

TEST(Contacts, BesideThemDampingActsAsFarAsTheOtherLaw) {
  // Two fibres that a bridge of liquid holds, which do not touch; one is drawn along the other.
  double damped[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, 10),
                                  straightFibre({0, 15.5, 0}, {1, 0, 0}, 10)});
    const auto outcome = run(
        folder, std::string("-scene file -scene_file in.h5 -capillary_tension 0.0045 "
                            "-capillary_volume 50 -damping_viscous 1 -bc drawn -drawn_region "
                            "-9,15,-9,999,16,9 -drawn_velocity 1e-4,0,0 -ts_dt 10 -ts_max_steps "
                            "10 -monitor_interval 10 -energy_monitor ascii:e.csv -pair ") +
                    (k == 0 ? "capillary" : "capillary,contact -contact_modulus 20"));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    damped[k] = readCsv(folder / "e.csv").at("damped").back();
  }
  EXPECT_GT(damped[0], 1e-5);
  EXPECT_NEAR(damped[1] / damped[0], 1, 1e-6);
}

}  // namespace
}  // namespace nanoweft::test
