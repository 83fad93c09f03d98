/// Temperature (model.md 17): what a thermostat must give at any friction, within four standard
/// errors of the numbers that were averaged. Seeds are fixed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "support/expect.hpp"
#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

constexpr double kT = 8.617333262e-5 * 300;
const std::string heated =
    "-scene file -scene_file in.h5 -pair none -progress_interval 0 "
    "-ts_limit_interval 0 -temperature 300 ";

/// in.h5: straight fibres side by side, along x from x = 0 on.
void manyFibres(const Folder& folder, int fibres, int segments) {
  std::vector<FibreInput> all;
  for (int k = 0; k < fibres; ++k)
    all.push_back(straightFibre({0, 50.0 * k, 0}, {1, 0, 0}, segments));
  writeState(folder / "in.h5", all, {{-1e4, -1e4, -1e4}, {1e4, 50.0 * fibres + 1e4, 1e4}});
}

/// Runs and calls `look` with the positions and orientations of each snapshot from `first` on.
using Look = std::function<void(const std::vector<double>& x, const std::vector<double>& q)>;
void atSnapshots(const Folder& folder, const std::string& options, int interval, int first,
                 int last, const Look& look) {
  expectDone(run(folder, options + " -snapshot_file s -snapshot_interval " +
                             std::to_string(interval) + " -ts_max_steps " +
                             std::to_string(last * interval)));
  for (int k = first; k <= last; ++k) {
    const std::string step = std::to_string(k * interval);
    const std::string file = folder / ("s_" + std::string(10 - step.size(), '0') + step + ".h5");
    look(readDataset(file, "/state/position"), readDataset(file, "/state/orientation"));
  }
}

TEST(Temperature, EachSegmentHasThreeHalvesOfKTInTranslationAndRotation) {
  const Folder folder;
  manyFibres(folder, 100, 10);
  // A velocity forgets itself within 100 fs; rows lie 500 fs apart, so they are independent.
  expectDone(run(folder, heated +
                             "-temperature_damping 0.02 -temperature_start -ts_dt 10 -ts_max_steps "
                             "10000 -energy_monitor ascii:e.csv -monitor_interval 50"));
  const auto csv = readCsv(folder / "e.csv");
  const auto rows = static_cast<double>(csv.at("step").size());
  const double bound = 4 * std::sqrt(2 / (3000 * rows));
  for (const char* part : {"kinetic", "rotational"}) {
    double mean = 0;
    for (const double e : csv.at(part)) mean += e / rows;
    EXPECT_NEAR(mean / (1000 * 1.5 * kT), 1, bound) << part;
  }
  // A start that is drawn has the temperature, too.
  EXPECT_NEAR(csv.at("kinetic")[0] / (1500 * kT), 1, 4 * std::sqrt(2 / 3000.0));
  EXPECT_NEAR(csv.at("rotational")[0] / (1500 * kT), 1, 4 * std::sqrt(2 / 3000.0));
}

TEST(Temperature, ThinAndThickFibresHaveTheSame) {
  const Folder folder;
  expectDone(run(folder,
                 "-kinds thin,thick -thick_fibre_radius 13.56 -thick_fibre_density 2273 "
                 "-weave_kinds thin,thick -weave_fibres 8,4 -weave_segments 24 -pair none "
                 "-progress_interval 0 -temperature 300 -temperature_damping 0.02 "
                 "-temperature_start -ts_dt 10 -ts_max_steps 20000 -state_output out.h5 "
                 "-kind_monitor ascii:k.csv -monitor_interval 50"));
  const auto csv = readCsv(folder / "k.csv");
  const auto rows = static_cast<double>(csv.at("step").size() / 2);
  const std::pair<const char*, double> kinds[] = {{"thin", 8 * 24}, {"thick", 4 * 24}};
  for (const auto& [kind, n] : kinds)
    for (const char* part : {"_kinetic", "_rotational"}) {
      const auto& column = csv.at(kind + std::string(part));
      double mean = 0;
      for (std::size_t k = column.size() - static_cast<std::size_t>(rows); k < column.size(); ++k)
        mean += column[k] / rows;
      EXPECT_NEAR(mean / (n * 1.5 * kT), 1, 4 * std::sqrt(2 / (3 * n * rows))) << kind << part;
    }
}

TEST(Temperature, TheTipOfAClampedFibreFluctuatesByItsCompliance) {
  // <u^2> = kT L^3/(3 EJ) in each direction; the slowest mode has 1/omega = 1800 fs.
  const Folder folder;
  constexpr int fibres = 200, bonds = 6, first = 5, last = 45;
  manyFibres(folder, fibres, bonds + 1);
  double sum = 0, shifted = 0;
  atSnapshots(folder,
              heated +
                  "-temperature_damping 0.001 -ts_dt 20 -bc root -root_region "
                  "-1,-1e9,-1,1,1e9,1 -root_fix 1,1,1 -root_fix_rotation",
              300, first, last, [&](const std::vector<double>& x, const std::vector<double>&) {
                for (std::size_t k = 0; k < fibres; ++k) {
                  const double* root = &x[3 * (bonds + 1) * k];
                  const double* tip = root + 3 * bonds;
                  for (int c = 1; c < 3; ++c) sum += (tip[c] - root[c]) * (tip[c] - root[c]);
                  // What is held gets no noise.
                  shifted += std::abs(root[0]) + std::abs(root[1] - 50.0 * k) + std::abs(root[2]);
                }
              });
  constexpr double n = 2 * fibres * (last - first + 1), L = bonds * tube::length;
  EXPECT_NEAR(sum / n / (kT * L * L * L / (3 * tube::EJ)), 1, 4 * std::sqrt(2 / n));
  EXPECT_EQ(shifted, 0);
}

