// SPDX-License-Identifier: GPL-3.0-or-later
// main() of every GoogleTest program: starts MPI and PETSc, and fails on all ranks when one rank fails.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <cstdlib>

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (PetscInitializeNoArguments() != 0) return EXIT_FAILURE;
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
  }
  int failed = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (PetscFinalize() != 0) return EXIT_FAILURE;
  return failed;
}
