/// The virial stress of the gage region, against closed forms and the grips.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "support/formulas.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

using tube::gigapascal;

const std::vector<std::string> components{"virial_xx_GPa", "virial_yy_GPa", "virial_zz_GPa",
                                          "virial_xy_GPa", "virial_xz_GPa", "virial_yz_GPa"};
using Table = std::map<std::string, std::vector<double>>;

Table pull(const Folder& folder, const std::string& options, int ranks = 1) {
  const auto outcome = run(folder,
                           options +
                               " -stress_monitor ascii:stress.csv -state_output out.h5 "
                               "-state_forces -overwrite",
                           ranks);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  return readCsv(folder / "stress.csv");
}

/// The region and the segments of a final state along an axis.
struct Piece {
  std::vector<double> x, force, velocity;  // of the free segments
  double lower = -1e300, upper = 1e300, left = 0, right = 0;
  double speed = 0;  // of the right grip

  Piece(const std::string& file, std::size_t axis) {
    const auto position = readDataset(file, "/state/position"),
               f = readDataset(file, "/state/force"), v = readDataset(file, "/state/velocity"),
               group = readDataset(file, "/state/group");
    for (std::size_t i = 0; i < group.size(); ++i) {
      const auto bits = static_cast<std::int64_t>(group[i]);
      const std::size_t k = 3 * i + axis;
      if (bits >> 28 & 1) {
        lower = std::max(lower, position[k]);
        left += f[k];
      } else if (bits >> 29 & 1) {
        upper = std::min(upper, position[k]);
        right -= f[k];
        speed = v[k];
      } else {
        x.push_back(position[k]);
        force.push_back(f[k]);
        velocity.push_back(v[k]);
      }
    }
    lower += tube::length / 2, upper -= tube::length / 2;
  }
  double gage() const { return upper - lower; }
  /// Sum of s_k F_k over the free segments.
  double unbalanced() const {
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k)
      sum += (std::clamp((upper - x[k]) / gage(), 0.0, 1.0) - 0.5) * force[k];
    return sum;
  }
  /// Sum of m v^2 of the free segments in the region.
  double motion() const {
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k)
      if (x[k] > lower && x[k] < upper) sum += tube::mass * velocity[k] * velocity[k];
    return sum;
  }
  /// Sum of m v (x - middle).
  double moment() const {
    double sum = 0;
    for (std::size_t k = 0; k < x.size(); ++k)
      sum += tube::mass * velocity[k] * (x[k] - 0.5 * (lower + upper));
    return sum;
  }
};

TEST(GageStress, InclinedFibre) {
  // A straight fibre along d under the tension N = ES strain: N d (x) d over each length of it. In
  // the region it has the length L/d_x, and V = L w t.
  const Vec3d d = (1.0 / 7.0) * Vec3d{6, 2, 3};
  const Folder folder;
  const auto csv = pull(folder,
                        "-scene fibre -fibre_segments 30 -fibre_direction 6,2,3 -fibre_strain 0.01 "
                        "-pair none -tension_rate 2e-7 -tension_grip 40 -tension_width 20 "
                        "-tension_thickness 10 -ts_max_steps 0",
                        2);
  const double scale = 0.01 * tube::ES / (d.x * 20 * 10 * gigapascal);
  const double dyad[6] = {d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.x * d.z, d.y * d.z};
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_NEAR(csv.at(components[k]).front(), scale * dyad[k], 1e-11 * scale) << components[k];
  for (const char* grip : {"stress_left_GPa", "stress_right_GPa"})
    EXPECT_NEAR(csv.at(grip).front(), scale * d.x * d.x, 1e-11 * scale);
}

TEST(GageStress, EndsOfThePiece) {
  // Grips of 40 A inwards from 100 and 300 A; segments lie at multiples of T.
  const Folder folder;
  pull(folder,
       "-scene fibre -fibre_segments 30 -pair none -tension_ends 100,300 -tension_grip 40 "
       "-tension_width 20 -tension_rate 2e-7 -ts_max_steps 0");
  const auto position = readDataset(folder / "out.h5", "/state/position"),
             group = readDataset(folder / "out.h5", "/state/group");
  ASSERT_EQ(group.size(), 30u);
  for (std::size_t i = 0; i < 30; ++i) {
    const double x = position[3 * i];
    EXPECT_EQ(static_cast<std::int64_t>(group[i]), x <= 140   ? 1 << 28
                                                   : x >= 260 ? 1 << 29
                                                              : 0)
        << x;
  }
}