TEST(Temperature, TangentsForgetEachOtherOverThePersistenceLength) {
  // So soft that EJ/kT is a hundred segments.
  const Folder folder;
  constexpr int fibres = 80, segments = 21, apart = 10, first = 8, last = 45;
  const double share = 100 * tube::length * kT / tube::EJ;
  manyFibres(folder, fibres, segments);
  double sum = 0;
  long pairs = 0;
  atSnapshots(folder,
              heated + "-temperature_damping 3e-5 -ts_dt 500 -fibre_young " +
                  std::to_string(1029 * share) + " -fibre_shear " + std::to_string(459 * share),
              250, first, last, [&](const std::vector<double>&, const std::vector<double>& q) {
                auto tangent = [&](int row) {
                  const double* p = &q[4 * static_cast<std::size_t>(row)];
                  return tube::Frame({p[0], p[1], p[2], p[3]}).e1;
                };
                for (int k = 0; k < fibres; ++k)
                  for (int i = 0; i + apart < segments; ++i, ++pairs)
                    sum += dot(tangent(k * segments + i), tangent(k * segments + i + apart));
              });
  // Two stretches of a fibre are independent. 1 - t.t of a stretch scatters by its own mean, 0.1.
  const double stretches = 2.0 * fibres * (last - first + 1);
  const double found = -apart * tube::length / std::log(sum / static_cast<double>(pairs));
  EXPECT_NEAR(found / (tube::EJ * share / kT), 1, 4 / std::sqrt(stretches) + 0.01)
      << "0.01 = T over the persistence length, the error of a chain";
}

TEST(Temperature, AFreeFibreDiffuses) {
  // kT/(N m gamma), over windows of 20/gamma.
  const Folder folder;
  constexpr int fibres = 1000, segments = 3, windows = 10;
  constexpr double gamma = 2e-3, window = 500 * 20;
  manyFibres(folder, fibres, segments);
  std::vector<double> before(3 * fibres);
  double sum = 0;
  int seen = 0;
  atSnapshots(folder, heated + "-temperature_damping 0.002 -temperature_start -ts_dt 20", 500, 0,
              windows, [&](const std::vector<double>& x, const std::vector<double>&) {
                for (std::size_t k = 0; k < fibres; ++k)
                  for (std::size_t c = 0; c < 3; ++c) {
                    double centre = 0;
                    for (std::size_t i = 0; i < segments; ++i)
                      centre += x[3 * (segments * k + i) + c] / segments;
                    if (seen) sum += std::pow(centre - before[3 * k + c], 2);
                    before[3 * k + c] = centre;
                  }
                ++seen;
              });
  constexpr double n = 3.0 * fibres * windows;
  // A window also remembers the velocity with which it begins.
  const double times = 2 * (window - (1 - std::exp(-gamma * window)) / gamma);
  EXPECT_NEAR(sum / n / times / (kT / (segments * tube::mass * gamma)), 1, 4 * std::sqrt(2 / n));
}

