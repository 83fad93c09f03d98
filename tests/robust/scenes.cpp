/// The scenes that lay fibres: nothing overlaps, the packing is what was asked for, and the same is
/// laid on any number of ranks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <regex>
#include <string>
#include <tuple>

#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

using namespace nanoweft;
using namespace nanoweft::test;

namespace {

/// Of a (10,10) tube: radius, segment, distance of two that cross at rest, A.
constexpr double radius = 6.78, T = 13.56, rest = 17.3436;

struct Laid {
  std::vector<Vec3d> x, axis;
  std::vector<double> fibre, index;
  Vec3d edge;  ///< of a periodic box
};

Vec3d nearest(Vec3d d, const Vec3d& edge) {
  if (edge.x > 0) d.x -= edge.x * std::round(d.x / edge.x);
  if (edge.y > 0) d.y -= edge.y * std::round(d.y / edge.y);
  if (edge.z > 0) d.z -= edge.z * std::round(d.z / edge.z);
  return d;
}

/// Distance of a point from a piece of one segment length about the origin.
double distanceFromPiece(const Vec3d& d, const Vec3d& axis) {
  const double along = std::clamp(dot(d, axis), -0.5 * T, 0.5 * T);
  return norm(d - along * axis);
}

/// The least distance of segments of different fibres, or of one that are over five places apart,
/// counted over its ends as well, since it may be closed.
double leastDistance(const Laid& s) {
  double least = 1e9;
  const double last = std::ranges::max(s.index);
  for (std::size_t i = 0; i < s.x.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double between = std::abs(s.index[i] - s.index[j]);
      if (s.fibre[i] == s.fibre[j] && (between <= 5 || between >= last - 5)) continue;
      const Vec3d d = nearest(s.x[i] - s.x[j], s.edge);
      if (dot(d, d) > 35.0 * 35.0) continue;
      for (int k = -8; k <= 8; ++k)
        least = std::min(least, distanceFromPiece(d + (k * T / 16.0) * s.axis[i], s.axis[j]));
    }
  return least;
}

Laid read(const std::string& file, const Vec3d& edge) {
  Laid s{readVectors(file, "state/position"),
         {},
         readDataset(file, "state/fibre"),
         readDataset(file, "state/index"),
         edge};
  for (const Quatd& q : readOrientations(file)) s.axis.push_back(axis1(q));
  return s;
}

struct Case {
  std::string name, options;
  std::vector<std::string> says;  ///< of the header
  Vec3d edge{0, 0, 0};            ///< of the box, where it is periodic
  std::size_t fibres = 1;
  double closest = 0.97 * rest;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

const std::vector<Case> cases = {
    {"Bundle",
     "-scene bundle -bundle_fibres 19 -bundle_segments 20 -bundle_stagger 100",
     {"scene bundle: 19 fibres, volume fraction 0.5", "17.3436 A apart"},
     {},
     19},
    {"BundleOfStaples",
     "-scene bundle -bundle_fibres 7 -bundle_segments 12 -bundle_in_line 3",
     {"21 fibres"},
     {},
     21},
    {"Ring", "-scene ring -ring_segments 240 -ring_windings 3", {"3 windings", "radius 172"}},
    {"OpenRing", "-scene ring -ring_segments 240 -ring_windings 5 -ring_closed 0", {"5 windings"}},
    {"Racket", "-scene racket -racket_segments 200", {"loop of 904", "handle of two arms"}},
    {"Helix",
     "-scene helix -helix_segments 200 -helix_fibres 2 -helix_rest shaped",
     {"2 fibres", "200 segments each"},
     {},
     2},
    {"Rope",
     "-scene rope -rope_plies 3,7 -rope_segments 60",
     {"21 fibres", "volume fraction 0.", "lay"},
     {},
     21,
     0.94 * rest},
    {"Film",
     "-scene film -film_segments 40 -film_coverage 2 -film_size 700,700",
     {"coverage 1.996", "volume fraction", "thickness"},
     {700, 700, 0},
     133},
    // Two of the three have the kind that is four times as thick: (1 + 2 x 4) 2 rf 200 T over the
    // area, where half of each kind would be 7.5 of that.
    {"FilmOfTwoKinds",
     "-kinds a,b -b_fibre_radius 27.12 -b_fibre_density 2273 -b_fibre_young 1000 -scene film "
     "-film_fibres 3 "
     "-film_segments 200 -film_kinds a,b -film_shares 0.3,0.7 -film_size 100000,100000 "
     "-film_slope 0.05",
     {"coverage 3.31"},
     {100000, 100000, 0},
     3},
    {"FilmOfBundles",
     "-scene film -film_segments 40 -film_layers 3 -film_bundle 10 -film_coverage 1.2 "
     "-film_size 700,700",
     {"volume fraction 0.2651"},
     {700, 700, 0},
     80},
    {"FilmWhereNoPlaceIsLeftByLot",
     "-scene film -film_segments 40 -film_layers 3 -film_coverage 0.62 -film_size 700,700 "
     "-film_periodic no",
     {"coverage 0.6"},
     {},
     41},
    {"FilmOfWorms",
     "-scene film -film_segments 40 -film_fibres 50 -film_size 700,600 -film_persistence 800",
     {"50 fibres"},
     {700, 600, 0},
     50},
    {"Network",
     "-scene network -network_size 500,500,500 -network_fraction 0.02 -network_segments 20",
     {"64 fibres, volume fraction 0.02"},
     {500, 500, 500},
     64},
    {"NetworkOfWorms",
     "-scene network -network_size 500,500,500 -network_fraction 0.03 -network_segments 40 "
     "-network_persistence 500",
     {"48 fibres, volume fraction 0.03"},
     {500, 500, 500},
     48},
    {"Array",
     "-scene array -array_fibres 4,4 -array_segments 30 -array_wave 15,200",
     {"16 fibres", "52.0307 A apart"},
     {},
     16},
    {"SquareArray",
     "-scene array -array_fibres 4,4 -array_segments 30 -array_wave 15,200 -array_packing square "
     "-array_periodic",
     {"16 fibres, volume fraction 0.05334", "52.0307 A apart"},
     {},
     16},
    {"WideHelix",
     "-scene helix -helix_segments 200 -helix_fibres 2 -helix_radius 150",
     {"2.867 turns"},
     {},
     2},
    {"LongBraid",
     "-scene braid -braid_segments 80 -braid_lay 1500",
     {"3 strands of 1, lay 1500 A"},
     {},
     3},
    {"FilmWithGentleSlopes",
     "-scene film -film_segments 40 -film_coverage 1 -film_size 700,700 -film_slope 0.1",
     {"coverage 1"},
     {700, 700, 0},
     67},
    {"PeriodicKnit",
     "-scene knit -knit_loops 4 -knit_courses 4 -knit_periodic",
     {"4 fibres", "loops 162.72 A wide"},
     {},
     4},
    {"FlatBraid", "-scene braid -braid_segments 80", {"3 strands of 1"}, {}, 3},
    {"HollowBraid", "-scene braid -braid_strands 8 -braid_segments 80", {"8 strands of 1"}, {}, 8},
    {"BraidOfTows",
     "-scene braid -braid_filaments 7 -braid_segments 90",
     {"3 strands of 7"},
     {},
     21,
     0.92 * rest},
    {"Knit",
     "-scene knit -knit_loops 4 -knit_courses 4",
     {"4 fibres", "loops 162.72 A wide"},
     {},
     4},
    {"PlainWeave",
     "-scene weave -weave_fibres 6,6 -weave_segments 40",
     {"scene weave: 12 fibres, volume fraction 0.", "thickness 34.687 A"},
     {},
     12},
    {"Twill",
     "-scene weave -weave_fibres 6,6 -weave_segments 40 -weave_pattern twill -weave_float 2,1",
     {"12 fibres", "pitch"},
     {},
     12},
    {"SatinOfTows",
     "-scene weave -weave_fibres 5,5 -weave_segments 80 -weave_pattern satin -weave_filaments 3,2",
     {"60 fibres"},
     {},
     60,
     0.92 * rest},
    {"TwoLayers",
     "-scene weave -weave_fibres 4,4 -weave_segments 30 -weave_layers 2",
     {"16 fibres"},
     {},
     16},
};

class Scenes : public testing::TestWithParam<Case> {};

TEST_P(Scenes, LayFibresApartAndTheSameOnAnyRanks) {
  const Case& c = GetParam();
  const std::string options = c.options +
                              " -ts_max_steps 20 -progress_interval 0 -snapshot_file f "
                              "-snapshot_interval 20 -state_output out.h5";
  const Folder alone, three;
  const Outcome outcome = run(alone, options);
  expectDone(outcome);
  for (const std::string& words : c.says)
    EXPECT_TRUE(says(outcome, words)) << words << outcome.output;
  const Laid start = read(alone / "f_0000000000.h5", c.edge);
  EXPECT_EQ(start.fibre.back() + 1, static_cast<double>(c.fibres));
  EXPECT_GE(leastDistance(start), c.closest);
  expectDone(run(three, options, 3));
  for (const char* file : {"f_0000000000.h5", "out.h5"})
    EXPECT_TRUE(readFile(alone / file) == readFile(three / file)) << file;
}

INSTANTIATE_TEST_SUITE_P(Robust, Scenes, testing::ValuesIn(cases),
                         [](const auto& info) { return info.param.name; });

TEST(Scenes, AFilmFillsTheFractionAskedFor) {
  const Folder folder;
  expectDone(
      run(folder,
          "-scene film -film_segments 20 -film_layers 4 -film_coverage 0.8 -film_size 500,500 "
          "-film_fraction 0.1 -ts_max_steps 0 -state_output out.h5"));
  const Laid s = read(folder / "out.h5", {500, 500, 0});
  double top = 0;
  for (const Vec3d& x : s.x) top = std::max(top, x.z);
  const double volume = std::numbers::pi * radius * radius * T * static_cast<double>(s.x.size());
  EXPECT_NEAR(volume / (500.0 * 500.0 * (top + 2.0 * radius)), 0.1, 0.002);
}

/// The number of the header that this expression finds.
double numberIn(const std::string& output, const std::string& expression) {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(output, found, std::regex(expression))) << output;
  return std::stod(found[1]);
}

/// A scene of (10,10) tubes, the volume fraction that the header says, and what else it says.
struct Stated {
  std::string output;
  Laid laid;
  double fraction, volume;

