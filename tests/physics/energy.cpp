/// Energy and momentum of whole runs: drift without damping, and the audit with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nanoweft/base/floats.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

/// Largest deviation of total + damped + broken - external from its first value.
double imbalance(const std::map<std::string, std::vector<double>>& csv) {
  double worst = 0;
  for (std::size_t k = 0; k < csv.at("step").size(); ++k) {
    auto balance = [&](std::size_t i) {
      return csv.at("total")[i] + csv.at("damped")[i] + csv.at("broken")[i] - csv.at("external")[i];
    };
    worst = std::max(worst, std::abs(balance(k) - balance(0)));
  }
  return worst;
}

/// Runs with the steps dt, dt/2 and dt/4 over one time; Verlet's error must fall fourfold each
/// time.
void expectSecondOrder(const std::string& options, double dt, double time, double allowed) {
  double errors[3];
  for (int k = 0; k < 3; ++k) {
    const Folder folder;
    const double step = dt / (1 << k);
    const auto outcome =
        run(folder,
            options + " -ts_dt " + std::to_string(step) + " -ts_max_time " + std::to_string(time) +
                " -energy_monitor ascii:energy.csv -monitor_interval " + std::to_string(1 << k));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    errors[k] = imbalance(readCsv(folder / "energy.csv"));
  }
  EXPECT_LT(errors[0], allowed);
  EXPECT_GT(errors[0], 0.0);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2.0, 0.35);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2.0, 0.35);
}

TEST(Energy, UndampedFibreKeepsItsEnergyToSecondOrder) {
  // A bent, twisted and stretched fibre: about 60 eV of elastic energy.
  expectSecondOrder(
      "-scene fibre -fibre_segments 24 -fibre_bend 1 -fibre_twist 1 -fibre_strain 0.01 -pair none",
      16, 16000, 1.5);
}

TEST(Energy, UndampedFibresOfTwoKindsKeepTheirEnergyToSecondOrder) {
  // Thin and thick tubes, woven and let go: 11,000 eV of elastic energy.
  expectSecondOrder(
      "-kinds thin,thick -thick_fibre_radius 13.56 -thick_fibre_density 2273 -weave_kinds "
      "thin,thick -weave_fibres 6,3 -weave_segments 24",
      8, 1600, 15);
}

TEST(Energy, AFibreThatKinksKeepsItsEnergyToSecondOrder) {
  // Bonds that are bent by 0.065 rad kink from 0.049 on.
  expectSecondOrder(
      "-scene fibre -fibre_segments 24 -fibre_bend 1.5 -fibre_kink_curvature 0.0036 -pair none", 16,
      8000, 1.5);
}

TEST(Energy, UndampedFibreDoesNotDriftInALongRun) {
  const Folder folder;
  const auto outcome =
      run(folder,
          "-scene fibre -fibre_segments 16 -fibre_bend 1 -fibre_twist 0.5 -pair none -ts_dt 10 "
          "-ts_max_steps 200000 -energy_monitor ascii:energy.csv -monitor_interval 500");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto csv = readCsv(folder / "energy.csv");
  const auto& total = csv.at("total");
  // The mean of the first tenth against that of the last: fluctuations average out, a drift would
  // not.
  const std::size_t tenth = total.size() / 10;
  double first = 0, last = 0;
  for (std::size_t k = 1; k <= tenth; ++k)
    first += total[k] / tenth, last += total[total.size() - k] / tenth;
  EXPECT_NEAR(last / first, 1.0, 2e-4);
}

