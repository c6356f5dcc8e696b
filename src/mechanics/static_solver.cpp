// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/mechanics/static_solver.h"

#include "crackle/parallel/exact_sum.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace crackle::mechanics {

namespace {

using parallel::check_petsc;

/// Residual that counts as equilibrium, relative to the load and to the first residual of the unloaded guess.
constexpr double relative_tolerance = 1e-10;
constexpr int max_iterations = 2000;
/// The preconditioner is made anew when it needs this many times the iterations it needed when it was fresh.
constexpr double wear_limit = 2.5;
/// Stiffness added at nodes that have lost a tetrahedron, relative to a typical diagonal entry. Pieces that
/// hang by an edge or a corner, or by nothing, would make the matrix singular; this holds them without
/// carrying load.
constexpr double loose_node_stiffness = 1e-9;

using Block = std::array<double, 9>;

/// K^ab = V (lambda b^a (x) b^b + mu b^b (x) b^a + mu (b^a . b^b) I).
void add_stiffness(const TetrahedronOperator& t, const IsotropicElasticity& c, std::size_t a, std::size_t b,
                   Block& block) {
  const Vector& ga = t.gradient[a];
  const Vector& gb = t.gradient[b];
  const double product = c.mu * dot(ga, gb);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double k = c.lambda * ga[i] * gb[j] + c.mu * gb[i] * ga[j];
      if (i == j) k += product;
      block[3 * i + j] += t.volume * k;
    }
  }
}

}  // namespace