  explicit Stated(const std::string& options) {
    const Folder folder;
    const Outcome outcome = run(folder, options + " -ts_max_steps 0 -state_output out.h5");
    expectDone(outcome);
    output = outcome.output;
    fraction = number("volume fraction ([-.e0-9]+)");
    laid = read(folder / "out.h5", {});
    volume = std::numbers::pi * radius * radius * T * static_cast<double>(laid.x.size());
  }
  /// The least and the largest of a function of the places.
  std::array<double, 2> range(const std::function<double(const Vec3d&)>& of) const {
    std::array<double, 2> found{1e9, -1e9};
    for (const Vec3d& x : laid.x) found = {std::min(found[0], of(x)), std::max(found[1], of(x))};
    return found;
  }
  double number(const std::string& expression) const { return numberIn(output, expression); }
  double span(double Vec3d::*along) const {
    const auto [least, most] = range([=](const Vec3d& x) { return x.*along; });
    return most - least;
  }
};

double fromAxis(const Vec3d& x) {
  return std::hypot(x.y, x.z);
}

double ringArea(double inner, double outer) {
  return std::numbers::pi * (outer * outer - inner * inner);
}

TEST(Scenes, APlainWeaveFillsAFractionOfItsAreaTimesItsThickness) {
  const Stated weave("-scene weave -weave_fibres 6,6 -weave_segments 80 -weave_pitch 160");
  const double height = weave.span(&Vec3d::z) + rest;
  EXPECT_NEAR(weave.volume / (960.0 * 960.0 * height) / weave.fraction, 1, 0.005);
}

TEST(Scenes, FractionsAreThoseOfTheBoxThatTheRunHas) {
  for (const auto& [scene, wider, factor] :
       std::vector<std::tuple<std::string, std::string, double>>{
           {"-scene network -network_size 400,420,440 -network_segments 15 -network_fibres 40 ",
            "-domain_lower 0,0,0 -domain_upper 500,420,440", 0.8},
           {"-scene film -film_periodic -film_size 400,400 -film_segments 15 -film_fibres 20 ",
            "-domain_upper 500,400,200", 0.8}}) {
    const Stated own(scene), run(scene + wider);
    EXPECT_NEAR(run.fraction / own.fraction, factor, 1e-3) << run.output;
  }
}

TEST(Scenes, AFilmIsAsThickAsTheFibresThatAreInIt) {
  // A kind that the film has none of adds nothing.
  std::vector<std::string> said;
  for (const char* kinds :
       {"thin", "thin,thick -thick_fibre_radius 20 -thick_fibre_density 2000"}) {
    const Folder folder;
    const Outcome outcome = run(folder, std::string("-scene film -film_fibres 40 -film_segments 30 "
                                                    "-film_layers 8 -ts_max_steps 0 -kinds ") +
                                            kinds);
    expectDone(outcome);
    const auto at = outcome.output.find("volume fraction");
    ASSERT_NE(at, std::string::npos) << outcome.output;
    said.push_back(outcome.output.substr(at, outcome.output.find('\n', at) - at));
  }
  EXPECT_EQ(said[0], said[1]);
}

TEST(Scenes, AFilmOfTwoKindsIsAsThickAsItsOutermostSurfacesLieApart) {
  // The thick ones lie low. b: radius 60, segments of 120.
  const double radii[2] = {radius, 60}, lengths[2] = {T, 120};
  for (const char* wanted : {"", " -film_fraction 0.006"}) {
    const Folder folder;
    const Outcome outcome =
        run(folder, std::string("-scene film -film_size 2500,2500 -film_fibres 40 "
                                "-film_segments 60 -kinds a,b -b_fibre_preset mwcnt_60_20 "
                                "-film_kinds a,b -film_shares 0.95,0.05 -ts_max_steps 0 "
                                "-state_output s.h5") +
                        wanted);
    expectDone(outcome);
    const auto x = readVectors(folder / "s.h5", "state/position");
    const auto kind = readDataset(folder / "s.h5", "state/kind");
    double low = 1e9, high = -1e9, volume = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      const auto own = static_cast<std::size_t>(kind[k]);
      low = std::min(low, x[k].z - radii[own]), high = std::max(high, x[k].z + radii[own]);
      volume += std::numbers::pi * radii[own] * radii[own] * lengths[own];
    }
    EXPECT_NEAR(numberIn(outcome.output, "thickness ([.0-9]+)") / (high - low), 1, 0.005) << wanted;
    const double fraction = volume / (2500.0 * 2500.0 * (high - low));
    EXPECT_NEAR(fraction / numberIn(outcome.output, "volume fraction ([-.e0-9]+)"), 1, 0.005)
        << wanted;
    if (*wanted != 0) {
      EXPECT_NEAR(fraction, 0.006, 3e-5);
    }
  }
}