TEST(Energy, UndampedWeaveDoesNotDriftIn1e5Steps) {
  // 2 x 2 fibres of 12 segments, periodic, started as woven and so hot: contacts open and close.
  const Folder folder;
  const auto outcome =
      run(folder,
          "-weave_fibres 2,2 -weave_segments 12 -weave_periodic -ts_dt 10 -ts_max_steps 100000 "
          "-energy_monitor ascii:energy.csv -monitor_interval 20");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto csv = readCsv(folder / "energy.csv");
  const auto& total = csv.at("total");
  // Means of ten windows, since a step's energy fluctuates. Verlet keeps a nearby quantity, which
  // differs from the energy by some (w dt)^2/8 of the kinetic energy: by `offset` when the start's
  // motion has spread. How it is spread goes on changing, which moves the means by parts of that; a
  // drift would carry them away.
  const std::size_t window = total.size() / 10;
  double mean[10] = {}, kinetic = 0;
  for (std::size_t k = 0; k < 10 * window; ++k) {
    mean[k / window] += total[k] / static_cast<double>(window);
    kinetic += (csv.at("kinetic")[k] + csv.at("rotational")[k]) / (10.0 * window);
  }
  const double offset = std::abs(mean[1] - total[0]);
  EXPECT_GT(kinetic, 10);
  EXPECT_LT(offset, 0.05 * kinetic);
  for (int w = 2; w < 10; ++w) EXPECT_LT(std::abs(mean[w] - mean[1]), 0.2 * offset) << w;
}

TEST(Energy, UndampedWeaveKeepsItsEnergyToSecondOrder) {
  expectSecondOrder("-weave_fibres 4,4 -weave_segments 24", 12, 6000, 60);
}

TEST(Energy, DampedRelaxationIsAudited) {
  expectSecondOrder("-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4", 12, 6000, 60);
}

TEST(Energy, ViscousDampingIsAuditedAndConservesMomentum) {
  const Folder folder;
  // Two crossing fibres within reach, one of them moving.
  writeState(folder / "in.h5", {straightFibre({-60, 0, 0}, {1, 0, 0}, 10),
                                straightFibre({0, -60, 18}, {0, 1, 0}, 10)});
  const std::string common =
      "-scene file -scene_file in.h5 -damping_viscous 20 -damping_viscous_angular 200 "
      "-bc push -push_region -1000,-1000,-1,1000,1000,1 -push_force 0,0.01,0 ";
  double errors[2], damped = 0;
  for (int k = 0; k < 2; ++k) {
    const auto outcome =
        run(folder, common + "-ts_dt " + (k ? "2.5" : "5") +
                        " -ts_max_time 5000 -energy_monitor ascii:energy.csv -monitor_interval 1 "
                        "-state_output out.h5 -overwrite");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto csv = readCsv(folder / "energy.csv");
    errors[k] = imbalance(csv);
    damped = csv.at("damped").back();
  }
  EXPECT_GT(damped, 1e-3);  // so that there is something to audit
  EXPECT_LT(errors[0], 0.02 * damped);
  EXPECT_LT(errors[1], 0.6 * errors[0]);
  // 10 segments pushed with 0.01 eV/A for 5000 fs: pair and viscous forces inside cancel.
  const auto v = readDataset(folder / "out.h5", "/state/velocity");
  double momentum[3] = {0, 0, 0};
  for (std::size_t k = 0; k < v.size(); ++k) momentum[k % 3] += 2649 * 103.642697 * v[k];
  EXPECT_NEAR(momentum[1], 10 * 0.01 * 5000, 1e-3);
  EXPECT_NEAR(momentum[0], 0, 1e-8);
  EXPECT_NEAR(momentum[2], 0, 1e-8);
}

