/// Scene `lammps`: what is read of a data file, and what is refused of one.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "nanoweft/base/error.hpp"
#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

using namespace nanoweft;
using namespace nanoweft::test;

namespace {

/// Four atoms in a row through the boundary of a periodic box, not in order. The atoms begin in
/// line 14, the bonds in line 21.
const std::string row =
    "a title with 9 atoms\n"
    "4 atoms\n"
    "3 bonds\n"
    "2 atom types\n"
    "0 400 xlo xhi\n"
    "0 400 ylo yhi\n"
    "-10 390 zlo zhi\n"
    "\n"
    "Masses\n"
    "\n"
    "1 12.0\n"
    "\n"
    "Atoms # full\n"
    "3 1 1 0.5 10 20 30 1 0 0\n"
    "1 1 1 0.5 350 20 30\n"
    "2 1 1 0.5 380 20 30\n"
    "4 1 2 0.5 40 20 30 0 0 0  # an end\n"
    "\n"
    "Bonds\n"
    "\n"
    "1 1 1 2\n"
    "2 1 3 2\n"
    "3 1 3 4\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, text.npos) << what;
  return at == text.npos ? text : text.replace(at, what.size(), by);
}

const std::string start =
    "-scene lammps -lammps_file in.data -ts_max_steps 0 -state_output out.h5 ";

TEST(Lammps, BondsThatGoElsewhereByTheirFlagsAreWarnedOf) {
  const Folder folder;
  const auto warned = [&](const std::string& text) {
    writeText(folder / "in.data", text);
    const Outcome outcome = run(folder, start + "-overwrite");
    expectDone(outcome);
    return says(outcome, "1 bonds lead to the nearest images");
  };
  EXPECT_TRUE(warned(row));  // of the last atom, which has flags of its own
  EXPECT_FALSE(warned(replaced(row, "40 20 30 0 0 0", "40 20 30 1 0 0")));
}

TEST(Lammps, AFibreFollowsBondsThroughTheBoundary) {
  const Folder folder;
  writeText(folder / "in.data", row);
  const Outcome outcome = run(folder, start);
  expectDone(outcome);
  EXPECT_TRUE(says(outcome, "scene lammps: 1 fibres, volume fraction")) << outcome.output;
  const auto x = readVectors(folder / "out.h5", "state/position");
  // From 350 to 440: 90/T = 6.6. The middle of the fibre is that of the line.
  ASSERT_EQ(x.size(), 7u);
  for (std::size_t k = 0; k < 7; ++k) {
    EXPECT_NEAR(x[k].x, std::fmod(395 + 13.56 * (static_cast<double>(k) - 3), 400), 1e-9);
    EXPECT_NEAR(x[k].y, 20, 1e-9);
    EXPECT_NEAR(x[k].z, 30, 1e-9);
  }
}

TEST(Lammps, AllStylesOfChainsGiveTheSameFibre) {
  const Folder folder;
  writeText(folder / "in.data", row);
  expectDone(run(folder, start));
  const auto expected = readDataset(folder / "out.h5", "state/position");
  std::string plain = row;
  for (int k = 0; k < 4; ++k) plain = replaced(plain, " 0.5", "");
  for (const char* style : {"bond", "angle", "molecular"}) {
    writeText(folder / "in.data", replaced(plain, " # full", ""));
    expectDone(run(folder, start + "-overwrite -lammps_style " + style));
    EXPECT_EQ(readDataset(folder / "out.h5", "state/position"), expected) << style;
  }
  // Neighbours are named instead of bonds, and one image flag says where the others' are.
  std::string mesont = replaced(row.substr(0, row.find("Bonds")), "# full", "# mesont");
  mesont = replaced(mesont, "3 bonds\n", "");
  for (const char* names : {"2 4", "-1 2", "1 3", "3 -1"})
    mesont = replaced(mesont, " 0.5", " " + std::string(names) + " 1e3 6.78 30 0");
  writeText(folder / "in.data", mesont);
  expectDone(run(folder, start + "-overwrite"));
  EXPECT_EQ(readDataset(folder / "out.h5", "state/position"), expected);
}

/// Seven tubes closed through the box along z, tilted along x there, and a ring of the second type,
/// in a file in nm.
std::string bundleAndRing() {
  std::string atoms;
  int id = 0, bonds = 0;
  std::string ties;
  auto put = [&](int count, int type, const std::function<Vec3d(int)>& place) {
    for (int k = 0; k < count; ++k) {
      const Vec3d x = place(k);
      atoms += format("%d 1 %d %.17g %.17g %.17g\n", id + k + 1, type, x.x, x.y, x.z);
      ties += format("%d 1 %d %d\n", ++bonds, id + k + 1, id + (k + 1) % count + 1);
    }
    id += count;
  };
  for (int tube = 0; tube < 7; ++tube) {
    const double angle = tube * std::numbers::pi / 3, r = tube < 6 ? 1.75 : 0;
    put(11, 1, [=](int k) {
      return Vec3d{20 + r * std::cos(angle) + 0.1 * k, 20 + r * std::sin(angle), 2.0 * k};
    });
  }
  put(40, 2, [](int k) {
    const double angle = 2 * std::numbers::pi * k / 40;
    return Vec3d{20 + 10 * std::cos(angle), 20 + 10 * std::sin(angle), 11.3};
  });
  return format(
      "\n%d atoms\n%d bonds\n2 atom types\n0 40 xlo xhi\n0 40 ylo yhi\n0 22 zlo zhi\n"
      "0 1.1 0 xy xz yz\n\nBonds\n\n%s\nAtoms\n\n%s",
      id, bonds, ties.c_str(), atoms.c_str());
}

