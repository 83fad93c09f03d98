#include "nanoweft/scene/start_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "nanoweft/base/exact_sum.hpp"
#include "nanoweft/fibre/bond.hpp"
#include "nanoweft/state/rest.hpp"

namespace nanoweft {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

/// What is looked at in a bond. Of a bond refused for one, the later ones are not looked at.
enum Kind { strain, axis, bend, twist, slant, kinds };
using Values = std::array<double, kinds>;

/// Beyond `warned` a bond is worth a line, beyond `refused` it cannot be meant.
struct Limits {
  Values warned, refused;
};

Limits limitsOf(const StartContext& c) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  // A run may have pulled bonds until they nearly broke, and folded fibres.
  if (c.evolved)
    return {{infinity, infinity, infinity, infinity, infinity},
            {0.5, 60 * degree, 90 * degree, 90 * degree, infinity}};
  Limits limits{{0.01, 10 * degree, 20 * degree, 10 * degree, 2 * degree},
                {0.05, 30 * degree, 45 * degree, 45 * degree, infinity}};
  // Only files come from outside; what was asked for by an option is meant.
  if (!c.fromFile) limits.warned.fill(infinity);
  const Values asked{c.asked.strain, 0.5 * c.asked.bend, c.asked.bend, c.asked.twist, 0.0};
  for (std::size_t k = 0; k < kinds; ++k)
    for (double* limit : {&limits.warned[k], &limits.refused[k]})
      *limit = std::max(*limit, std::abs(asked[k]) * (1.0 + 1e-6) + 1e-9);
  return limits;
}

double angleBetween(const Vec3d& a, const Vec3d& b) {
  return std::atan2(norm(cross(a, b)), dot(a, b));
}

/// What is left of the turn from one frame to the other without the part that bends the axis.
double twistBetween(const Quatd& a, const Quatd& b) {
  const Quatd turn = Quatd{a.w, -a.x, -a.y, -a.z} * b;
  return 2.0 * std::atan2(std::abs(turn.x), std::abs(turn.w));
}

/// What all bonds together show.
struct Survey {
  std::array<std::int64_t, kinds> warned{}, refused{};
  std::array<WorstBond, kinds> worst;
  WorstBond worstTurn;  ///< twist in a closed fibre
  std::int64_t bonds = 0;
  std::int64_t twisted = 0;      ///< bonds with more than 5 degrees of twist
  double shear = 0, others = 0;  ///< energies of the bonds
};

void raise(WorstBond& worst, double value, const StartBond& bond, const State& s, double rest,
           int bent) {
  if (!(value > worst.value)) return;
  const int i = bond.i, length = s.chain[2 * i + 1];
  worst = {value,
           s.row[i],
           s.fibre[i],
           s.chain[2 * i],
           (s.chain[2 * i] + 1) % length,
           bond.closes,
           bent ? (s.chain[2 * i] + 1) % length : s.chain[2 * i],
           s.kind(i),
           rest,
           bond.from,
           bond.to};
}

/// Of all ranks; of equals the one with the lowest row.
void agreeOnWorst(WorstBond* worst, std::size_t count, MPI_Comm comm, int ranks) {
  std::vector<WorstBond> all(count * static_cast<std::size_t>(ranks));
  const auto bytes = static_cast<int>(count * sizeof(WorstBond));
  MPI_Allgather(worst, bytes, MPI_BYTE, all.data(), bytes, MPI_BYTE, comm);
  for (std::size_t k = 0; k < all.size(); ++k) {
    WorstBond& best = worst[k % count];
    const WorstBond& other = all[k];
    if (other.value > best.value || (other.value == best.value && other.row < best.row))
      best = other;
  }
}

Survey surveyOf(const StartBonds& bonds, const StartContext& c, const Limits& limits) {
  const State& s = bonds.state();
  const MinimumImage nearest(s.box);
  const SumUnit unit(c.kinds.energyScale());
  Survey survey;
  ExactSum energy[2];
  bonds.forEach([&](const StartBond& bond) {
    const EvmBond b = bondLaw(s, c.kinds, bond.i);
    const Vec3d d = nearest(bond.to - bond.from);
    BondGeometry<double> frames{d, bond.first, bond.second};
    turnToRest(restHalfOf(s, c.kinds, bond.i), frames);
    const Vec3d e[2] = {axis1(frames.qi), axis1(frames.qj)};
    const double off[2] = {angleBetween(e[0], d), angleBetween(e[1], d)};
    const double r = norm(d);
    const Values values{std::abs(r / b.length - 1.0), std::max(off[0], off[1]),
                        angleBetween(e[0], e[1]), twistBetween(frames.qi, frames.qj),
                        angleBetween(e[0] + e[1], d)};
    ++survey.bonds;
    if (values[twist] > 5 * degree) ++survey.twisted;
    if (s.bond[bond.i] & fibreClosed) raise(survey.worstTurn, values[twist], bond, s, b.length, 0);
    for (std::size_t k = 0; k < kinds; ++k) {
      raise(survey.worst[k], values[k], bond, s, b.length, off[1] > off[0]);
      if (!(values[k] <= limits.refused[k])) {
        ++survey.refused[k];
        return;
      }
      if (values[k] > limits.warned[k]) ++survey.warned[k];
    }
    const auto u = bondEnergy(s, c.kinds, bond.i, frames);
    energy[0].add(u.shear, unit);
    energy[1].add(u.stretch + u.bending + u.torsion, unit);
  });
  std::array<std::int64_t, 2 * kinds + 2> counts;
  std::copy_n(survey.warned.begin(), kinds, counts.begin());
  std::copy_n(survey.refused.begin(), kinds, counts.begin() + kinds);
  counts[2 * kinds] = survey.bonds, counts[2 * kinds + 1] = survey.twisted;
  MPI_Allreduce(MPI_IN_PLACE, counts.data(), 2 * kinds + 2, MPI_INT64_T, MPI_SUM, s.comm());
  std::copy_n(counts.begin(), kinds, survey.warned.begin());
  std::copy_n(counts.begin() + kinds, kinds, survey.refused.begin());
  survey.bonds = counts[2 * kinds], survey.twisted = counts[2 * kinds + 1];
  agreeOnWorst(survey.worst.data(), kinds, s.comm(), s.ranks());
  agreeOnWorst(&survey.worstTurn, 1, s.comm(), s.ranks());
  ExactSum::reduce(energy, 2, s.comm());
  survey.shear = energy[0].value(unit), survey.others = energy[1].value(unit);
  return survey;
}