TEST(GageStress, TubesPressedTogether) {
  // Two parallel tubes at a distance h that push each other apart with the force p a segment:
  // across the tubes, each of the L/T segments of the region contributes h p.
  const double h = 16.5;
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 40), straightFibre({0, 0, h}, {1, 0, 0}, 40)});
  const auto csv =
      pull(folder,
           "-scene file -scene_file in.h5 -pair_points 3 -tension_grip 80 -tension_width 20 "
           "-tension_thickness 10 -tension_rate 2e-7 -ts_max_steps 0");
  double push = 0;
  const Quatd q = straightFibre({0, 0, 0}, {1, 0, 0}, 1).orientation[0];
  for (int k = -6; k <= 6; ++k)
    push += tube::pair({0, 0, 0}, q, {k * tube::length, 0, h}, q).forceJ.z;
  EXPECT_GT(push, 0.1);
  const double expected = -h * push / (tube::length * 20 * 10 * gigapascal);
  EXPECT_NEAR(csv.at("virial_zz_GPa").front(), expected, 1e-9 * std::abs(expected));
  for (const char* zero : {"virial_yy_GPa", "virial_xy_GPa", "virial_yz_GPa"})
    EXPECT_NEAR(csv.at(zero).front(), 0.0, 1e-12);
  EXPECT_NEAR(csv.at("virial_xx_GPa").front(), csv.at("stress_left_GPa").front(), 1e-11);
}

/// What crosses the region is the mean of the grips' forces and s_k F_k of the free segments,
/// whatever the motion; the flow of momentum with the segments goes off.
void expectBalance(const std::string& options, const std::string& axis, int ranks) {
  const Folder folder;
  const auto csv = pull(folder,
                        options + " -tension_axis " + axis +
                            " -tension_width 300 -tension_thickness 17 -monitor_interval 100",
                        ranks);
  const Piece piece(folder / "out.h5", axis == "x" ? 0 : 1);
  const double toStress = 1 / (300 * 17 * gigapascal);
  const double motion = piece.motion() / piece.gage(), grips = 0.5 * (piece.left + piece.right);
  EXPECT_GT(std::abs(piece.unbalanced()), 1e-3 * std::abs(grips));
  EXPECT_GT(motion, 1e-4 * std::abs(grips));
  const double expected = toStress * (grips + piece.unbalanced() - motion);
  double size = 0;
  for (double f : piece.force) size += toStress * std::abs(f);
  EXPECT_NEAR(csv.at("virial_" + axis + axis + "_GPa").back(), expected, 1e-10 * size);
}

TEST(GageStress, IsWhatGripsAndUnbalancedForcesMakeIt) {
  const std::string weave = "-weave_fibres 4,4 -weave_segments 24 -tension_grip 40 ";
  expectBalance(weave + "-tension_rate 1e-5 -tension_ramp 2000 -ts_max_steps 300", "x", 1);
  expectBalance(weave +
                    "-tension_rate 1e-5 -tension_ramp 2000 -ts_max_steps 300 -pair_far_points 1"
                    " -damping_local 0.2",
                "y", 2);
  expectBalance(weave +
                    "-damping_local 0.4 -tension_rate 2e-5 -tension_ramp 2000 "
                    "-tension_max_strain 0.4 -break_strain_mean 0.12 -break_strain_std 0.03",
                "x", 2);
  expectBalance(weave +
                    "-tension_rate 1e-5 -tension_ramp 2000 -ts_max_steps 300 -links_density 0.01 "
                    "-links_distance 18 -link_stiffness 20,1000,-200,100",
                "x", 2);
}