TEST(Lammps, TubesClosedThroughATiltedBoxAndRingsAreTheSameOnAnyRanks) {
  const Folder alone, three;
  const std::string options = start +
                              "-lammps_style molecular -lammps_scale 10 -kinds a,b "
                              "-lammps_kinds b,a ";
  for (const Folder* folder : {&alone, &three}) writeText(*folder / "in.data", bundleAndRing());
  const Outcome outcome = run(alone, options);
  expectDone(outcome);
  expectDone(run(three, options, 3));
  EXPECT_TRUE(readFile(alone / "out.h5") == readFile(three / "out.h5"));
  EXPECT_EQ(readDataset(alone / "out.h5", "state/fibre_closed").size(), 8u);
  EXPECT_EQ(readDataset(alone / "out.h5", "state/kind").front(), 1);
  EXPECT_EQ(readDataset(alone / "out.h5", "state/kind").back(), 0);
  const auto x = readVectors(alone / "out.h5", "state/position");
  const auto fibre = readDataset(alone / "out.h5", "state/fibre");
  // Round the box: sqrt(220^2 + 11^2)/T = 16.2; round the ring: 2 pi 100/T = 46.3.
  ASSERT_EQ(x.size(), 7u * 16 + 46);
  for (std::size_t k = 0; k < x.size(); ++k)
    if (fibre[k] == 7) {
      EXPECT_NEAR(std::hypot(x[k].x - 200, x[k].y - 200), 100, 0.1);
    } else if (fibre[k] == 6) {
      EXPECT_NEAR(x[k].x - 200, 0.05 * x[k].z, 1e-6);
    }
}

struct Wrong {
  std::string what, by;  ///< of the row above
  std::vector<std::string> fragments;
  std::string options = "";
};

const std::vector<Wrong> wrong = {
    {" # full", "", {"in.data, line 13", "nothing says of which style", "-lammps_style"}},
    {"full", "atomic", {"line 13", "style 'atomic' cannot be read"}},
    {"", "", {"line 13", "style full", "-lammps_style says bond"}, "-lammps_style bond"},
    {"full", "bond", {"line 14", "bond has 6 columns (id molecule type x y z)", "not 10"}},
    {"5 350", "5 35o", {"line 15", "'35o' is not a number"}},
    {"\n1 1 1 0", "\n1.5 1 1 0", {"line 15", "'1.5' is not a whole number"}},
    {"\n4 atoms", "\n5 atoms", {"in.data", "says 5 atoms, but it has 4"}},
    {"3 bonds", "2 bonds", {"in.data", "says 2 bonds, but it has 3"}},
    {"0 400 ylo yhi", "", {"in.data", "no `ylo yhi`"}},
    {"\n\nMasses", "\n9 0 9 xy xz yz\nMasses", {"line 8", "more than one of xy, xz and yz"}},
    {"\n\nMasses",
     "\n0 9 0 xy xz yz\nMasses",
     {"in.data", "tilted", "-lammps_periodic"},
     "-lammps_periodic 1,1,0"},
    {"4 1 2", "4 1 3", {"line 17", "is 3, but the header has 2"}},
    {"2 1 1 0", "1 1 1 0", {"line 16", "atom 1 comes twice"}},
    {"1 1 1 2", "1 1 1 7", {"line 21", "no atom 7"}},
    {"3 1 3 4", "3 1 2 4", {"line 23", "atom 2 has a third bond"}},
    {"3 1 3 4", "3 1 2 3", {"line 23", "2 and 3 are tied twice"}},
    {"3 bonds", "2 bonds\n", {"line 18", "atom 4 has no bond"}},
    {"5 380", "5 350", {"line 16", "1 and 2, which are tied, lie at one place"}},
    {"", "", {"-lammps_kinds", "each of the 2 atom types"}, "-kinds a,b -lammps_kinds a,b,a"},
    {"", "", {"-lammps_kinds: 'c' is not among -kinds"}, "-kinds a,b -lammps_kinds a,c"},
    {"", "", {"line 17", "4 is of another kind", "atom 1"}, "-kinds a,b -lammps_kinds a,b"},
    {"", "", {"in.data: fibre 0 is 9 long", "less than 2 segments"}, "-lammps_scale 0.1"},
};

TEST(Lammps, WhatCannotBeReadIsRefusedWithItsLine) {
  const Folder folder;
  for (const Wrong& w : wrong) {
    std::string text = replaced(row, w.what, w.by);
    if (w.by == "2 bonds\n") text = replaced(text, "3 1 3 4\n", "");
    writeText(folder / "in.data", text);
    expectRefused(run(folder, start + w.options), w.fragments);
  }
}

TEST(Lammps, NeighboursMustNameEachOther) {
  const Folder folder;
  const std::string box =
      "\n2 atoms\n1 atom types\n0 400 xlo xhi\n0 400 ylo yhi\n0 400 zlo zhi\nAtoms # mesont\n";
  const std::string first = "1 1 1 -1 2 1 6.78 20 0 10 20 30\n", rest = "1 6.78 20 0 40 20 30\n";
  writeText(folder / "in.data", box + first + "2 1 1 -1 -1 " + rest);
  expectRefused(run(folder, start), {"line 8", "names 2 as its neighbour, which does not name it"});
  writeText(folder / "in.data", box + first + "2 1 1 1 1 " + rest);
  expectRefused(run(folder, start), {"line 9", "both neighbours of the atom are the same"});
}

}  // namespace