TEST(Temperature, TheHeatIsAudited) {
  // Of a weave that is let go and pulled, with local damping beside the bath.
  double errors[2], heat = 0;
  for (int k = 0; k < 2; ++k) {
    const Folder folder;
    const auto outcome =
        run(folder,
            "-weave_fibres 4,4 -weave_segments 24 -damping_local 0.1 -temperature 3000 "
            "-temperature_damping 0.0005 -tension_rate 2e-5 -tension_ramp 2000 -tension_grip 40 "
            "-tension_max_strain 0.08 -energy_monitor ascii:e.csv -monitor_interval 10 -ts_dt " +
                std::string(k ? "5" : "10"));
    expectDone(outcome);
    EXPECT_TRUE(says(outcome, "total + damped + broken - external - heat drifted"))
        << outcome.output;
    EXPECT_TRUE(says(outcome, "other damping takes heat out")) << outcome.output;
    const auto csv = readCsv(folder / "e.csv");
    auto balance = [&](std::size_t i) {
      return csv.at("total")[i] + csv.at("damped")[i] + csv.at("broken")[i] -
             csv.at("external")[i] - csv.at("heat")[i];
    };
    errors[k] = 0;
    for (std::size_t i = 0; i < csv.at("step").size(); ++i)
      errors[k] = std::max(errors[k], std::abs(balance(i) - balance(0)));
    heat = std::abs(csv.at("heat").back());
  }
  EXPECT_GT(heat, 50);
  EXPECT_LT(errors[0], 0.05 * heat);
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

// A gas in a box that is pressed: the box heats, the bath cools. w = m <v^2>/kT of a component
// obeys dw/dt = -2 e w - 2 gamma (w - 1), e the rate of the box over its present length.
TEST(Temperature, OfAPressedGasIsWhatBoxAndBathMakeOfIt) {
  const Folder folder;
  std::vector<FibreInput> all;
  for (int k = 0; k < 4096; ++k)
    all.push_back(
        straightFibre({50.0 * (k % 16), 50.0 * (k / 16 % 16), 50.0 * (k / 256)}, {1, 0, 0}, 1));
  writeState(folder / "in.h5", all, {{-25, -25, -25}, {775, 775, 775}, {true, true, true}});
  const double gamma = 2e-3, rate = -2e-4, dt = 10;
  expectDone(run(
      folder, heated + "-temperature_damping 0.002 -temperature_start -ts_dt 10 -ts_max_steps 250 "
                       "-deform_x rate -deform_x_rate -2e-4 -deform_y rate -deform_y_rate -2e-4 "
                       "-deform_z rate -deform_z_rate -2e-4 -energy_monitor ascii:e.csv "
                       "-monitor_interval 5"));
  const auto csv = readCsv(folder / "e.csv");
  double w = 1, expected = 0, measured = 0;
  const int substeps = 100, rows = static_cast<int>(csv.at("step").size());
  for (int row = 0; row < rows; ++row) {
    expected += w / rows;
    measured += csv.at("kinetic")[static_cast<std::size_t>(row)] / (4096 * 1.5 * kT) / rows;
    for (int k = 0; k < 5 * substeps; ++k) {
      const double time = (5 * row + double(k) / substeps) * dt;
      w += dt / substeps * (-2 * rate / (1 + rate * time) * w - 2 * gamma * (w - 1));
    }
  }
  EXPECT_GT(expected, 1.1);
  // Energies of one component forget themselves within 1/(2 gamma): ten times in the run.
  EXPECT_NEAR(measured / expected, 1, 4 * std::sqrt(2.0 / (3 * 4096 * 10)));
}

TEST(Temperature, GivesNoHeatToWhatIsHeld) {
  const Folder folder;
  manyFibres(folder, 2, 4);
  expectDone(run(folder, heated +
                             "-temperature_damping 0.01 -bc all -all_region "
                             "-10,-10,-10,100,100,10 -all_fix 1,1,1 -all_fix_rotation -ts_dt 10 "
                             "-ts_max_steps 20 -energy_monitor ascii:e.csv -monitor_interval 10"));
  EXPECT_EQ(readCsv(folder / "e.csv").at("heat").back(), 0);
}

TEST(Temperature, OfZeroIsADragThatStopsAFreeFibre) {
  const Folder folder;
  manyFibres(folder, 3, 4);
  setMotion(
      folder / "in.h5",
      [](std::size_t, const Vec3d&) {
        return Vec3d{1e-3, 0, -2e-3};
      },
      [](std::size_t, const Vec3d&) { return Vec3d{}; });
  expectDone(run(folder,
                 "-scene file -scene_file in.h5 -scene_file_edited -pair none -temperature 0 "
                 "-temperature_damping 0.01 -ts_dt 10 -ts_max_steps 30 -energy_monitor "
                 "ascii:e.csv -monitor_interval 10"));
  const auto csv = readCsv(folder / "e.csv");
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(csv.at("kinetic")[k] / csv.at("kinetic")[0], std::exp(-2.0 * k), 1e-9);
    EXPECT_NEAR(csv.at("heat")[k], csv.at("kinetic")[k] - csv.at("kinetic")[0], 1e-9);
  }
}

TEST(Temperature, ALaterStageHasNoiseOfItsOwn) {
  // Two systems in the same noise come together, so a stage with that of the one before would.
  const Folder folder;
  const std::string bath =
      "-pair none -temperature 300 -temperature_damping 2e-3 -ts_dt 20 -ts_max_steps 1500 ";
  expectDone(run(folder, "-scene fibre -fibre_segments 40 -temperature_start " + bath +
                             "-state_output one.h5"));
  expectDone(run(folder, "-scene file -scene_file one.h5 " + bath + "-state_output two.h5"));
  // A restart of the second goes on with the noise that it had.
  expectDone(run(folder, "-scene file -scene_file one.h5 " + bath +
                             "-checkpoint_file c.h5 -checkpoint_interval 700 -ts_max_steps 700"));
  expectDone(run(folder, "-restart c.h5 -ts_max_steps 1500 -state_output again.h5", 2));
  const auto one = readDataset(folder / "one.h5", "/state/velocity"),
             two = readDataset(folder / "two.h5", "/state/velocity");
  double both = 0, ofOne = 0, ofTwo = 0;
  for (std::size_t k = 0; k < one.size(); ++k)
    both += one[k] * two[k], ofOne += one[k] * one[k], ofTwo += two[k] * two[k];
  EXPECT_LT(std::abs(both) / std::sqrt(ofOne * ofTwo), 0.4);
  EXPECT_EQ(readDataset(folder / "again.h5", "/state/velocity"), two);
}

}  // namespace
}  // namespace nanoweft::test
