/// What a thermostat refuses, and what runs without one do not have.
#include <gtest/gtest.h>

#include "support/expect.hpp"
#include "support/program.hpp"

using namespace nanoweft::test;

namespace {

const std::string fibre =
    "-scene fibre -fibre_segments 6 -pair none -ts_max_steps 4 -progress_interval 0 ";

TEST(BadTemperature, IsRefusedWithWhatWouldBeRight) {
  const struct {
    const char *options, *says[2];
  } cases[] = {
      {"-temperature -3 -temperature_damping 1e-3", {"-temperature", "-3"}},
      {"-temperature warm -temperature_damping 1e-3", {"-temperature", "warm"}},
      {"-temperature nan -temperature_damping 1e-3", {"-temperature", "nan"}},
      {"-temperature 300",
       {"give -temperature_damping",
        "(1/fs) at which velocities follow the thermostat; 0.001 lets"}},
      {"-temperature 300 -units si",
       {"give -temperature_damping",
        "(1/s) at which velocities follow the thermostat; 1e+12 lets"}},
      {"-temperature 300 -temperature_damping 0", {"-temperature_damping", "0"}},
      {"-temperature_damping 1e-3", {"-temperature_damping", "-temperature is not set"}},
      {"-temperature_start", {"-temperature_start", "-temperature is not set"}},
      {"-temperature 300 -temperature_damping 1e-3 -relax_method fire",
       {"-temperature", "-relax_method fire seeks rest"}},
      {"-temperature 300 -temperature_damping 1e-3 -relax_force 1e-3",
       {"-temperature 300", "no rest"}},
      {"-temperature 300 -temperature_damping 1e-3 -relax_tolerance 1e-3",
       {"-temperature 300", "no rest"}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.options);
    expectRefused(run(Folder(), fibre + c.options), {c.says[0], c.says[1]});
  }
}

TEST(BadTemperature, OnARestartIsThatOfTheCheckpoint) {
  const Folder folder;
  expectDone(
      run(folder, fibre + "-temperature 300 -temperature_damping 1e-3 -checkpoint_file c.h5"));
  expectRefused(run(folder, "-restart c.h5 -temperature 400 -ts_max_steps 8"),
                {"-temperature 400", "300"});
  expectDone(run(folder, "-restart c.h5 -ts_max_steps 8"));
}

TEST(Temperature, LeavesNothingInRunsWithoutOne) {
  const Folder folder;
  const std::string table = "-energy_monitor ascii:e.csv ";
  expectDone(run(folder, fibre + table + "-state_output cold.h5"));
  EXPECT_FALSE(readCsv(folder / "e.csv").contains("heat"));
  EXPECT_EQ(readFile(folder / "cold.h5").find("account_heat"), std::string::npos);
  expectDone(run(folder, fibre + table +
                             "-state_output hot.h5 -overwrite -temperature 300 "
                             "-temperature_damping 1e-3"));
  EXPECT_TRUE(readCsv(folder / "e.csv").contains("heat"));
  EXPECT_NE(readFile(folder / "hot.h5").find("account_heat"), std::string::npos);
}

TEST(Temperature, InSiUnitsIsThatInNanoUnits) {
  // The same tube in both: draws and so the motion are the same.
  const Folder nano, si;
  const std::string same =
      "-scene fibre -fibre_segments 6 -pair none -ts_max_steps 50 -progress_interval 0 "
      "-temperature 300 -temperature_start -energy_monitor ascii:e.csv ";
  expectDone(run(nano, same + "-temperature_damping 1e-3 -ts_dt 10"));
  expectDone(run(si, same + "-units si -temperature_damping 1e12 -ts_dt 1e-14"));
  const auto a = readCsv(nano / "e.csv"), b = readCsv(si / "e.csv");
  for (const char* part : {"kinetic", "rotational", "stretch", "heat"})
    EXPECT_NEAR(b.at(part).back() / a.at(part).back() / 1.602176634e-19, 1, 1e-5) << part;
}

}  // namespace
