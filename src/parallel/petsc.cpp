// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/petsc.h"

#include <new>
#include <stdexcept>
#include <string>

namespace crackle::parallel {

void check_petsc(PetscErrorCode code, const char* call) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw std::runtime_error(std::string(call) + ": " + (text != nullptr ? text : "unknown PETSc error"));
}

void check_room(std::size_t n_bytes) {
  // Not a new-expression, which a compiler may optimize away.
  ::operator delete(::operator new(n_bytes));
}

}  // namespace crackle::parallel
