// SPDX-License-Identifier: GPL-3.0-or-later
#include "runtime.h"

#include <petscsys.h>

#include <cstdlib>
#include <stdexcept>

namespace crackle::apps {

Runtime::Runtime() {
  if (!start()) throw std::runtime_error("MPI or PETSc could not be started");
}

Runtime::~Runtime() {
  PetscFinalize();
}

bool Runtime::start() {
  // A stray .petscrc or options in the environment must not change results; signals are handled by the
  // program itself; errors are returned as codes, which callers turn into a single message.
  ::unsetenv("PETSC_OPTIONS");
  ::unsetenv("PETSC_OPTIONS_YAML");
  return PetscInitialize(&n_arguments_, &arguments_, nullptr, nullptr) == 0 && PetscPopSignalHandler() == 0 &&
         PetscPushErrorHandler(PetscReturnErrorHandler, nullptr) == 0;
}

}  // namespace crackle::apps