TEST(Scenes, SpringsAndHollowBraidsFillAFractionOfATube) {
  for (const char* options : {"-scene helix -helix_segments 400 -helix_fibres 2",
                              "-scene braid -braid_strands 8 -braid_segments 200"}) {
    const Stated tube(options);
    const auto [least, most] = tube.range(fromAxis);
    const double section = ringArea(least - 0.5 * rest, most + 0.5 * rest);
    EXPECT_NEAR(tube.volume / (section * tube.span(&Vec3d::x)) / tube.fraction, 1, 0.02) << options;
  }
}

TEST(Scenes, ABundleFillsAFractionOfHexagonalCells) {
  const double cell = std::sqrt(0.75) * rest * rest, full = std::numbers::pi * radius * radius;
  for (const auto& [segments, inLine] : {std::pair{2, 1}, {20, 1}, {20, 3}}) {
    const Stated bundle("-scene bundle -bundle_segments " + std::to_string(segments) +
                        " -bundle_in_line " + std::to_string(inLine));
    const double fibres = segments * inLine * T, gaps = (inLine - 1) * rest;
    EXPECT_NEAR(bundle.fraction, full / cell * fibres / (fibres + gaps), 1e-4);
  }
}

TEST(Scenes, ARopeFillsAFractionOfABarAsLongAsItsHelicesAreHigh) {
  // Fibres around the axis, and one that lies in it.
  for (const auto& [plies, lay, core] : {std::tuple{2, 90.0, 0.0}, {7, 150.0, 1.0}}) {
    const Stated rope("-scene rope -rope_segments 200 -rope_plies " + std::to_string(plies) +
                      " -rope_lay " + std::to_string(lay));
    const double from = rope.range(fromAxis)[1], length = 200 * T;
    // Centres of neighbours are T from each other: a chord of the helix.
    double rise = 0;
    for (double step = 0.5 * T; step > 1e-9; step *= 0.5)
      if (std::hypot(rise + step, 2 * from * std::sin(std::numbers::pi * (rise + step) / lay)) < T)
        rise += step;
    const double helix = 200 * rise;
    const double height = (core * length + (plies - core) * helix) / plies;
    const double bar = std::numbers::pi * std::pow(from + 0.5 * rest, 2) * height;
    EXPECT_NEAR(rope.volume / bar / rope.fraction, 1, 0.003) << plies;
  }
}

