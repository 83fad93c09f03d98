/// The state file on several ranks: every field of the table comes back, and the ranks do not show.
#include "nanoweft/state/state_file.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "middle/segments.hpp"
#include "nanoweft/base/error.hpp"
#include "unit/state_helpers.hpp"

namespace nanoweft::test {
namespace {

/// A folder that all ranks know.
class SharedPlace {
 public:
  SharedPlace() {
    int rank;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    char path[256] = "";
    if (rank == 0) std::strncpy(path, (place_.emplace() / "").c_str(), sizeof path - 1);
    MPI_Bcast(path, sizeof path, MPI_CHAR, 0, PETSC_COMM_WORLD);
    path_ = path;
  }
  ~SharedPlace() { MPI_Barrier(PETSC_COMM_WORLD); }
  SharedPlace(const SharedPlace&) = delete;
  SharedPlace& operator=(const SharedPlace&) = delete;
  std::string operator/(const std::string& name) const { return path_ + name; }

 private:
  std::optional<Place> place_;
  std::string path_;
};

void write(const std::string& file, State& state) {
  StateWriteOptions what;
  what.forces = true;
  writeState(file, state, nanoUnits(), testRecord(), what);
}

TEST(StateFile, EveryFieldOfTheTableComesBack) {
  const SharedPlace place;
  State written(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(written);
  write(place / "s.h5", written);
  const StateHeader header = readStateHeader(PETSC_COMM_WORLD, place / "s.h5");
  State read(PETSC_COMM_WORLD, header.box, allFields);
  readStateRows(place / "s.h5", header, read);
  EXPECT_EQ(read.total(), allRows);
  expectEveryRowOnce(read);
  const Reference reference;
  for (const Field& f : fields) {
    const bool otherwise = f.stored == Stored::no || f.stored == Stored::composed;
    EXPECT_TRUE(otherwise || header.parts.contains(f.name)) << f.name;
    // Forces are for other readers: a run computes them anew.
    for (int i = 0; i < read.owned(); ++i)
      ASSERT_EQ(reference.same(f, read, i), f.stored != Stored::withForces)
          << f.name << " of row " << read.row[i];
  }
}

TEST(StateFile, AStateWithoutExtraFieldsSkipsThoseOfTheFile) {
  const SharedPlace place;
  State written(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(written);
  write(place / "s.h5", written);
  const StateHeader header = readStateHeader(PETSC_COMM_WORLD, place / "s.h5");
  State read(PETSC_COMM_WORLD, header.box, {});
  readStateRows(place / "s.h5", header, read);
  const Reference reference;
  for (const Field& f : fields)
    for (int i = 0; i < read.owned() && !f.extra && f.stored != Stored::withForces; ++i)
      ASSERT_TRUE(reference.same(f, read, i)) << f.name << " of row " << read.row[i];
}

TEST(StateFile, HasTheSameBytesWhereverSegmentsLie) {
  const SharedPlace place;
  State state(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(state);
  write(place / "in_order.h5", state);
  Domain(state, {}).rebuild(state, 15, 15, nullptr);
  write(place / "by_cells.h5", state);
  if (state.rank() != 0) return;
  State alone(PETSC_COMM_SELF, sceneBox(), allFields);
  fillScene(alone);
  write(place / "alone.h5", alone);
  const std::string bytes = bytesOf(place / "in_order.h5");
  EXPECT_GT(bytes.size(), 10000u);
  EXPECT_TRUE(bytes == bytesOf(place / "by_cells.h5"));
  EXPECT_TRUE(bytes == bytesOf(place / "alone.h5"));
}

TEST(StateFile, AllRanksRefuseTheSameRow) {
  const SharedPlace place;
  State written(PETSC_COMM_WORLD, sceneBox(), allFields);
  fillScene(written);
  for (int i = 0; i < written.owned(); ++i)
    if (written.row[i] == 41) written.viscous[6 * i + 5] = std::numeric_limits<double>::infinity();
  write(place / "s.h5", written);
  const StateHeader header = readStateHeader(PETSC_COMM_WORLD, place / "s.h5");
  State read(PETSC_COMM_WORLD, header.box, allFields);
  try {
    readStateRows(place / "s.h5", header, read);
    ADD_FAILURE() << "it was read";
  } catch (const InputError& problem) {
    EXPECT_NE(std::string(problem.what()).find("row 41 (fibre 105, index 1): its viscous"),
              std::string::npos)
        << problem.what();
  }
}

}  // namespace
}  // namespace nanoweft::test
