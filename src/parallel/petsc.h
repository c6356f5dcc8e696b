// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <petscksp.h>
#include <petscsf.h>

#include <cstddef>
#include <utility>

namespace crackle::parallel {

/// @throws std::runtime_error with PETSc's message unless `code` is 0
void check_petsc(PetscErrorCode code, const char* call);

/// Checks that there is memory for PETSc's next allocations: between its messages, a rank that fails to
/// allocate would leave the others waiting. Local.
/// @throws std::bad_alloc
void check_room(std::size_t n_bytes);

/// Move-only owner of a PETSc object. Destroying one is collective over its communicator.
template <class Handle, PetscErrorCode (*destroy)(Handle*)>
class PetscOwner {
public:
  PetscOwner() = default;
  explicit PetscOwner(Handle handle) : handle_(handle) {}
  ~PetscOwner() {
    if (handle_ != nullptr) destroy(&handle_);
  }
  PetscOwner(PetscOwner&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  PetscOwner& operator=(PetscOwner&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  PetscOwner(const PetscOwner&) = delete;
  PetscOwner& operator=(const PetscOwner&) = delete;

  Handle get() const { return handle_; }
  /// For PETSc's creation functions. @pre the owner is empty
  Handle* put() { return &handle_; }

private:
  Handle handle_ = nullptr;
};

using VecOwner = PetscOwner<Vec, VecDestroy>;
using MatOwner = PetscOwner<Mat, MatDestroy>;

}  // namespace crackle::parallel