TEST(Scenes, AFlatBraidFillsAFractionOfABar) {
  const Stated bar("-scene braid -braid_strands 5 -braid_segments 400");
  const double section = (bar.span(&Vec3d::y) + rest) * (bar.span(&Vec3d::z) + rest);
  EXPECT_NEAR(bar.volume / (section * bar.span(&Vec3d::x)) / bar.fraction, 1, 0.02);
}

TEST(Scenes, HollowBraidsAreAsWideAsTheirOutside) {
  for (const char* strands : {"4", "6", "8", "12"}) {
    const Stated tube(std::string("-scene braid -braid_segments 200 -braid_strands ") + strands);
    EXPECT_NEAR(tube.number("([.0-9]+) A wide"), 2.0 * tube.range(fromAxis)[1] + rest, 0.1)
        << strands;
  }
}

TEST(Scenes, StrandsOfThreeFibresReachAsFarAsTheirAxes) {
  const Stated braid("-scene braid -braid_filaments 3 -braid_segments 400");
  const double wide = braid.span(&Vec3d::y) + rest, high = braid.span(&Vec3d::z) + rest;
  EXPECT_NEAR(braid.number("([.0-9]+) A wide"), wide, 0.1);
  EXPECT_NEAR(braid.volume / (wide * high * braid.span(&Vec3d::x)) / braid.fraction, 1, 0.01);
  const Stated knit("-scene knit -knit_filaments 3 -knit_loops 4 -knit_courses 3 -knit_periodic");
  const double thick = knit.span(&Vec3d::z) + rest, loop = knit.number("loops ([.0-9]+) A wide");
  // Courses are 0.5545 loops apart.
  const double space = 4 * loop * 3 * 0.5545 * loop * thick;
  EXPECT_NEAR(knit.number("thickness ([.0-9]+)"), thick, 0.1);
  EXPECT_NEAR(knit.volume / space / knit.fraction, 1, 0.002);
}

