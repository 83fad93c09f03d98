/// Tests of classes that work on several ranks: each rank runs all of them, under mpirun.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <iostream>

namespace {

/// Prints failures alone.
class Failures : public testing::EmptyTestEventListener {
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (result.failed())
      std::cerr << result.file_name() << ":" << result.line_number() << ": " << result.message()
                << std::endl;
  }
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  int rank;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (auto& listeners = testing::UnitTest::GetInstance()->listeners(); rank != 0) {
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new Failures);
  }
  int status = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &status, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  PetscFinalize();
  return status;
}
