/// What all ranks must have in common.
#include <gtest/gtest.h>
#include <petscsys.h>

#include "nanoweft/app/settings.hpp"
#include "nanoweft/base/error.hpp"

namespace nanoweft::test {
namespace {

TEST(Ranks, ProgramsForOtherInstructionsAreRefusedByAll) {
  int rank, ranks;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  EXPECT_NO_THROW(requireSameInstructions(PETSC_COMM_WORLD, "avx2"));
  if (ranks == 1) return;
  try {
    requireSameInstructions(PETSC_COMM_WORLD, rank == ranks - 1 ? "sse2" : "avx512");
    ADD_FAILURE() << "not refused on rank " << rank;
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("sse2, rank 0 that for avx512"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace nanoweft::test
