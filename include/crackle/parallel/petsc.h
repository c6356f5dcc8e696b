// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <petscksp.h>
#include <petscsf.h>

#include <cstddef>
#include <span>
#include <utility>

namespace crackle::parallel {

/// @throws std::runtime_error with PETSc's message unless `code` is 0
void check_petsc(PetscErrorCode code, const char* call);

/// That there is memory for what PETSc is about to allocate: between its messages a rank without memory would
/// leave the others waiting. Local.
/// @throws std::bad_alloc
void check_room(std::size_t n_bytes);

/// Calls work(), for functions that PETSc calls: an exception must not pass through its C code, so it ends in
/// PETSc's error code.
template <class Work>
PetscErrorCode without_exceptions(const Work& work) noexcept {
  try {
    work();
    return 0;
  } catch (...) {
    return PETSC_ERR_LIB;
  }
}

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
  /// For PETSc's creating functions. @pre the owner is empty
  Handle* put() { return &handle_; }

private:
  Handle handle_ = nullptr;
};

using VecOwner = PetscOwner<Vec, VecDestroy>;
using MatOwner = PetscOwner<Mat, MatDestroy>;
using PcOwner = PetscOwner<PC, PCDestroy>;

/// This rank's owned values of a vector, given back to PETSc at the end of the object's life. Local.
template <class Value, PetscErrorCode (*get)(Vec, Value**), PetscErrorCode (*restore)(Vec, Value**)>
class VecValues {
public:
  /// @throws std::runtime_error with PETSc's message
  explicit VecValues(Vec vector) : vector_(vector) {
    PetscInt n = 0;
    check_petsc(VecGetLocalSize(vector, &n), "VecGetLocalSize");
    check_petsc(get(vector, &array_), "VecGetArray");
    size_ = static_cast<std::size_t>(n);
  }
  ~VecValues() { restore(vector_, &array_); }
  VecValues(const VecValues&) = delete;
  VecValues& operator=(const VecValues&) = delete;

  std::span<Value> operator*() const { return {array_, size_}; }

private:
  Vec vector_;
  Value* array_ = nullptr;
  std::size_t size_ = 0;
};

using ReadValues = VecValues<const double, VecGetArrayRead, VecRestoreArrayRead>;
using WrittenValues = VecValues<double, VecGetArray, VecRestoreArray>;

}  // namespace crackle::parallel
