/// What readers of pair laws share: two kinds with the laws chosen between them. For
/// pair_forces_read.cpp, pair_points_read.cpp and surface_law_read.cpp alone.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nanoweft/base/options.hpp"
#include "nanoweft/base/units.hpp"
#include "nanoweft/fibre/material.hpp"
#include "nanoweft/force/pair_force.hpp"
#include "nanoweft/force/surface_law.hpp"
#include "nanoweft/force/vdw.hpp"

namespace nanoweft {

/// Two kinds of fibre, or twice the same, whose pair forces are read.
struct PairReader {
  Options& options;
  const UnitSystem& units;
  const Fibre &a, &b;
  std::string prefix;                ///< of the options meant for these two: "cnt_mw_", or nothing
  std::vector<std::string> chosen;   ///< laws
  std::optional<double> accuracy{};  ///< by which numbers of points are chosen

  static constexpr const char* topic = "Pair forces";

  bool is(const std::string& law) const { return std::ranges::find(chosen, law) != chosen.end(); }
  std::string laws() const {
    std::string list;
    for (const std::string& law : chosen) list += (list.empty() ? "" : ",") + law;
    return list;
  }
  /// The options of a law.
  OptionSection of(const std::string& law) const {
    return {options, topic, is(law), "-pair is " + laws()};
  }
  /// Is a law chosen that acts between quadrature points?
  bool usesPoints() const {
    return std::ranges::any_of(
        chosen, [](const std::string& law) { return law != "none" && law != "contact"; });
  }
  bool mixed() const { return &a != &b; }
  /// An option meant for these two, for messages.
  std::string option(const std::string& name) const { return "-" + prefix + name; }
  /// Distance of the axes of two fibres that touch.
  double touch() const { return a.radius + b.radius; }
};

/// Where a law that reaches beyond contact is switched off, as far as options say it.
struct GivenRange {
  std::optional<double> from, to;  ///< distances of axes
};

/// The range by -pair_... where one law has a range, which `common` is, else by -LAW_gap_....
GivenRange readOwnRange(const PairReader& read, const std::string& law, const GivenRange& common,
                        Both<const char*> shown);

/// Throws InputError for a distance of axes that no table could span. `name`: of its option.
void requireRange(const std::optional<double>& distance, const PairReader& read,
                  const std::string& name);

/// Resting distance of two fibres in units of lambda; with the paper's parameters, the paper's
/// rounded value.
double restOf(const VdwParameters& p);

/// What the number of points of a law follows from.
struct PointNeed {
  double rest;  ///< distance of axes
  LawWidth width;
  double switchFrom = 0;  ///< where its switch begins, and a far part must have begun; 0: it is
                          ///< never split
};

/// Points of vdw, the only law that may be split, or in a run without it of another law or none.
PointChoice readPoints(const PairReader& read, const PointNeed& need);
/// Points of a law that is not split, beside others for which the options have been read.
PointChoice nearPoints(const PairReader& read, const PointNeed& need);

/// Values of the surface laws by name; NaN where none is known.
using SurfaceValues = std::map<std::string, SurfaceLawType::Values>;

/// The default values between two kinds.
SurfaceValues surfaceValuesBetween(const SurfaceValues& a, const SurfaceValues& b);

/// A surface law of two kinds.
struct ReadSurfaceLaw {
  SurfaceLaw law;
  std::string description;
  PointNeed need;
};

/// Reads one of surfaceLaws(). `values` are the defaults and become what holds. Empty when it is
/// not among the chosen ones.
std::optional<ReadSurfaceLaw> readSurfaceLaw(const PairReader& read, const SurfaceLawType& type,
                                             const GivenRange& common, SurfaceValues& values);

}  // namespace nanoweft
