/// Links against closed forms (model.md 11).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

// The (10,10) tube, by hand.
constexpr double gigapascal = 6.241509074e-3, pi = std::numbers::pi;
constexpr double rf = 6.78, wall = 3.35, T = 13.56;
constexpr double area = 2 * pi * wall * rf, moment = pi * wall * rf * (rf * rf + wall * wall / 4);
constexpr double EJ = 1029 * gigapascal * moment, ES = 1029 * gigapascal * area;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

TEST(LinksInABeam, ALinkInPlaceOfABondCarriesAsMuch) {
  // A cantilever of 11 segments, whole, or cut in the middle and linked across the cut.
  double tip[2];
  for (const bool cut : {false, true}) {
    const Folder folder;
    const auto fibre = straightFibre({0, 0, 0}, {1, 0, 0}, 11);
    writeState(folder / "in.h5", {fibre});
    if (cut) {
      std::vector<double> broken(11, 0.0);
      broken[5] = 1;
      setDataset(folder / "in.h5", "bond_broken", broken, 1);
      setLinks(folder / "in.h5", {{0, 5, 0, 6}});
    }
    const auto outcome =
        run(folder,
            "-scene file -scene_file in.h5 -pair none -relax_method fire -relax_force 1e-10 "
            "-ts_max_steps 400000 -bc root,tip -root_region -1,-9,-9,1,9,9 -root_fix 1,1,1 "
            "-root_fix_rotation -tip_region 135,-9,-9,136,9,9 -tip_force 0.02,0.001,0.002 "
            "-tip_torque 0.1,0,0 -progress_interval 0 -state_output out.h5");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    tip[cut] = readVectors(folder / "out.h5", "/state/position").back().y;
  }
  EXPECT_GT(tip[0], 1e-3);
  EXPECT_NEAR(tip[1] / tip[0], 1.0, 1e-6);
}

/// Two fibres with rungs between them, clamped at one end and bent by a force at the other.
struct Ladder {
  int segments = 41, every = 1;
  double apart = 3 * T, rung = 2000;  ///< rung: B2 of its link, eV

  double length() const { return (segments - 1) * T; }
  double force() const { return 1e-6 * 3 * 2 * EJ / (length() * length()); }

  double deflection() const {
    const Folder folder;
    writeState(folder / "in.h5", {straightFibre({0, 0, 0}, {1, 0, 0}, segments),
                                  straightFibre({0, apart, 0}, {1, 0, 0}, segments)});
    std::vector<LinkEnds> links;
    for (int k = every; k < segments; k += every) links.push_back({0, k, 1, k});
    setLinks(folder / "in.h5", links);
    auto region = [](double x) { return number(x - 1) + ",-99,-99," + number(x + 1) + ",99,99"; };
    const auto outcome = run(
        folder, "-scene file -scene_file in.h5 -pair none -relax_method fire -relax_force " +
                    number(1e-4 * force()) + " -ts_max_steps 400000 -bc root,tip -root_region " +
                    region(0) + " -root_fix 1,1,1 -root_fix_rotation -tip_region " +
                    region(length()) + " -tip_force 0," + number(0.5 * force()) +
                    ",0 -link_stiffness 100," + number(rung) + "," + number(-0.2 * rung) + "," +
                    number(0.1 * rung) + " -progress_interval 0 -state_output out.h5");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return readVectors(folder / "out.h5", "/state/position").back().y - apart;
  }

  /// Shear-lag beam: the fibres bend alike and slip against each other by s; a rung resists with
  /// B2/apart^2 times the slip. N is the force in the upper fibre:
  ///     N'' = a^2 N - K d/(2 EJ) M,  a^2 = K (2/ES + d^2/(2 EJ)),  N'(0) = N(L) = 0.
  double exact() const {
    const double L = length(), d = apart, P = force(), K = rung / (d * d) / (every * T);
    const double a = std::sqrt(K * (2 / ES + d * d / (2 * EJ))), b = K * d / (2 * EJ * a * a);
    // The integral of (L - x) N with N = b M + A cosh(a x) + B sinh(a x).
    const double tail = b * P / a * (std::tanh(a * L) / (a * a) - L / a);
    return (P * (1 - b * d) * L * L * L / 3 - d * tail) / (2 * EJ);
  }
};

TEST(LinksInABeam, ALadderIsTheShearLagBeam) {
  const double loose = 1e-6 * 40 * T;  // deflection of the two fibres alone
  double before = loose;
  for (const double rung : {20.0, 500.0, 2e4}) {
    Ladder ladder;
    ladder.rung = rung;
    const double measured = ladder.deflection();
    // The rung at the tip stands for half the length of the others: half a rung in 40 at most.
    EXPECT_NEAR(measured / ladder.exact(), 1.0, 0.0125) << "B2 = " << rung;
    EXPECT_LT(measured, before);
    before = measured;
  }
  Ladder sparse;
  sparse.every = 4;
  EXPECT_NEAR(sparse.deflection() / sparse.exact(), 1.0, 0.03);
  // The compound beam, which the stiffest ladder comes near to.
  EXPECT_LT(before, 1.6 * loose * 2 * EJ / (2 * EJ + ES * 9 * T * T / 2));
}