TEST(Energy, FreeWeaveKeepsMomentumAndAngularMomentum) {
  const Folder folder;
  const auto outcome = run(folder,
                           "-weave_fibres 4,4 -weave_segments 24 -scene_perturb 0.1 -ts_dt 10 "
                           "-ts_max_steps 400 -state_output out.h5",
                           2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto x = readDataset(folder / "out.h5", "/state/position"),
             v = readDataset(folder / "out.h5", "/state/velocity"),
             w = readDataset(folder / "out.h5", "/state/angular_velocity");
  Vec3d momentum, angular;
  double size = 0, spin = 0;
  const double inertia = 2649 * 6.78 * 6.78;
  for (std::size_t i = 0; i < x.size(); i += 3) {
    const Vec3d r{x[i], x[i + 1], x[i + 2]}, p = 2649.0 * Vec3d{v[i], v[i + 1], v[i + 2]};
    const Vec3d l = cross(r, p) + inertia * Vec3d{w[i], w[i + 1], w[i + 2]};
    momentum += p;
    angular += l;
    size += norm(p);
    spin += norm(l);
  }
  EXPECT_LT(norm(momentum), 1e-10 * size);
  EXPECT_LT(norm(angular), 1e-10 * spin);
}

TEST(Energy, TensionWithBreakageIsAudited) {
  // Fast pulling, so that bonds break soon; the account of the broken bonds' energy must close too.
  const std::string options =
      "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.4 -tension_rate 2e-5 -tension_ramp "
      "2000 "
      "-tension_grip 40 -tension_max_strain 0.6 -break_strain_mean 0.15 -break_strain_std 0.02 "
      "-energy_monitor ascii:energy.csv -stress_monitor ascii:stress.csv -monitor_interval 10 ";
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    const auto outcome = run(folder, options + "-ts_dt " + (k ? "3" : "6"));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto csv = readCsv(folder / "energy.csv");
    errors[k] = imbalance(csv) / csv.at("external").back();
    EXPECT_GT(readCsv(folder / "stress.csv").at("broken_bonds").back(), 4);
    EXPECT_GT(csv.at("broken").back(), 100);
  }
  EXPECT_LT(errors[0], 0.02);
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

/// What the header says about the sum over points.
std::string saidOf(const std::string& options) {
  const auto outcome = run(Folder(), "-scene fibre -fibre_segments 40 -ts_max_steps 0 " + options);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return outcome.output;
}

TEST(ForceError, OfASoftLawIsThatOfTheOverlapThatItNames) {
  const std::string named = "at an overlap of a tenth of a radius";
  EXPECT_NE(saidOf("-fibre_preset amyloid -pair hertz -hertz_stiffness 1e-5").find(named),
            std::string::npos);
  EXPECT_EQ(saidOf("").find(named), std::string::npos);
}

TEST(ForceError, OfFibresFarThickerThanTheirGapIsKeptInDoubles) {
  const std::string thick = saidOf(
      "-fibre_preset mwcnt_1000_900 -fibre_segment_length 60 -pair_exclude 1000 -pair_accuracy "
      "0.02");
  EXPECT_EQ(thick.find("single precision"), std::string::npos) << thick;
  const std::string usual = saidOf("-pair_accuracy 0.1");
  EXPECT_EQ(usual.find("single precision") != std::string::npos, singlePays) << usual;
}

TEST(ForceError, AStraightFibreThatRepelsItselfIsWarnedOf) {
  const std::string warned = "within a straight fibre, too, segments so near repel each other";
  const std::string fine = saidOf("-fibre_segment_length 3.39 -pair_exclude 5");
  EXPECT_NE(fine.find(warned + ", so it stretches; take 6 at least"), std::string::npos) << fine;
  EXPECT_EQ(saidOf("-fibre_segment_length 3.39 -pair_exclude 6").find(warned), std::string::npos);
}

TEST(ForceError, IsNoLargerInABundleThanTheHeaderSays) {
  for (const char* fibre : {"cnt_10_10", "mwcnt_20_10", "mwcnt_60_20"}) {
    const Folder folder;
    std::string said;
    auto forces = [&](const std::string& options) {
      const auto outcome =
          run(folder,
              "-scene bundle -bundle_fibres 7 -bundle_segments 20 -bundle_stagger 60 "
              "-scene_perturb 0.02 -ts_max_steps 0 -overwrite -state_output out.h5 -state_forces "
              "-pair_gap_switch 30 -pair_gap_cutoff 40 -fibre_preset " +
                  std::string(fibre) + options);
      EXPECT_EQ(outcome.status, 0) << outcome.output;
      const std::string before = "expected force error ";
      if (said.empty()) said = outcome.output.substr(outcome.output.find(before) + before.size());
      return readVectors(folder / "out.h5", "/state/force");
    };
    const auto found = forces(" -pair_accuracy 0.05"), exact = forces(" -pair_points 60");
    const auto bonds = forces(" -pair_points 60 -vdw_epsilon 1e-12");
    double error = 0, size = 0;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const Vec3d e = found[k] - exact[k], f = exact[k] - bonds[k];
      error += dot(e, e), size += dot(f, f);
    }
    EXPECT_LT(100.0 * std::sqrt(error / size), std::stod(said)) << fibre;
  }
}

}  // namespace
}  // namespace nanoweft::test