StaticSolver::StaticSolver(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const PdsOperators& operators, const IsotropicElasticity& elasticity,
                           const InternalForce& force, HeldComponents held)
    : group_(&group),
      subdomain_(&subdomain),
      operators_(&operators),
      elasticity_(elasticity),
      force_(&force),
      held_(std::move(held)),
      round_node_(node_tetrahedra(subdomain)),
      broken_(subdomain.tetrahedra.size(), 0),
      residual_(group, subdomain),
      correction_(group, subdomain) {
  std::vector<double> volumes;
  for (std::size_t t = 0; t < operators.tetrahedra.size(); ++t) {
    if (subdomain.counted[t] != 0) volumes.push_back(operators.tetrahedra[t].volume);
  }
  const double volume = parallel::exact_sum(group, volumes);
  typical_stiffness_ = (elasticity.lambda + 2 * elasticity.mu) *
                       std::cbrt(volume / static_cast<double>(subdomain.n_tetrahedra_global));

  const auto n_owned = static_cast<std::size_t>(subdomain.n_owned);
  std::vector<PetscInt> n_diagonal(n_owned), n_off_diagonal(n_owned);
  std::vector<std::int32_t> neighbours;
  for (std::size_t node = 0; node < n_owned; ++node) {
    neighbours.clear();
    for (const auto t : round_node_[static_cast<std::int32_t>(node)]) {
      const auto& corners = subdomain.tetrahedra[static_cast<std::size_t>(t)];
      neighbours.insert(neighbours.end(), corners.begin(), corners.end());
    }
    std::ranges::sort(neighbours);
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
    const auto first_ghost = std::ranges::lower_bound(neighbours, subdomain.n_owned);
    n_diagonal[node] = static_cast<PetscInt>(first_ghost - neighbours.begin());
    n_off_diagonal[node] = static_cast<PetscInt>(neighbours.end() - first_ghost);
  }
  check_petsc(MatCreate(group.get(), matrix_.put()), "MatCreate");
  check_petsc(MatSetSizes(matrix_.get(), 3 * subdomain.n_owned, 3 * subdomain.n_owned, PETSC_DETERMINE,
                          PETSC_DETERMINE),
              "MatSetSizes");
  check_petsc(MatSetBlockSize(matrix_.get(), 3), "MatSetBlockSize");
  check_petsc(MatSetType(matrix_.get(), MATAIJ), "MatSetType");
  check_petsc(
      MatXAIJSetPreallocation(matrix_.get(), 3, n_diagonal.data(), n_off_diagonal.data(), nullptr, nullptr),
      "MatXAIJSetPreallocation");
  check_petsc(MatSetOption(matrix_.get(), MAT_SPD, PETSC_TRUE), "MatSetOption");

  std::vector<std::int32_t> all(n_owned);
  std::iota(all.begin(), all.end(), 0);
  insert_rows(all);

  parallel::NodeField coordinates(group, subdomain);
  for (std::size_t node = 0; node < n_owned; ++node) {
    std::ranges::copy(subdomain.nodes[node],
                      coordinates.owned().begin() + static_cast<std::ptrdiff_t>(3 * node));
  }
  check_petsc(MatNullSpaceCreateRigidBody(coordinates.vector(), rigid_modes_.put()),
              "MatNullSpaceCreateRigidBody");
  check_petsc(MatSetNearNullSpace(matrix_.get(), rigid_modes_.get()), "MatSetNearNullSpace");

  check_petsc(KSPCreate(group.get(), ksp_.put()), "KSPCreate");
  check_petsc(KSPSetType(ksp_.get(), KSPCG), "KSPSetType");
  check_petsc(KSPSetNormType(ksp_.get(), KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
  check_petsc(KSPSetOperators(ksp_.get(), matrix_.get(), matrix_.get()), "KSPSetOperators");
  PC preconditioner = nullptr;
  check_petsc(KSPGetPC(ksp_.get(), &preconditioner), "KSPGetPC");
  check_petsc(PCSetType(preconditioner, PCGAMG), "PCSetType");
  check_petsc(KSPSetReusePreconditioner(ksp_.get(), PETSC_TRUE), "KSPSetReusePreconditioner");
}

void StaticSolver::insert_rows(std::span<const std::int32_t> nodes) {
  std::vector<std::int32_t> neighbours;
  std::vector<Block> blocks;
  std::vector<PetscInt> columns;
  std::vector<double> values;
  for (const auto node : nodes) {
    if (node >= subdomain_->n_owned) continue;
    neighbours.clear();
    for (const auto t : round_node_[node]) {
      const auto& corners = subdomain_->tetrahedra[static_cast<std::size_t>(t)];
      neighbours.insert(neighbours.end(), corners.begin(), corners.end());
    }
    std::ranges::sort(neighbours);
    neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
    blocks.assign(neighbours.size(), Block{});
    bool has_lost_one = false;
    for (const auto t : round_node_[node]) {
      if (broken_[static_cast<std::size_t>(t)] != 0) {
        has_lost_one = true;
        continue;
      }
      const auto& tetrahedron = operators_->tetrahedra[static_cast<std::size_t>(t)];
      const auto a =
          static_cast<std::size_t>(std::ranges::find(tetrahedron.nodes, node) - tetrahedron.nodes.begin());
      for (std::size_t b = 0; b < 4; ++b) {
        const auto place = std::ranges::lower_bound(neighbours, tetrahedron.nodes[b]);
        add_stiffness(tetrahedron, elasticity_, a, b,
                      blocks[static_cast<std::size_t>(place - neighbours.begin())]);
      }
    }
    columns.clear();
    values.assign(9 * neighbours.size(), 0.0);
    for (std::size_t n = 0; n < neighbours.size(); ++n) {
      const auto neighbour = static_cast<std::size_t>(neighbours[n]);
      columns.push_back(static_cast<PetscInt>(subdomain_->distributed_number[neighbour]));
      for (std::size_t i = 0; i < 3; ++i) {
        const bool row_held = held_[3 * static_cast<std::size_t>(node) + i] != 0;
        for (std::size_t j = 0; j < 3; ++j) {
          double value = blocks[n][3 * i + j];
          if (row_held || held_[3 * neighbour + j] != 0) value = 0;
          if (neighbours[n] == node && i == j) {
            if (row_held) value = typical_stiffness_;
            if (!row_held && has_lost_one) value += loose_node_stiffness * typical_stiffness_;
          }
          values[i * 3 * neighbours.size() + 3 * n + j] = value;
        }
      }
    }
    const auto row = static_cast<PetscInt>(subdomain_->distributed_number[static_cast<std::size_t>(node)]);
    check_petsc(MatSetValuesBlocked(matrix_.get(), 1, &row, static_cast<PetscInt>(columns.size()),
                                    columns.data(), values.data(), INSERT_VALUES),
                "MatSetValuesBlocked");
  }
  check_petsc(MatAssemblyBegin(matrix_.get(), MAT_FINAL_ASSEMBLY), "MatAssemblyBegin");
  check_petsc(MatAssemblyEnd(matrix_.get(), MAT_FINAL_ASSEMBLY), "MatAssemblyEnd");
}

void StaticSolver::release(std::span<const std::int32_t> tetrahedra) {
  std::vector<std::int32_t> nodes;
  for (const auto t : tetrahedra) {
    broken_[static_cast<std::size_t>(t)] = 1;
    const auto& corners = subdomain_->tetrahedra[static_cast<std::size_t>(t)];
    nodes.insert(nodes.end(), corners.begin(), corners.end());
  }
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  insert_rows(nodes);
}

int StaticSolver::run_solver(double reference_norm) {
  check_petsc(KSPSetTolerances(ksp_.get(), 0.0, relative_tolerance * reference_norm, 1e10, max_iterations),
              "KSPSetTolerances");
  check_petsc(KSPSolve(ksp_.get(), residual_.vector(), correction_.vector()), "KSPSolve");
  int iterations = 0;
  check_petsc(KSPGetIterationNumber(ksp_.get(), &iterations), "KSPGetIterationNumber");
  return iterations;
}

int StaticSolver::solve(std::span<const double> force, parallel::NodeField& displacement) {
  // The guess, held components included, is carried to the right-hand side: K_ff du = f - K u_guess.
  displacement.update_ghosts();
  const auto residual = residual_.local();
  force_->evaluate(displacement.local(), residual);
  std::vector<double> squares;
  for (std::size_t i = 0; i < force.size(); ++i) {
    const double internal = held_[i] != 0 ? 0 : residual[i];
    const double external = held_[i] != 0 ? 0 : force[i];
    squares.push_back(std::max(external * external, internal * internal));
    residual[i] = external - internal;
  }
  const double reference = std::sqrt(parallel::exact_sum(*group_, squares));
  if (reference == 0) return 0;
  residual_.mark_changed();

  int iterations = run_solver(reference);
  KSPConvergedReason reason{};
  check_petsc(KSPGetConvergedReason(ksp_.get(), &reason), "KSPGetConvergedReason");
  const bool is_fresh = fresh_iterations_ == 0;
  if (!is_fresh && (reason < 0 || iterations > wear_limit * fresh_iterations_ + 10)) {
    // Worn out: the next solve, or this one again where it failed, makes the preconditioner anew.
    check_petsc(KSPSetReusePreconditioner(ksp_.get(), PETSC_FALSE), "KSPSetReusePreconditioner");
    check_petsc(KSPSetUp(ksp_.get()), "KSPSetUp");
    check_petsc(KSPSetReusePreconditioner(ksp_.get(), PETSC_TRUE), "KSPSetReusePreconditioner");
    fresh_iterations_ = 0;
    if (reason < 0) {
      iterations += run_solver(reference);
      check_petsc(KSPGetConvergedReason(ksp_.get(), &reason), "KSPGetConvergedReason");
      fresh_iterations_ = iterations;
    }
  } else if (is_fresh) {
    fresh_iterations_ = std::max(iterations, 1);
  }
  if (reason < 0) {
    throw NoEquilibrium("static equilibrium: no convergence in " + std::to_string(iterations) +
                        " iterations (PETSc reason " + std::to_string(static_cast<int>(reason)) + ")");
  }
  const auto correction = correction_.owned();
  const auto result = displacement.owned();
  for (std::size_t i = 0; i < result.size(); ++i) result[i] += correction[i];
  displacement.update_ghosts();
  return iterations;
}

}  // namespace crackle::mechanics
