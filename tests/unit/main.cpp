#include <gtest/gtest.h>
#include <petscsys.h>

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  PetscInitialize(&argc, &argv, nullptr, nullptr);
  const int status = RUN_ALL_TESTS();
  PetscFinalize();
  return status;
}
