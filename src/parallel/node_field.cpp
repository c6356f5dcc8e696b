// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel/node_field.h"

#include "common/index.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <algorithm>

namespace crackle::parallel {

namespace {

/// Upper bounds on PETSc's memory per node for values, and per ghost for the exchange [byte].
constexpr std::size_t bytes_per_node = 3 * sizeof(double);
constexpr std::size_t bytes_per_ghost = 256;
constexpr std::size_t bytes_per_vector = 1 << 18;

}  // namespace

NodeField::NodeField(const Communicator& group, const NodeLayout& layout) {
  std::vector<PetscInt> ghosts;
  ghosts.reserve(layout.ghosts.size());
  for (const auto& ghost : layout.ghosts)
    ghosts.push_back(static_cast<PetscInt>(layout.first_owned[index(ghost.rank)] + ghost.node));
  check_room(bytes_per_node * layout.number.size() + bytes_per_ghost * ghosts.size() + bytes_per_vector);
  check_peers(group);
  n_owned_ = 3 * index(layout.n_owned);
  check_petsc(VecCreateGhostBlock(group.get(), 3, static_cast<PetscInt>(n_owned_), PETSC_DECIDE,
                                  static_cast<PetscInt>(ghosts.size()), ghosts.data(), global_.put()),
              "VecCreateGhostBlock");
  check_petsc(VecGhostGetLocalForm(global_.get(), &ghosted_), "VecGhostGetLocalForm");
  check_petsc(VecSet(ghosted_, 0), "VecSet");
  double* values = nullptr;
  check_petsc(VecGetArray(ghosted_, &values), "VecGetArray");
  // PETSc does not move the storage during the vector's lifetime; the array is restored at once so that
  // PETSc's own operations can access the vector.
  values_ = {values, 3 * layout.number.size()};
  check_petsc(VecRestoreArray(ghosted_, &values), "VecRestoreArray");
  // The first exchange allocates, later ones do not.
  update_ghosts();
}

NodeField::~NodeField() {
  if (ghosted_ != nullptr) VecGhostRestoreLocalForm(global_.get(), &ghosted_);
}

NodeField::NodeField(NodeField&& other) noexcept
    : global_(std::move(other.global_)),
      ghosted_(std::exchange(other.ghosted_, nullptr)),
      values_(other.values_),
      n_owned_(other.n_owned_) {}

void NodeField::update_ghosts() {
  check_petsc(VecGhostUpdateBegin(global_.get(), INSERT_VALUES, SCATTER_FORWARD), "VecGhostUpdateBegin");
  check_petsc(VecGhostUpdateEnd(global_.get(), INSERT_VALUES, SCATTER_FORWARD), "VecGhostUpdateEnd");
}

void NodeField::mark_changed() {
  // Restoring an array invalidates the norms that PETSc caches with a vector.
  double* values = nullptr;
  check_petsc(VecGetArray(global_.get(), &values), "VecGetArray");
  check_petsc(VecRestoreArray(global_.get(), &values), "VecRestoreArray");
}

void NodeField::assign(const NodeField& other) {
  std::ranges::copy(other.values_, values_.begin());
}

std::vector<double> gather_nodes(const Communicator& group, const NodeLayout& layout,
                                 std::span<const double> owned) {
  const std::span<const std::int64_t> own_numbers = std::span(layout.number).first(index(layout.n_owned));
  const auto numbers = gather_on_root(group, own_numbers);
  const auto values = gather_on_root(group, owned);
  std::vector<double> ordered(values.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                ordered.begin() + static_cast<std::ptrdiff_t>(3 * numbers[i]));
  }
  return ordered;
}

}  // namespace crackle::parallel