std::string placeOf(const WorstBond& w) {
  return format("fibre %lld, segments %d and %d", static_cast<long long>(w.fibre), w.index, w.next);
}

std::string measureOf(std::size_t kind, const WorstBond& w, const StartContext& c,
                      const MinimumImage& nearest) {
  const double angle = w.value / degree;
  switch (kind) {
    case strain: {
      const double r = norm(nearest(w.to - w.from)), length = w.rest;
      const double percent = 100 * (r / length - 1.0);
      return format("the bond between them is %.4g %s long instead of %.4g (strain %+.*f %%)", r,
                    c.units.length, length, std::abs(percent) < 20 ? 1 : 0, percent);
    }
    case axis:
      return format("the axis of segment %d is %.3g degrees off its bond", w.bent, angle);
    case bend:
      return format("their bond is bent by %.3g degrees", angle);
    case twist:
      return format("their bond is twisted by %.3g degrees", angle);
    default:
      return format("their axes are sheared %.3g degrees off the bond", angle);
  }
}

std::string countOf(std::int64_t count, std::int64_t bonds, std::size_t kind, double limit) {
  return format("; %lld of %lld bonds %s beyond %.3g %s", static_cast<long long>(count),
                static_cast<long long>(bonds), count == 1 ? "is" : "are",
                kind == strain ? 100 * limit : limit / degree, kind == strain ? "%" : "degrees");
}

constexpr const char* carryFrame =
    "carry one frame along the fibre, so that neighbours differ little";

std::string causeOf(std::size_t kind, const StartBonds& bonds, const StartContext& c,
                    const Survey& survey) {
  switch (kind) {
    case strain:
      return strainCause(bonds, c, survey.worst[strain]);
    case axis:
      return axisCause(bonds, c);
    case bend:
      return "cut the fibre into shorter segments or round the corner";
    default:
      return carryFrame;
  }
}

/// A closed fibre whose frames do not meet: its twist sits in one bond.
bool twistSitsInOneBond(const Survey& s) {
  return s.worstTurn.value > 10 * degree && 10 * s.twisted <= s.bonds;
}

}  // namespace

std::vector<StartFinding> lookAtStart(const State& state, const StartContext& c) {
  const StartBonds bonds(state);
  const Limits limits = limitsOf(c);
  const Survey s = surveyOf(bonds, c, limits);
  const MinimumImage nearest(state.box);
  std::vector<StartFinding> findings;
  for (std::size_t k = 0; k < kinds; ++k) {
    const bool refused = s.refused[k] > 0;
    if (!refused && s.warned[k] == 0) continue;
    if (k == twist && !c.evolved && twistSitsInOneBond(s)) continue;
    const double limit = refused ? limits.refused[k] : limits.warned[k];
    std::string text = placeOf(s.worst[k]) + ": " + measureOf(k, s.worst[k], c, nearest) +
                       countOf(refused ? s.refused[k] : s.warned[k], s.bonds, k, limit);
    if (refused) text += "; " + causeOf(k, bonds, c, s);
    findings.push_back({refused, text});
  }
  if (!c.evolved && twistSitsInOneBond(s))
    findings.push_back(
        {true, placeOf(s.worstTurn) + ": " + measureOf(twist, s.worstTurn, c, nearest) +
                   ", while others of this closed fibre are not; distribute the twist along the "
                   "fibre, a part on each bond"});
  if (c.fromFile && !c.evolved && s.worst[slant].value > 2 * degree && s.refused[axis] == 0 &&
      s.refused[strain] == 0 && s.shear > 10.0 * s.others) {
    std::erase_if(findings, [](const StartFinding& f) { return !f.refused; });
    findings.push_back(
        {true, placeOf(s.worst[slant]) + ": " + measureOf(slant, s.worst[slant], c, nearest) +
                   format(", and shear holds %.4g %s, all other parts of the bonds' energy %.4g; "
                          "axes must point along the chain, the tangent there",
                          s.shear, c.units.energy, s.others)});
  }
  std::ranges::stable_partition(findings, &StartFinding::refused);
  return findings;
}

}  // namespace nanoweft
