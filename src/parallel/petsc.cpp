// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/parallel/petsc.h"

#include <stdexcept>
#include <string>

namespace crackle::parallel {

void check_petsc(PetscErrorCode code, const char* call) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error(std::string(call) + ": " + (text != nullptr ? text : "unknown PETSc error"));
}

}  // namespace crackle::parallel
