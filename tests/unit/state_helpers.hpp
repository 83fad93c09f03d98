/// Shared by the tests of state files: a state with all that a file can hold, and its file.
#pragma once

#include <petscsys.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "nanoweft/base/units.hpp"
#include "nanoweft/state/state_file.hpp"

namespace nanoweft::test {

/// A folder of its own for a test, removed afterwards.
class Place {
 public:
  Place() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "nanoweft-unit-XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~Place() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  /// Names in the folder, each followed by a blank.
  std::string names() const {
    std::string all;
    for (const auto& entry : std::filesystem::directory_iterator(path_))
      all += entry.path().filename().string() + " ";
    return all;
  }

 private:
  std::filesystem::path path_;
};

inline std::string bytesOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

inline void setBytes(const std::string& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// An open fibre of four segments and a ring of three, with something in every field.
inline void fillState(State& state) {
  state.addOwned(7);
  for (int i = 0; i < 7; ++i) {
    state.row[i] = i;
    state.fibre[i] = i < 4 ? -5 : 1234567890123;
    state.chain[2 * i] = i < 4 ? i : i - 4;
    state.chain[2 * i + 1] = i < 4 ? 4 : 3;
    state.bond[i] = i < 4 ? (i == 1 ? nextBroken : 0) : fibreClosed;
    state.group[i] = 1 << i;
    for (int d = 0; d < 3; ++d) {
      state.pose[8 * i + d] = 0.1 + i + 0.3 * d;
      state.velocity[3 * i + d] = 1e-3 / (1 + i + d);
      state.angular[3 * i + d] = -1e-5 * (i + d);
      state.force[3 * i + d] = i - d;
      state.image[3 * i + d] = i - 2 * d;
    }
    state.setOrientation(i, {0.6, 0, 0.8, 0});
    for (int c = 0; state.gap && c < 4; ++c) state.gap[4 * i + c] = (1ll << 60) + i;
    for (int c = 0; state.viscous && c < 6; ++c) state.viscous[6 * i + c] = 1.0 / 3 + c;
  }
  state.countTotal();
  state.step = 42;
  state.time = 0.1 + 0.2;
}

inline Box testBox() {
  Box box;
  box.lower = {0, 0, 0}, box.upper = {10, 11, 12}, box.periodic = {true, true, true};
  return box;
}

inline Provenance testRun(const std::string& options = "-seed 1\n") {
  return {"nanoweft", "9.9", options, ""};
}

inline RunRecord testRecord(const std::string& options = "-seed 1\n") {
  RunRecord record;
  record.reals["tension"] = {1.5, -2.25};
  record.integers["account_damped"] = {-1, 7, INT64_MAX};
  record.texts = provenanceTexts(testRun(options), "checkpoint");
  return record;
}

/// Writes that state.
inline void writeTestState(const std::string& file, const std::string& options = "-seed 1\n") {
  State state(PETSC_COMM_SELF, testBox(), {.gap = true, .viscous = true});
  fillState(state);
  StateWriteOptions what;
  what.forces = what.mesh = true;
  what.fields.push_back({"length", std::vector<float>(7, 2.5f)});
  writeState(file, state, nanoUnits(), testRecord(options), what);
}

}  // namespace nanoweft::test