TEST(Scenes, FibresOfAKnitStrandKeepApart) {
  for (const char* strand : {"2", "3", "7", "3 -knit_width 170"}) {
    const Stated knit(std::string("-scene knit -knit_loops 2 -knit_courses 2 -knit_filaments ") +
                      strand);
    EXPECT_GE(leastDistance(knit.laid), 0.99 * rest) << strand;
    EXPECT_NEAR(knit.number("thickness ([.0-9]+)") / (knit.span(&Vec3d::z) + rest), 1, 0.006)
        << strand;
  }
}

TEST(Scenes, ARacketFillsAFractionOfThePlateWithinItsOutline) {
  const Stated racket("-scene racket -racket_segments 200");
  const auto& x = racket.laid.x;
  // Cells of the plane that are enclosed, or no farther than half a gap from the axis.
  const double cell = 4;
  int cells = 0;
  for (double u = -1500; u < 1500; u += cell)
    for (double v = -500; v < 500; v += cell) {
      bool inside = false;
      double nearest = 1e9;
      for (std::size_t k = 0, last = x.size() - 1; k < x.size(); last = k++) {
        if ((x[k].y > v) != (x[last].y > v) &&
            u < x[k].x + (v - x[k].y) * (x[last].x - x[k].x) / (x[last].y - x[k].y))
          inside = !inside;
        nearest = std::min(nearest, std::hypot(u - x[k].x, v - x[k].y));
      }
      cells += inside || nearest < 0.5 * rest;
    }
  EXPECT_NEAR(racket.volume / (cells * cell * cell * rest) / racket.fraction, 1, 0.03);
}

/// On a ring of so many segments a winding: the median of the distances of segments from the
/// nearest one of another winding.
double nextWinding(const Laid& s, std::size_t ofWinding) {
  std::vector<double> least;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    least.push_back(1e9);
    for (std::size_t j = 0; j < s.x.size(); ++j)
      if ((i > j ? i - j : j - i) > ofWinding / 2)
        least.back() = std::min(least.back(), distanceFromPiece(s.x[i] - s.x[j], s.axis[j]));
  }
  std::ranges::nth_element(least, least.begin() + static_cast<std::ptrdiff_t>(least.size() / 2));
  return least[least.size() / 2];
}

TEST(Scenes, AnOpenRingHasItsEndsApartAndItsWindingsSideBySide) {
  for (const std::size_t windings : {1, 2, 3, 4, 7}) {
    const std::string segments = std::to_string(120 * windings);
    const Stated ring("-scene ring -ring_closed 0 -ring_windings " + std::to_string(windings) +
                      " -ring_segments " + segments);
    const auto& [x, axis, fibre, index, edge] = ring.laid;
    const Vec3d first = x.front() - 0.5 * T * axis.front(), last = x.back() + 0.5 * T * axis.back();
    EXPECT_GE(norm(first - last), rest) << windings;
    EXPECT_LE(norm(first - last), rest + 2.0 * T) << windings;
    if (windings == 1) continue;
    EXPECT_GE(leastDistance(ring.laid), 0.99 * rest) << windings;
    EXPECT_LE(nextWinding(ring.laid, 120), 1.05 * rest) << windings;
  }
}

