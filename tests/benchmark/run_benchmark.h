// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <petscsys.h>

#include <cstdio>
#include <exception>

namespace crackle {

/// Runs a program's work between the start and the end of MPI and PETSc. @return its exit status
template <class Work>
int run_benchmark(const char* name, const Work& work) {
  PetscInitialize(nullptr, nullptr, nullptr, nullptr);
  int status = 0;
  try {
    work();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    status = 1;
  }
  PetscFinalize();
  return status;
}

}  // namespace crackle