TEST(LinksInABeam, ALinkFarFromItsRestIsReportedAtTheStart) {
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 6), straightFibre({0, 20, 0}, {1, 0, 0}, 6)});
  setLinks(folder / "in.h5", {{0, 1, 1, 1}, {0, 4, 1, 4}});
  for (const auto& [rest, reported] : {std::pair{100.0, true}, std::pair{25.0, false}}) {
    setDataset(folder / "in.h5", "/link/rest_length", {20, rest}, 1);
    for (const int ranks : {1, 2}) {
      const auto outcome = run(folder,
                               "-scene file -scene_file in.h5 -scene_file_edited -pair none "
                               "-link_law spring -link_stretch 0.001 -ts_max_steps 2",
                               ranks);
      ASSERT_EQ(outcome.status, 0) << outcome.output;
      EXPECT_EQ(outcome.output.find("the link of fibre 0 segment 4 to fibre 1 segment 4 is 20 A "
                                    "long, and 100 at rest") != std::string::npos,
                reported)
          << outcome.output;
    }
  }
}

TEST(LinksInABeam, ALinkOfHalfTheBoxIsNoSilentPullAtAnotherImage) {
  // Two fibres along x whose middles are linked across y; the second one is moved by 20 A.
  const Folder folder;
  const std::string start =
      "-scene file -scene_file in.h5 -pair none -link_law spring -link_stretch 2 -bc p,q "
      "-p_region -100,20,-100,200,40,100 -p_fix 1,1,1 -p_fix_rotation -q_region "
      "-100,160,-100,200,180,100 -q_fix_rotation -q_velocity 0,2e-2,0 -ts_dt 1 "
      "-ts_max_time 1000 -progress_interval 0 -energy_monitor ascii:e.csv -overwrite ";
  auto write = [&](double high, bool periodic) {
    BoxInput box;
    box.lower = {-100, 0, -100};
    box.upper = {200, 300, 100};
    box.periodic = {false, periodic, false};
    writeState(folder / "in.h5",
               {straightFibre({0, 30, 0}, {1, 0, 0}, 6), straightFibre({0, high, 0}, {1, 0, 0}, 6)},
               box);
    setLinks(folder / "in.h5", {{0, 3, 1, 3}});
  };
  for (const int ranks : {1, 2}) {
    write(170, true);
    const auto stopped = run(folder, start, ranks);
    EXPECT_EQ(stopped.status, 2) << stopped.output;
    EXPECT_TRUE(says(stopped, "a link is nearly half as long as the periodic box"))
        << stopped.output;
    write(175, true);
    expectRefused(run(folder, start, ranks),
                  {"fibre 0 segment 3 to fibre 1 segment 3 is 145 A long"});
    write(170, false);
    EXPECT_EQ(run(folder, start, ranks).status, 0);
    EXPECT_NEAR(readCsv(folder / "e.csv").at("stretch").back(), 400, 1e-6);
  }
}

TEST(LinksInABeam, ASpringPulledApartBreaksAtItsForceAndItsEnergyIsBooked) {
  // Two single segments on a spring of 2 eV/A^2, pulled apart at a steady speed.
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 1), straightFibre({30, 0, 0}, {1, 0, 0}, 1)});
  setLinks(folder / "in.h5", {{0, 0, 1, 0}});
  const auto outcome =
      run(folder,
          "-scene file -scene_file in.h5 -pair none -link_law spring -link_stretch 2 "
          "-link_break_force 10 -bc a,b -a_region -1,-1,-1,1,1,1 -a_fix 1,1,1 -b_region "
          "29,-1,-1,31,1,1 -b_velocity 1e-3,0,0 -ts_dt 1 -ts_max_steps 6000 -progress_interval "
          "0 -energy_monitor ascii:e.csv -monitor_interval 1 -state_output out.h5");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto energies = readCsv(folder / "e.csv");
  // 10 eV/A is reached at 5 A, with 2 * 25/2 = 25 eV in the spring.
  EXPECT_NEAR(energies.at("broken").back(), 25, 0.05);
  EXPECT_NEAR(energies.at("external").back() - energies.at("kinetic").back(), 25, 0.05);
  EXPECT_NEAR(energies.at("stretch").back(), 0, 1e-12);
  EXPECT_NEAR(energies.at("stretch")[4000], 16, 0.05);
  EXPECT_EQ(readDataset(folder / "out.h5", "/link/broken"), std::vector<double>{1});
}

}  // namespace
}  // namespace nanoweft::test