TEST(Scenes, KindsHaveTheirSharesOfTheFibres) {
  using Counts = std::array<int, 3>;
  for (const auto& [fibres, kinds, shares, expected] :
       {std::tuple{"20", "a,b", "0.7,0.3", Counts{14, 6, 0}},
        // 28.5, 17.1, 11.4
        std::tuple{"57", "a,b,c", "0.5,0.3,0.2", Counts{29, 17, 11}},
        std::tuple{"10", "a,b,c", "0.25,0.25,0.5", Counts{2, 3, 5}}}) {
    const Folder folder;
    expectDone(run(folder,
                   std::string("-b_fibre_preset mwcnt_20_10 -scene bundle -bundle_segments 30 "
                               "-ts_max_steps 0 -state_output out.h5 -bundle_fibres ") +
                       fibres + " -kinds " + kinds + " -bundle_kinds " + kinds +
                       " -bundle_shares " + shares,
                   3));
    const auto kind = readDataset(folder / "out.h5", "state/kind");
    const auto index = readDataset(folder / "out.h5", "state/index");
    Counts count{};
    for (std::size_t k = 0; k < kind.size(); ++k)
      if (index[k] == 0) ++count[static_cast<std::size_t>(kind[k])];
    EXPECT_EQ(count, expected) << fibres;
  }
}

TEST(Scenes, AnotherSeedLaysOtherFibres) {
  const Folder one, two;
  const std::string options =
      "-scene network -network_size 400,400,400 -network_fibres 5 -network_segments 10 "
      "-ts_max_steps 0 -state_output out.h5 -seed ";
  expectDone(run(one, options + "1"));
  expectDone(run(two, options + "2"));
  EXPECT_NE(readDataset(one / "out.h5", "state/position"),
            readDataset(two / "out.h5", "state/position"));
}

TEST(Scenes, AFibreFollowsThePointsOfATextFile) {
  const Folder folder;
  // A circle of radius 200, closed but for round-off, and a straight fibre, with a comment between
  // its points.
  std::string text = "# a circle\n";
  for (int k = 0; k < 40; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 40;
    text +=
        std::to_string(20 * std::cos(angle)) + " " + std::to_string(20 * std::sin(angle)) + " 0\n";
  }
  text += "20 -9.8e-14 0\n";
  writeText(folder / "in.txt", text + "\n0 0 5\n# on\n10 0 5\n20 0 5\n");
  const Outcome outcome =
      run(folder,
          "-scene text -text_file in.txt -text_scale 10 -ts_max_steps 0 -state_output out.h5", 3);
  expectDone(outcome);
  EXPECT_TRUE(says(outcome, "scene text: 2 fibres, from")) << "a file states no space";
  const Laid s = read(folder / "out.h5", {});
  ASSERT_EQ(s.fibre.back(), 1);
  std::size_t onCircle = 0;
  for (std::size_t k = 0; k < s.x.size(); ++k)
    if (s.fibre[k] == 0) {
      ++onCircle;
      EXPECT_NEAR(std::hypot(s.x[k].x, s.x[k].y), 200.0, 0.2);
    } else {
      EXPECT_NEAR(s.x[k].y, 0.0, 1e-9);
      EXPECT_NEAR(s.x[k].z, 50.0, 1e-9);
    }
  EXPECT_EQ(onCircle, 93u);         // 2 pi 200/T = 92.7
  EXPECT_EQ(s.x.size(), 93u + 15);  // 200/T = 14.7
}

/// Lengths of a fibre's bonds over T, and turns from one bond to the next.
struct Bends {
  std::vector<double> lengths, turns;

  explicit Bends(const std::vector<Vec3d>& x) {
    for (std::size_t k = 1; k < x.size(); ++k) {
      lengths.push_back(norm(x[k] - x[k - 1]) / T);
      if (k < 2) continue;
      const Vec3d a = x[k - 1] - x[k - 2], b = x[k] - x[k - 1];
      turns.push_back(std::atan2(norm(cross(a, b)), dot(a, b)));
    }
  }
};

