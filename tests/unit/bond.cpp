/// The EVM bond against independent numbers, its own energy, and the laws of mechanics.
#include <gtest/gtest.h>

#include "helpers.hpp"
#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/state/rest.hpp"

namespace nanoweft::test {
namespace {

const EvmBond referenceBond{13.56, 67.59, 19780.0, -4032.0, 1471.0};

/// model.md's formula for the whole, which the parts must sum to.
double evmEnergy(const EvmBond& b, const Vec3d& separation, const Quatd& qi, const Quatd& qj) {
  const double r = norm(separation);
  const Vec3d d = (1.0 / r) * separation, ni = axis1(qi), nj = -axis1(qj);
  return 0.5 * b.stretch * (r - b.length) * (r - b.length) + 0.5 * b.shear * dot(nj - ni, d) +
         b.bending * dot(ni, nj) -
         0.5 * b.torsion * (dot(axis2(qi), axis2(qj)) + dot(axis3(qi), axis3(qj))) + b.shear +
         b.bending + b.torsion;
}

void expectNear(const Vec3d& a, const Vec3d& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Bond, ReferenceCases) {
  const auto rows = readTable("bonds.csv");
  ASSERT_EQ(rows.size(), 200u);
  for (const auto& row : rows) {
    const Vec3d separation = vectorAt(row, 7) - vectorAt(row, 0);
    const Quatd qi = quaternionAt(row, 3), qj = quaternionAt(row, 10);
    const auto e = referenceBond.energy<double>({separation, qi, qj});
    const double scale = std::max(1.0, std::abs(row[14]));
    EXPECT_NEAR(e.total(), row[14], 1e-12 * scale);
    EXPECT_NEAR(e.stretch, row[15], 1e-12 * scale);
    EXPECT_NEAR(e.shear, row[16], 1e-12 * scale);
    EXPECT_NEAR(e.bending, row[17], 1e-12 * scale);
    EXPECT_NEAR(e.torsion, row[18], 1e-12 * scale);
    const auto f = referenceBond.force<double>({separation, qi, qj});
    expectNear(f.force, vectorAt(row, 19), 1e-11 * std::max(1.0, norm(vectorAt(row, 19))));
    expectNear(f.torqueI, vectorAt(row, 22), 1e-11 * std::max(1.0, norm(vectorAt(row, 22))));
    expectNear(f.torqueJ, vectorAt(row, 25), 1e-11 * std::max(1.0, norm(vectorAt(row, 25))));
  }
}

TEST(Bond, RestHasNoEnergyAndNoForce) {
  const Quatd q{1, 0, 0, 0};
  const Vec3d separation{13.56, 0, 0};
  EXPECT_EQ(referenceBond.energy<double>({separation, q, q}).total(), 0.0);
  const auto f = referenceBond.force<double>({separation, q, q});
  EXPECT_EQ(norm(f.force) + norm(f.torqueI) + norm(f.torqueJ), 0.0);
}

TEST(Bond, PartsSumToTheWholeAndForcesAreItsGradient) {
  Random random;
  for (int k = 0; k < 50; ++k) {
    const Quatd qi = random.orientation(), qj = rotation(random.vector(0.3)) * qi;
    const Vec3d separation = 13.56 * axis1(qi) + random.vector(1.0);
    const auto f = referenceBond.force<double>({separation, qi, qj});
    EXPECT_NEAR(referenceBond.energy<double>({separation, qi, qj}).total(),
                evmEnergy(referenceBond, separation, qi, qj), 1e-10);
    const Vec3d axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const Vec3d& e : axes) {
      auto moved = [&](double s) { return evmEnergy(referenceBond, separation + s * e, qi, qj); };
      auto turnedI = [&](double s) {
        return evmEnergy(referenceBond, separation, rotation(s * e) * qi, qj);
      };
      auto turnedJ = [&](double s) {
        return evmEnergy(referenceBond, separation, qi, rotation(s * e) * qj);
      };
      // Moving j along e: dU/ds = -F_j.e = F_i.e.
      EXPECT_NEAR(derivative(moved, 1e-2), dot(f.force, e), 1e-6 * (1 + norm(f.force)));
      EXPECT_NEAR(derivative(turnedI, 1e-3), -dot(f.torqueI, e), 1e-6 * (1 + norm(f.torqueI)));
      EXPECT_NEAR(derivative(turnedJ, 1e-3), -dot(f.torqueJ, e), 1e-6 * (1 + norm(f.torqueJ)));
    }
  }
}

TEST(Bond, AngularMomentumIsConserved) {
  Random random;
  for (int k = 0; k < 50; ++k) {
    const Quatd qi = random.orientation(), qj = random.orientation();
    const Vec3d separation = random.vector(13.0);
    const auto f = referenceBond.force<double>({separation, qi, qj});
    // About i: the torques and the force on j at its place.
    const Vec3d sum = f.torqueI + f.torqueJ + cross(separation, -f.force);
    EXPECT_LT(norm(sum), 1e-11 * (norm(f.torqueI) + norm(f.torqueJ) + 1));
  }
}

TEST(Bond, TurnsWithTheSpace) {
  Random random;
  const Quatd turn = random.orientation();
  const Quatd qi = random.orientation(), qj = rotation(random.vector(0.4)) * qi;
  const Vec3d separation = 13.0 * axis1(qi) + random.vector(0.5);
  const auto f = referenceBond.force<double>({separation, qi, qj});
  const auto g = referenceBond.force<double>({rotate(turn, separation), turn * qi, turn * qj});
  expectNear(g.force, rotate(turn, f.force), 1e-10 * norm(f.force));
  expectNear(g.torqueI, rotate(turn, f.torqueI), 1e-10 * norm(f.torqueI));
}

TEST(Bond, TwistCostsTorsionalEnergyAlone) {
  // The paper's printed sign would make this free.
  const Quatd q{1, 0, 0, 0}, twisted = rotation({0.3, 0, 0});
  const auto e = referenceBond.energy<double>({{13.56, 0, 0}, q, twisted});
  EXPECT_NEAR(e.torsion, referenceBond.torsion * (1 - std::cos(0.3)), 1e-10);
  EXPECT_NEAR(e.shear + e.bending + e.stretch, 0.0, 1e-12);
}

TEST(Bond, WithRestRotationsAgreesWithFiftyDigits) {
  const auto rows = readTable("curved_bonds.csv");
  ASSERT_EQ(rows.size(), 60u);
  for (const auto& row : rows) {
    BondGeometry<double> bond{vectorAt(row, 10) - vectorAt(row, 3), quaternionAt(row, 6),
                              quaternionAt(row, 13)};
    turnToRest(rotation(0.5 * vectorAt(row, 0)), bond);
    const auto e = referenceBond.energy(bond);
    const auto f = referenceBond.force(bond);
    const double parts[4] = {e.stretch, e.shear, e.bending, e.torsion};
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(parts[k], row[17 + k], 1e-10 * std::max(1e-3, row[17 + k]));
    const double force = norm(vectorAt(row, 22)), torque = norm(vectorAt(row, 25));
    EXPECT_LT(norm(f.force - vectorAt(row, 22)), 1e-10 * std::max(1e-1, force));
    EXPECT_LT(norm(f.torqueI - vectorAt(row, 25)), 1e-10 * std::max(1.0, torque));
    EXPECT_LT(norm(f.torqueJ - vectorAt(row, 28)), 1e-10 * std::max(1.0, torque));
  }
}

TEST(Kink, MomentFollowsTheCurveAndIsTheSlopeOfTheEnergy) {
  const double K = 0.25 * referenceBond.shear + referenceBond.bending + 0.5 * referenceBond.torsion;
  const double angle = 0.05, residual = 0.2;
  const Kink kink{angle, (1 - residual) * K};
  auto bentBy = [](double turn) {
    // Bent about z, symmetrically to the chord.
    return BondGeometry<double>{
        {13.56, 0, 0}, rotation({0, 0, -0.5 * turn}), rotation({0, 0, 0.5 * turn})};
  };
  auto momentAt = [&](double turn) {
    auto force = referenceBond.force(bentBy(turn));
    kink.add(bentBy(turn), force);
    return 0.5 * (force.torqueI.z - force.torqueJ.z);
  };
  auto energyAt = [&](double turn) {
    auto energy = referenceBond.energy(bentBy(turn));
    kink.add(bentBy(turn), energy);
    return energy.total();
  };
  // What the shear of the axes off the chord adds.
  auto shearAt = [](double turn) {
    return 0.5 * referenceBond.shear * (1 - std::cos(0.5 * turn)) * std::sin(0.5 * turn);
  };
  for (const double turn : {0.0, 0.01, 0.049, 0.0505, 0.053, 0.06, 0.2, 0.5}) {
    const double h = 1e-5, slope = (energyAt(turn + h) - energyAt(turn - h)) / (2 * h);
    EXPECT_NEAR(momentAt(turn), slope, 1e-6 * K) << turn;
  }
  EXPECT_NEAR((momentAt(0.04) - shearAt(0.04)) / (K * std::sin(0.04)), 1.0, 1e-12);
  // Far beyond the join: the moment there, and a fifth of the stiffness.
  const double theta = 2 * std::sin(0.1), width = 0.1 * angle;
  const double expected = K * (theta - (1 - residual) * (theta - angle - 0.5 * width));
  EXPECT_NEAR((momentAt(0.2) - shearAt(0.2)) / (expected * std::cos(0.1)), 1.0, 1e-12);
}

TEST(Bond, LanesGiveTheBitsOfDoubles) {
  Random random;
  const Quatd qi = random.orientation(), qj = rotation(random.vector(0.3)) * qi;
  const Vec3d separation = 13.56 * axis1(qi) + random.vector(1.0);
  auto wide = [](const Quatd& q) { return Quat<Lanes>{q.w, q.x, q.y, q.z}; };
  const auto one = referenceBond.force<double>({separation, qi, qj});
  const auto many = referenceBond.force(
      BondGeometry<Lanes>{{separation.x, separation.y, separation.z}, wide(qi), wide(qj)});
  for (std::size_t k = 0; k < Lanes::size(); ++k) {
    EXPECT_EQ(many.force.x[k], one.force.x);
    EXPECT_EQ(many.torqueI.y[k], one.torqueI.y);
    EXPECT_EQ(many.torqueJ.z[k], one.torqueJ.z);
  }
}

}  // namespace
}  // namespace nanoweft::test
