/// Contacts with friction: the same bytes on any ranks and threads, and over restarts.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/expect.hpp"
#include "support/program.hpp"
#include "support/state_edit.hpp"

namespace nanoweft::test {
namespace {

/// A weave that is pulled, whose fibres rub and break.
const std::string weave =
    "-weave_fibres 8,8 -weave_segments 32 -pair contact -contact_modulus 30 -contact_friction 0.4 "
    "-contact_restitution 0.5 -scene_perturb 0.1 -damping_local 0.1 -ts_dt 10 -tension_rate 2e-5 "
    "-tension_ramp 1000 -tension_grip 60 -tension_thickness 27 -break_strain_mean 0.02 "
    "-break_strain_std 0.008 -progress_interval 0 ";
const std::string outputs =
    "-energy_monitor ascii:energy.csv -monitor_interval 50 -state_output out.h5 -state_forces ";

TEST(ContactsWithFriction, SameBytesOnAnyRanksThreadsAndPartition) {
  const Folder reference;
  auto outcome = run(reference, weave + outputs + "-ts_max_steps 600", 1, 1);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto energies = readCsv(reference / "energy.csv");
  EXPECT_GT(energies.at("friction").back(), 0.01);
  EXPECT_GT(energies.at("broken").back(), 0);
  const struct {
    int ranks, threads;
    const char* more;
  } layouts[] = {{1, 2, ""}, {2, 1, ""}, {3, 2, ""}, {8, 1, "-partition metis -partition_piece 8"}};
  for (const auto& l : layouts) {
    const Folder folder;
    outcome = run(folder, weave + outputs + "-ts_max_steps 600 " + l.more, l.ranks, l.threads);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    for (const char* file : {"out.h5", "energy.csv"})
      EXPECT_TRUE(readFile(folder / file) == readFile(reference / file))
          << file << " on " << l.ranks << " x " << l.threads << " " << l.more;
  }
}

TEST(ContactsWithFriction, OfATowInRegisterAreAllRemembered) {
  // The middle one of seven fibres touches three segments of each of the six others.
  const Folder folder;
  const auto outcome =
      run(folder,
          "-units si -fibre_preset glass_e -scene bundle -bundle_fibres 7 -bundle_segments 12 "
          "-bundle_gap 12.99e-6 -pair contact -contact_friction 0.3 -ts_max_steps 2 "
          "-checkpoint_file c.h5",
          2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  // Rows of partners plus one, a place for each that a segment may have.
  const auto partners = readDataset(folder / "c.h5", "/state/contact");
  const std::size_t places = partners.size() / (7 * 12);
  std::ptrdiff_t most = 0;
  for (auto of = partners.begin(); of < partners.end(); of += static_cast<std::ptrdiff_t>(places))
    most = std::max(most, std::count_if(of, of + static_cast<std::ptrdiff_t>(places),
                                        [](double p) { return p != 0; }));
  EXPECT_EQ(most, 18);
}

TEST(ContactsWithFriction, GoOnFromFilesOfEarlierProgramsWithHalfAsManyPlaces) {
  const Folder folder;
  ASSERT_EQ(run(folder, weave + "-ts_max_steps 100 -checkpoint_file c.h5").status, 0);
  const std::string on = "-restart c.h5 -ts_max_steps 150 -overwrite -state_forces -state_output ";
  ASSERT_EQ(run(folder, on + "whole.h5").status, 0);
  for (const auto& [name, columns] : {std::pair{"contact", 16}, {"contact_spring", 48}}) {
    const auto values = readDataset(folder / "c.h5", std::string("/state/") + name);
    std::vector<double> half;
    for (auto row = values.begin(); row < values.end(); row += 2 * columns)
      half.insert(half.end(), row, row + columns);
    setDataset(folder / "c.h5", name, half, columns);
  }
  signAgain(folder / "c.h5");
  const auto outcome = run(folder, on + "half.h5", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* name : {"/state/position", "/state/force", "/state/contact_spring"})
    EXPECT_EQ(readDataset(folder / "half.h5", name), readDataset(folder / "whole.h5", name))
        << name;
}

TEST(ContactsWithFriction, RanksWithoutSegmentsWriteTheSame) {
  // Two fibres along a diagonal: of four ranks in a square, two have nothing.
  const Folder folder;
  writeState(folder / "in.h5",
             {straightFibre({0, 0, 0}, {1, 1, 0}, 60), straightFibre({0, 0, 13}, {1, 1, 0}, 60)});
  std::string expected;
  for (const int ranks : {1, 4, 7}) {
    const auto outcome = run(folder,
                             "-scene file -scene_file in.h5 -pair contact -contact_modulus 30 "
                             "-contact_friction 0.4 -ts_dt 10 -ts_max_steps 20 -partition "
                             "dmda -state_output out.h5 -overwrite",
                             ranks);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    if (ranks == 1)
      expected = readFile(folder / "out.h5");
    else
      EXPECT_TRUE(readFile(folder / "out.h5") == expected) << ranks;
  }
}

TEST(ContactsWithFriction, ARestartGoesOnWithTheirSprings) {
  const Folder whole;
  auto outcome = run(whole, weave + outputs + "-ts_max_steps 600", 2);
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  for (const char* steps : {"137", "400"}) {
    const Folder pieces;
    outcome = run(pieces, weave + outputs + "-checkpoint_file c.h5 -ts_max_steps " + steps, 3);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    outcome = run(pieces, outputs + "-restart c.h5 -ts_max_steps 600", 1, 2);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_TRUE(readFile(pieces / "out.h5") == readFile(whole / "out.h5")) << steps;
  }
}

}  // namespace
}  // namespace nanoweft::test