TEST(Scenes, PointsOfATextFileMayLieAnyhowFarApart) {
  const Folder folder;
  // An arc, and two straight lines of 44 and 45 segments.
  const double radius = 600;
  std::string text;
  for (const double angle : {0.0, 0.3, 0.31, 0.75, 0.9, 1.2, 1.35, 1.36, 1.8, 2.1})
    text += std::to_string(radius * std::cos(angle)) + " " +
            std::to_string(radius * std::sin(angle)) + " 0\n";
  writeText(folder / "in.txt", text + "\n0 0 50\n280 0 50\n283 0 50\n596.64 0 50\n" +
                                   "\n0 0 90\n3 0 90\n610.2 0 90\n");
  expectDone(run(folder, "-scene text -text_file in.txt -ts_max_steps 0 -state_output out.h5", 2));
  const Laid s = read(folder / "out.h5", {});
  std::vector<Vec3d> fibres[3];
  for (std::size_t k = 0; k < s.x.size(); ++k)
    fibres[static_cast<std::size_t>(s.fibre[k])].push_back(s.x[k]);
  for (const auto& fibre : fibres)
    for (const double length : Bends(fibre).lengths) EXPECT_NEAR(length, 1.0, 1e-9);
  for (const double turn : Bends(fibres[0]).turns) EXPECT_NEAR(turn * radius / T, 1.0, 0.1);
  EXPECT_EQ(fibres[1].size(), 44u);
  EXPECT_EQ(fibres[2].size(), 45u);
  // A fibre's ends are half a segment from the centres of its last segments.
  for (const auto& fibre : {fibres[1], fibres[2]}) {
    EXPECT_NEAR(fibre.front().x, 0.5 * T, 1e-9);
    EXPECT_NEAR(fibre.back().x, fibre.size() * T - 0.5 * T, 1e-9);
  }
}

TEST(Scenes, ASharpCornerAtRestTurnsNoOtherSegments) {
  const Folder folder;
  writeText(folder / "in.txt", "0 0 0\n200 0 0\n3 24 0\n");
  run(folder,
      "-scene text -text_file in.txt -text_rest shaped -start_unchecked -pair none "
      "-ts_max_steps 0 -state_output out.h5");
  const auto x = readVectors(folder / "out.h5", "/state/position");
  const auto q = readOrientations(folder / "out.h5");
  for (std::size_t k = 1; k < 10; ++k) EXPECT_GT(dot(axis1(q[k]), x[k + 1] - x[k]), 0.99 * T) << k;
}

TEST(Scenes, EvenNumbersOfSegmentsLieAboutTheMiddle) {
  for (const char* segments : {"24", "25"}) {
    const Folder folder;
    const std::string n = segments;
    expectDone(run(folder, "-scene rope -rope_plies 2 -rope_segments " + n +
                               " -ts_max_steps 0 -state_output rope.h5"));
    expectDone(run(folder, "-scene racket -racket_segments " + n +
                               "0 -ts_max_steps 0 -state_output racket.h5"));
    const auto rope = readVectors(folder / "rope.h5", "/state/position"),
               racket = readVectors(folder / "racket.h5", "/state/position");
    EXPECT_NEAR(rope.front().x + rope.back().x, 0, 1e-9) << n;
    EXPECT_NEAR(racket.front().x, racket.back().x, 1e-9) << n;
    EXPECT_NEAR(racket.front().y, -racket.back().y, 1e-9) << n;
  }
}

TEST(Scenes, TowsOfTwoKindsLeaveEachKindItsRoom) {
  const Folder folder;
  const auto outcome = run(folder,
                           "-kinds a,b -b_fibre_preset cnt_15_15 -scene weave -weave_kinds a,b "
                           "-weave_filaments 2,1 -weave_fibres 2,2 -weave_segments 30 "
                           "-ts_max_steps 0 -energy_monitor ascii:e.csv");
  expectDone(outcome);
  EXPECT_LT(readCsv(folder / "e.csv").at("pair").front(), 0);
}

TEST(Scenes, WormsHaveThePersistenceLengthThatIsAskedFor) {
  const Folder folder;
  for (const auto& [scene, asked, times] :
       {std::tuple{"network", 170.0, 1.0}, std::tuple{"network", 400.0, 1.0},
        std::tuple{"film", 170.0, 2.0}}) {
    const std::string name = scene;
    const bool network = name == "network";
    expectDone(run(folder, "-scene " + name + " -" + name + "_persistence " +
                               std::to_string(asked) + " -" + name + "_segments 40 -" + name +
                               (network ? "_fibres 400 -network_size 8000,8000,8000"
                                        : "_fibres 120 -film_size 12000,12000 -film_layers 2") +
                               " -pair none -ts_max_steps 0 -overwrite -state_output s.h5"));
    const auto x = readVectors(folder / "s.h5", "/state/position");
    const auto periodic = 8000.0;
    // Of chords one to five segments apart: their smoothing is the same at all distances.
    double sums[6] = {}, counts[6] = {};
    auto chord = [&](std::size_t k) {
      Vec3d d = x[k + 1] - x[k];
      if (network)
        for (double* c : {&d.x, &d.y, &d.z}) *c -= periodic * std::round(*c / periodic);
      return (1.0 / norm(d)) * d;
    };
    for (std::size_t f = 0; f + 40 <= x.size(); f += 40)
      for (std::size_t k = 0; k < 34; ++k)
        for (std::size_t apart = 2; apart <= 5; apart += 3) {
          sums[apart] += dot(chord(f + k), chord(f + k + apart));
          counts[apart] += 1;
        }
    const double found = 3 * T / (std::log(sums[2] / counts[2]) - std::log(sums[5] / counts[5]));
    EXPECT_NEAR(found / (times * asked), 1.0, 0.15) << name << " " << asked;
  }
}

