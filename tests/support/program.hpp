/// Running the program itself under mpirun, and reading and making its files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "nanoweft/base/vec.hpp"

namespace nanoweft::test {

/// A folder of its own for a test, removed afterwards.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

struct Outcome {
  int status;
  std::string output;  ///< standard output and error
};

/// Runs nanoweft in `folder`: one rank without mpirun, which takes a while to start and to end.
Outcome run(const Folder& folder, const std::string& options, int ranks = 1, int threads = 1);
/// As run, where each rank's shell does `first` before it becomes the program, as in "ulimit -f
/// 60".
Outcome runAfter(const Folder& folder, const std::string& first, const std::string& options,
                 int ranks = 1);
/// As run, with a shell command that runs beside it and finds the process id of mpirun in $PID.
Outcome runBeside(const Folder& folder, const std::string& options, int ranks,
                  const std::string& beside);

/// Shell commands that set what every start of the program in a test needs. Open MPI's runs that
/// begin and end at the same time take a shared session folder away from each other: each test has
/// one of its own, and two runs of a test beside each other have two, by the name `session`.
std::string environment(const Folder& folder, int threads = 1,
                        const std::string& session = "first");

std::string readFile(const std::string& file);
void writeText(const std::string& file, const std::string& text);
/// Columns of a CSV file by name; lines at its head that begin with # are left out.
std::map<std::string, std::vector<double>> readCsv(const std::string& file);
/// A dataset of a state file, as doubles, rows after each other.
std::vector<double> readDataset(const std::string& file, const std::string& name);

/// A fibre to put into a state file.
struct FibreInput {
  std::vector<Vec3d> position;
  std::vector<Quatd> orientation;
  bool closed = false;
};
struct BoxInput {
  std::array<double, 3> lower{-1000, -1000, -1000}, upper{1000, 1000, 1000};
  std::array<bool, 3> periodic{false, false, false};
};
/// Writes a state file as an outsider would: with the required datasets only.
void writeState(const std::string& file, const std::vector<FibreInput>& fibres,
                const BoxInput& box = {});

/// A straight fibre of `segments` segments of 13.56 A.
FibreInput straightFibre(const Vec3d& start, const Vec3d& direction, int segments);

}  // namespace nanoweft::test