TEST(GripStress, HasWhatTheGripsDoWorkWith) {
  // Work of the grips: the integral of the mean of both stresses times area times gage over strain,
  // with whatever acts on what they hold, viscous forces and friction of contacts as well.
  const std::string weave =
      "-weave_fibres 4,4 -weave_segments 24 -tension_grip 60 -tension_rate 2e-5 -tension_ramp 2000 "
      "-tension_width 100 -tension_thickness 17 -ts_dt 10 -ts_max_steps 300 -monitor_interval 1 "
      "-stress_monitor ascii:s.csv -energy_monitor ascii:e.csv -state_output out.h5 ";
  for (const char* more :
       {"", "-damping_viscous 50", "-pair contact -contact_modulus 30 -contact_friction 0.8"}) {
    const Folder folder;
    const auto outcome = run(folder, weave + more, 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto s = readCsv(folder / "s.csv");
    const auto& strain = s.at("strain");
    auto pulled = [&](std::size_t k) {
      return 0.5 * (s.at("stress_left_GPa")[k] + s.at("stress_right_GPa")[k]) * gigapascal;
    };
    double work = 0;
    for (std::size_t k = 1; k < strain.size(); ++k)
      work += 0.5 * (pulled(k) + pulled(k - 1)) * (strain[k] - strain[k - 1]);
    double gage = 0;
    const auto at = outcome.output.find("gage ");
    ASSERT_NE(at, std::string::npos) << outcome.output;
    ASSERT_EQ(std::sscanf(outcome.output.c_str() + at, "gage %lf A", &gage), 1);
    work *= 100 * 17 * gage;
    // What holds the grips also sets them in motion.
    const auto v = readDataset(folder / "out.h5", "/state/velocity"),
               group = readDataset(folder / "out.h5", "/state/group");
    for (std::size_t i = 0; i < group.size(); ++i)
      if (static_cast<std::int64_t>(group[i]) >> 28 & 3)
        work += 0.5 * tube::mass * v[3 * i] * v[3 * i];
    const double external = readCsv(folder / "e.csv").at("external").back();
    EXPECT_NEAR(work, external, 1e-4 * std::abs(external)) << more;
    EXPECT_GT(external, 1) << more;
  }
}

TEST(GageStress, BundlePulledSlowly) {
  // Three tubes side by side, accelerated all the time: grips at A = rate gage / (2 ramp), the
  // tubes in between in proportion to the distance from the middle. So F_k = m a_k/(1 - c) where
  // damping c takes its part, and |s_k F_k| sums to n m A / (6 (1 - c)); started at once, the tubes
  // swing to at most twice that. The motion adds n m v^2/3 over the length.
  const double h = 17.07, c = 0.7, rate = 1e-6, ramp = 4e4;
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 0, 0}, 44), straightFibre({0, h, 0}, {1, 0, 0}, 44),
              straightFibre({0, 0.5 * h, h * std::sqrt(0.75)}, {1, 0, 0}, 44)});
  const auto csv = pull(folder,
                        "-scene file -scene_file in.h5 -damping_local 0.7 -tension_rate 1e-6 "
                        "-tension_ramp 4e4 -tension_grip 80 -tension_width 34 "
                        "-tension_thickness 17 -tension_max_strain 0.02 -monitor_interval 10");
  const Piece piece(folder / "out.h5", 0);
  const double n = static_cast<double>(piece.x.size()), L = piece.gage(), speed = 0.5 * rate * L;
  const double toStress = 1 / (34 * 17 * gigapascal);
  const double bound = toStress * n * tube::mass *
                       (2 * 0.5 * rate * L / ramp / (6 * (1 - c)) + speed * speed / (3 * L));
  for (std::size_t k = 0; k < csv.at("step").size(); ++k)
    EXPECT_NEAR(csv.at("virial_xx_GPa")[k],
                0.5 * (csv.at("stress_left_GPa")[k] + csv.at("stress_right_GPa")[k]), bound)
        << k;
  const double stress = csv.at("virial_xx_GPa").back();
  EXPECT_LT(bound, 4e-3 * stress);
  // A tube pulls with ES times its strain. The points of a pair move apart with the segments, so
  // the adhesion of the three pairs, 0.193731 eV/A, resists too.
  const double held = L + tube::length, given = 43 * tube::length - 160;
  EXPECT_NEAR(stress, toStress * 3 * (tube::ES * 0.02 * given / (held - 0.02 * given) + 0.193731),
              bound);
}

TEST(GageStress, WeaveAgreesWithItsGripsInTheMeanOverTime) {
  // Undamped: L (virial - grips) w t is the rate of -sum m v (x - middle), which starts from rest.
  // Sums of Verlet's steps keep that up to the kinetic term's own error, (w dt/2)^2 of it.
  const Folder folder;
  const auto csv =
      pull(folder,
           "-weave_fibres 4,4 -weave_segments 24 -tension_rate 4e-6 -tension_ramp 5000 "
           "-tension_grip 40 -tension_max_strain 0.1 -tension_width 300 "
           "-tension_thickness 17 -ts_dt 5 -monitor_interval 1 -energy_monitor "
           "ascii:energy.csv");
  const auto energy = readCsv(folder / "energy.csv");
  const Piece piece(folder / "out.h5", 0);
  EXPECT_GT(*std::ranges::min_element(piece.x), piece.lower);
  EXPECT_LT(*std::ranges::max_element(piece.x), piece.upper);
  const std::size_t rows = csv.at("step").size();
  const double toStress = 1 / (300 * 17 * gigapascal), time = csv.at("time_fs").back();
  double difference = 0, grips = 0, scatter = 0, motion = 0;
  for (std::size_t k = 0; k < rows; ++k) {
    const double weight = (k == 0 || k + 1 == rows ? 0.5 : 1.0) / static_cast<double>(rows - 1);
    const double L =
        piece.gage() - 2 * piece.speed / 4e-6 * (csv.at("strain").back() - csv.at("strain")[k]);
    const double mean = 0.5 * (csv.at("stress_left_GPa")[k] + csv.at("stress_right_GPa")[k]);
    const double apart = csv.at("virial_xx_GPa")[k] - mean;
    difference += weight * L * apart;
    grips += weight * mean;
    scatter += weight * apart * apart;
    motion += weight * 2 * energy.at("kinetic")[k] * toStress;
  }
  const double expected = -piece.moment() * toStress / time;
  EXPECT_NEAR(difference, expected, std::pow(5 / 29.4, 2) * motion);
  EXPECT_LT(std::abs(difference) / piece.gage(), 0.01 * grips);
  EXPECT_GT(std::sqrt(scatter), 0.2 * grips);  // so that there is something to average
}

}  // namespace
}  // namespace nanoweft::test