TEST(Scenes, SegmentsOfAFilmTurnByTheirPersistenceLengthFromOneToTheNext) {
  // Deposited fibres are laid along what was grown, those in layers as they were grown.
  for (const char* options : {"", " -film_fraction 0.001", " -film_layers 10"}) {
    const Folder folder;
    expectDone(run(folder, std::string("-scene film -film_size 30000,30000 -film_fibres 400 "
                                       "-film_segments 100 -film_persistence 400 -pair none "
                                       "-ts_max_steps 0 -state_output s.h5") +
                               options));
    const Laid s = read(folder / "s.h5", {});
    for (const std::size_t apart : {1, 2, 5}) {
      double sum = 0, count = 0;
      for (std::size_t k = 0; k + apart < s.axis.size(); ++k) {
        if (s.fibre[k] != s.fibre[k + apart]) continue;
        const Vec3d &a = s.axis[k], &b = s.axis[k + apart];
        sum += (a.x * b.x + a.y * b.y) / std::hypot(a.x, a.y) / std::hypot(b.x, b.y);
        count += 1;
      }
      const double found = -0.5 * static_cast<double>(apart) * T / std::log(sum / count);
      EXPECT_NEAR(found / 400, 1, 0.05) << options << apart;
    }
  }
}

TEST(Scenes, WormsThatAreBentAroundOthersAreWarnedOf) {
  const std::string film =
      "-scene film -film_size 1000,1000 -film_persistence 500 -film_coverage 2 -pair none "
      "-ts_max_steps 0 -overwrite -state_output s.h5 ";
  const Folder folder;
  const Outcome loose = run(folder, film + "-film_layers 500");
  expectDone(loose);
  EXPECT_FALSE(says(loose, "as laid it is")) << loose.output;
  const std::string words = "-film_persistence 500: as laid it is ";
  const Outcome dense = run(folder, film + "-film_layers 10");
  expectDone(dense);
  ASSERT_TRUE(says(dense, words)) << dense.output;
  const double found = numberIn(dense.output, words + "([.0-9]+) A");
  const Laid s = read(folder / "s.h5", {});
  constexpr std::size_t apart = 18;
  double sum = 0, count = 0;
  for (std::size_t k = 0; k + apart < s.axis.size(); ++k)
    if (s.fibre[k] == s.fibre[k + apart]) sum += dot(s.axis[k], s.axis[k + apart]), count += 1;
  EXPECT_NEAR(found / (-0.5 * apart * T / std::log(sum / count)), 1, 0.15);
  // 0.4 where bonds are turned as soon as fibres meet.
  EXPECT_GT(found / 500, 0.55);
  const Outcome three = run(folder, film + "-film_layers 10", 3);
  EXPECT_EQ(numberIn(three.output, words + "([.0-9]+) A"), found);
}

TEST(Scenes, AKnitThatIsClosedFitsItsSegmentsToItsChords) {
  const Folder folder;
  for (const char* loops : {"2", "8", "40"}) {
    expectDone(run(folder, std::string("-scene knit -knit_periodic -knit_width 150 -knit_courses 4 "
                                       "-pair none -ts_max_steps 0 -overwrite -state_output s.h5 "
                                       "-knit_loops ") +
                               loops));
    const auto x = readVectors(folder / "s.h5", "/state/position");
    const auto segments = static_cast<double>(x.size() / 4);
    EXPECT_LT(std::abs(norm(x[1] - x[0]) / T - 1.0) * segments, 0.51) << loops;
  }
  // Fibres of a strand are not equally long.
  expectDone(run(folder,
                 "-scene knit -knit_periodic -knit_loops 2 -knit_courses 2 -knit_filaments 3 -pair "
                 "none -ts_max_steps 0 -overwrite -state_output s.h5"));
  const Laid s = read(folder / "s.h5", {});
  std::map<std::int64_t, std::vector<Vec3d>> fibres;
  for (std::size_t k = 0; k < s.x.size(); ++k) fibres[s.fibre[k]].push_back(s.x[k]);
  for (const auto& [f, x] : fibres) {
    const auto segments = static_cast<double>(x.size());
    EXPECT_LT(std::abs(norm(x[1] - x[0]) / T - 1.0) * segments, 0.51) << f;
  }
}

}  // namespace
