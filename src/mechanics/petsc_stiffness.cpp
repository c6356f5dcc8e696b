// SPDX-License-Identifier: GPL-3.0-or-later
#include "petsc_stiffness.h"

#include "common/index.h"
#include "parallel/agreement.h"

#include <algorithm>

namespace crackle::mechanics {

using parallel::check_petsc;

namespace {

/// Upper bound on PETSc's memory per block, per node and for the rest of a matrix [byte].
constexpr std::size_t bytes_per_block = 2 * (9 * sizeof(double) + sizeof(PetscInt));
constexpr std::size_t bytes_per_node = 512;
constexpr std::size_t bytes_per_matrix = 1 << 20;

/// V B^T C B of corners a and b, per volume: lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) I.
Matrix intact_coupling(const TetrahedronOperator& t, const IsotropicElasticity& elasticity, std::size_t a,
                       std::size_t b) {
  const Vector &g = t.gradient[a], &h = t.gradient[b];
  Matrix block{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      block[i][j] = elasticity.lambda * g[i] * h[j] + elasticity.mu * h[i] * g[j];
    block[i][i] += elasticity.mu * dot(g, h);
  }
  return block;
}

}  // namespace

PetscStiffness::PetscStiffness(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                               const PdsOperators& operators, const ElasticityField& elasticity,
                               const ResidualStiffness& residual_stiffness)
    : operators_(&operators),
      elasticity_(&elasticity),
      residual_stiffness_(&residual_stiffness),
      n_owned_(subdomain.layout.n_owned),
      node_to_cell_(node_tetrahedra(subdomain)) {
  const auto& layout = subdomain.layout;
  const auto first = static_cast<PetscInt>(layout.first_owned[index(group.rank())]);
  const PetscInt end = first + n_owned_;
  for (std::int32_t node = 0; node < n_owned_; ++node) number_.push_back(first + node);
  for (const auto& ghost : layout.ghosts)
    number_.push_back(static_cast<PetscInt>(layout.first_owned[index(ghost.rank)] + ghost.node));
  std::vector<PetscInt> n_own_columns, n_other_columns;  // of each row
  std::size_t n_blocks = 0;
  for (std::int32_t node = 0; node < n_owned_; ++node) {
    find_columns(node);
    const auto n_own = std::ranges::lower_bound(columns_, end) - columns_.begin();
    n_own_columns.push_back(static_cast<PetscInt>(n_own));
    n_other_columns.push_back(static_cast<PetscInt>(columns_.size()) - n_own_columns.back());
    n_blocks += columns_.size();
  }
  parallel::check_room(bytes_per_block * n_blocks + bytes_per_node * number_.size() + bytes_per_matrix);
  parallel::check_peers(group);
  const PetscInt n = 3 * n_owned_;
  check_petsc(MatCreateSBAIJ(group.get(), 3, n, n, PETSC_DETERMINE, PETSC_DETERMINE, 0, n_own_columns.data(),
                             0, n_other_columns.data(), matrix_.put()),
              "MatCreateSBAIJ");
  check_petsc(MatSetOption(matrix_.get(), MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE), "MatSetOption");
  parallel::agree(group, [&] {
    for (std::int32_t node = 0; node < n_owned_; ++node) set_row(node);
  });
  assemble();
  // From here on PETSc need not search for new nonzeros, which requires communication.
  check_petsc(MatSetOption(matrix_.get(), MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE), "MatSetOption");
  // The first product allocates, later ones do not.
  parallel::NodeField nothing(group, layout), result(group, layout);
  apply(nothing, result);
}

void PetscStiffness::apply(parallel::NodeField& displacement, parallel::NodeField& force) const {
  displacement.mark_changed();
  check_petsc(MatMult(matrix_.get(), displacement.vector(), force.vector()), "MatMult");
}

void PetscStiffness::update(std::span<const std::int32_t> tetrahedra) {
  std::vector<std::int32_t> rows;
  for (const auto t : tetrahedra)
    for (const auto node : operators_->tetrahedra[index(t)].nodes)
      if (node < n_owned_) rows.push_back(node);
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  for (const auto node : rows) set_row(node);
}

void PetscStiffness::assemble() {
  check_petsc(MatAssemblyBegin(matrix_.get(), MAT_FINAL_ASSEMBLY), "MatAssemblyBegin");
  check_petsc(MatAssemblyEnd(matrix_.get(), MAT_FINAL_ASSEMBLY), "MatAssemblyEnd");
}

void PetscStiffness::find_columns(std::int32_t node) {
  columns_.clear();
  for (const auto t : node_to_cell_[node])
    for (const auto other : operators_->tetrahedra[index(t)].nodes)
      if (number_[index(other)] >= number_[index(node)]) columns_.push_back(number_[index(other)]);
  std::ranges::sort(columns_);
  columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
}

/// Sums over the residual stiffness of the tetrahedra around the node, in ascending order.
void PetscStiffness::set_row(std::int32_t node) {
  find_columns(node);
  const std::size_t n = columns_.size();
  values_.assign(9 * n, 0.0);
  for (const auto number : node_to_cell_[node]) {
    if (!residual_stiffness_->carries(number)) continue;
    const auto& t = operators_->tetrahedra[index(number)];
    const auto a = static_cast<std::size_t>(std::ranges::find(t.nodes, node) - t.nodes.begin());
    for (std::size_t b = 0; b < 4; ++b) {
      const PetscInt column = number_[index(t.nodes[b])];
      if (column < number_[index(node)]) continue;
      const auto place =
          static_cast<std::size_t>(std::ranges::lower_bound(columns_, column) - columns_.begin());
      const Matrix block = residual_stiffness_->is_intact(number)
                               ? intact_coupling(t, (*elasticity_)[number], a, b)
                               : residual_stiffness_->partial(number).coupling(a, b);
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) values_[3 * (n * i + place) + j] += t.volume * block[i][j];
    }
  }
  check_petsc(MatSetValuesBlocked(matrix_.get(), 1, &number_[index(node)], static_cast<PetscInt>(n),
                                  columns_.data(), values_.data(), INSERT_VALUES),
              "MatSetValuesBlocked");
}

}  // namespace crackle::mechanics
