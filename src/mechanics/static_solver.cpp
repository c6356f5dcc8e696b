// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/mechanics/static_solver.h"

#include "crackle/common/failure.h"
#include "crackle/common/index.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/reproducible.h"

#include "coarse_space.h"
#include "stiffness_product.h"

#include <algorithm>
#include <cmath>

namespace crackle::mechanics {

namespace {

using parallel::check_petsc;

/// Residual that counts as equilibrium, in the norm that the preconditioner defines, relative to that of the
/// loads: near the relative error of the displacement's energy norm.
constexpr double relative_tolerance = 1e-10;
/// The residual that conjugate gradients carry along drifts from the true one; another run makes up for it.
constexpr double drift_allowance = 3;
constexpr int max_runs = 4;
/// After so many runs what is left is the rounding of the product: more of it where long thin parts move far
/// under little load. Up to this, relative to the loads, that is an equilibrium.
constexpr double rounding_allowance = 1e-7;
constexpr int max_iterations = 4000;
/// The coarse matrix is made anew when a run needs this many times the iterations it needed when it was
/// fresh.
constexpr double wear_limit = 1.5;

/// The inverse of a symmetric positive definite 3 x 3 matrix on its components that are not held; zero where
/// the node carries nothing.
Symmetric inverse_on_free(const Symmetric& k, const std::uint8_t* held) {
  Symmetric m = k;
  if (held[0] != 0) m[4] = m[5] = 0;
  if (held[1] != 0) m[3] = m[5] = 0;
  if (held[2] != 0) m[3] = m[4] = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (held[i] != 0) m[i] = 1;
  const double c0 = m[1] * m[2] - m[3] * m[3], c1 = m[0] * m[2] - m[4] * m[4], c2 = m[0] * m[1] - m[5] * m[5];
  const double c3 = m[4] * m[5] - m[0] * m[3], c4 = m[5] * m[3] - m[1] * m[4], c5 = m[4] * m[3] - m[2] * m[5];
  const double determinant = m[0] * c0 + m[5] * c5 + m[4] * c4;
  Symmetric inverse{};
  if (!(determinant > 1e-12 * m[0] * m[1] * m[2])) {
    // A node that hangs by one or two bars: any positive block will do.
    const double trace = k[0] + k[1] + k[2];
    for (std::size_t i = 0; i < 3; ++i)
      if (held[i] == 0 && trace > 0) inverse[i] = 1 / trace;
    return inverse;
  }
  inverse = {c0 / determinant, c1 / determinant, c2 / determinant,
             c3 / determinant, c4 / determinant, c5 / determinant};
  for (std::size_t i = 0; i < 3; ++i)
    if (held[i] != 0) inverse[i] = 0;
  return inverse;
}

}  // namespace

/// What PETSc's solver sees: the operator and the preconditioner on the free components.
class StaticSolver::Problem {
public:
  Problem(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
          const PdsOperators& operators, const IsotropicElasticity& elasticity, const Edges& edges,
          const ResidualStiffness& residual_stiffness, HeldComponents held)
      : group_(&group),
        subdomain_(&subdomain),
        operators_(&operators),
        elasticity_(&elasticity),
        residual_stiffness_(&residual_stiffness),
        held_(std::move(held)),
        round_node_(node_tetrahedra(subdomain)),
        product_(group, subdomain, operators, elasticity, edges, residual_stiffness),
        coarse_(group, subdomain, held_),
        inverse_block_(static_cast<std::size_t>(subdomain.layout.n_owned)),
        residual_(group, subdomain.layout),
        correction_(group, subdomain.layout),
        operand_(group, subdomain.layout),
        gradients_(residual_.vector()) {
    for (std::int32_t node = 0; node < subdomain.layout.n_owned; ++node) update_block(node);
    const PetscInt n = 3 * subdomain.layout.n_owned;
    check_petsc(MatCreateShell(group.get(), n, n, PETSC_DETERMINE, PETSC_DETERMINE, this, matrix_.put()),
                "MatCreateShell");
    check_petsc(
        MatShellSetOperation(matrix_.get(), MATOP_MULT, reinterpret_cast<void (*)(void)>(petsc_multiply)),
        "MatShellSetOperation");
    check_petsc(PCCreate(group.get(), preconditioner_.put()), "PCCreate");
    check_petsc(PCSetType(preconditioner_.get(), PCSHELL), "PCSetType");
    check_petsc(PCShellSetContext(preconditioner_.get(), this), "PCShellSetContext");
    check_petsc(PCShellSetApply(preconditioner_.get(), petsc_precondition), "PCShellSetApply");
    check_petsc(PCSetOperators(preconditioner_.get(), matrix_.get(), matrix_.get()), "PCSetOperators");
    check_petsc(PCSetUp(preconditioner_.get()), "PCSetUp");
  }

  void release(std::span<const std::int32_t> tetrahedra) {
    product_.update(tetrahedra);
    for (const auto t : tetrahedra)
      for (const auto node : subdomain_->tetrahedra[index(t)])
        if (node < subdomain_->layout.n_owned) update_block(node);
  }

  double residual() const { return final_residual_; }

  int solve(std::span<const double> force, parallel::NodeField& displacement) {
    refresh_coarse();
    // From here on every rank waits for messages of the others, and no rank allocates.
    parallel::agree(*group_);
    // The reference is the residual of a body whose free components have not moved.
    for (std::size_t i = 0; i < held_.size(); ++i)
      operand_.local()[i] = held_[i] != 0 ? displacement.local()[i] : 0;
    const double reference = find_residual(force, operand_);
    final_residual_ = 0;
    if (reference == 0) {  // so it is in equilibrium, whatever the guess was
      displacement.assign(operand_);
      return 0;
    }
    const double tolerance = relative_tolerance * reference;
    int iterations = 0;
    double residual = find_residual(force, displacement);
    for (int run = 0;; ++run) {
      final_residual_ = residual / reference;
      // Equal on every rank. An infinite reference would make an equilibrium of any residual.
      if (!std::isfinite(residual) || !std::isfinite(reference))
        fail<NoEquilibrium>(
            "static equilibrium: the residual is {:.1e} and that of the load {:.1e} after {} "
            "iterations; both must be finite numbers",
            residual, reference, iterations);
      if (residual <= (run == 0 ? 1 : drift_allowance) * tolerance) break;
      if (run == max_runs) {
        if (residual <= rounding_allowance * reference) break;
        fail<NoEquilibrium>(
            "static equilibrium: the residual is still {:.1e} of the load after {} "
            "iterations",
            residual / reference, iterations);
      }
      const auto [has_converged, n] =
          gradients_.solve(matrix_.get(), preconditioner_.get(), residual_.vector(), correction_.vector(),
                           tolerance, max_iterations);
      iterations += n;
      const auto correction = correction_.owned();
      const auto result = displacement.owned();
      for (std::size_t i = 0; i < result.size(); ++i) result[i] += correction[i];
      displacement.update_ghosts();
      if (!has_converged)
        fail<NoEquilibrium>("static equilibrium: no convergence in {} iterations", iterations);
      residual = find_residual(force, displacement);
    }
    if (fresh_iterations_ == 0)
      fresh_iterations_ = std::max(iterations, 1);
    else if (iterations > wear_limit * fresh_iterations_ + 10)
      coarse_is_current_ = false;
    return iterations;
  }

private:
  /// Into residual_: f - K u on the free components.
  /// @return its norm in the preconditioner's scalar product
  double find_residual(std::span<const double> force, parallel::NodeField& displacement) {
    displacement.update_ghosts();
    const auto residual = residual_.owned();
    try {
      product_.apply(displacement, residual);
    } catch (const std::runtime_error& error) {  // what it refuses, it refuses on every rank
      fail<NoEquilibrium>("static equilibrium: {}", error.what());
    }
    for (std::size_t i = 0; i < residual.size(); ++i)
      residual[i] = held_[i] != 0 ? 0 : force[i] - residual[i];
    residual_.mark_changed();
    precondition(residual, correction_.owned());
    return std::sqrt(parallel::reproducible_dot(group_->get(), residual, correction_.owned()));
  }

  void refresh_coarse() {
    if (coarse_is_current_) return;
    coarse_.factorize(*operators_, *elasticity_, *residual_stiffness_);
    coarse_is_current_ = true;
    fresh_iterations_ = 0;
  }

  /// Sum over what the node's tetrahedra carry, in ascending order, of its diagonal block.
  void update_block(std::int32_t node) {
    Symmetric k{};
    for (const auto number : round_node_[node]) {
      if (!residual_stiffness_->carries(number)) continue;
      const auto& t = operators_->tetrahedra[index(number)];
      const auto corner = static_cast<std::size_t>(std::ranges::find(t.nodes, node) - t.nodes.begin());
      if (!residual_stiffness_->is_intact(number)) {
        const Matrix m = residual_stiffness_->partial(number).coupling(corner, corner);
        for (std::size_t i = 0; i < 3; ++i) k[i] += t.volume * m[i][i];
        k[3] += t.volume * m[1][2];
        k[4] += t.volume * m[0][2];
        k[5] += t.volume * m[0][1];
        continue;
      }
      const auto& g = t.gradient[corner];
      const double shear = t.volume * elasticity_->mu * dot(g, g);
      const double mean = t.volume * (elasticity_->lambda + elasticity_->mu);
      k[0] += mean * (g[0] * g[0]) + shear;
      k[1] += mean * (g[1] * g[1]) + shear;
      k[2] += mean * (g[2] * g[2]) + shear;
      k[3] += mean * (g[1] * g[2]);
      k[4] += mean * (g[0] * g[2]);
      k[5] += mean * (g[0] * g[1]);
    }
    inverse_block_[index(node)] = inverse_on_free(k, &held_[3 * index(node)]);
  }

  void multiply(std::span<const double> x, std::span<double> y) {
    std::ranges::copy(x, operand_.owned().begin());
    operand_.update_ghosts();
    product_.apply(operand_, y);
    for (std::size_t i = 0; i < y.size(); ++i)
      if (held_[i] != 0) y[i] = 0;
  }

  void precondition(std::span<const double> x, std::span<double> y) const {
    for (std::size_t n = 0; n < inverse_block_.size(); ++n) {
      const Vector z = mechanics::apply(inverse_block_[n], {x[3 * n], x[3 * n + 1], x[3 * n + 2]});
      std::ranges::copy(z, y.begin() + static_cast<std::ptrdiff_t>(3 * n));
    }
    coarse_.add_correction(x, y);
  }

  /// Calls work(x, y) on the vectors' owned values.
  template <class Work>
  static PetscErrorCode on_values(Vec x, Vec y, const Work& work) {
    return parallel::without_exceptions([&] {
      const parallel::ReadValues from(x);
      const parallel::WrittenValues to(y);
      work(*from, *to);
    });
  }

  static PetscErrorCode petsc_multiply(Mat matrix, Vec x, Vec y) {
    Problem* problem = nullptr;
    PetscCall(MatShellGetContext(matrix, &problem));
    return on_values(x, y, [&](auto from, auto to) { problem->multiply(from, to); });
  }

  static PetscErrorCode petsc_precondition(PC preconditioner, Vec x, Vec y) {
    Problem* problem = nullptr;
    PetscCall(PCShellGetContext(preconditioner, &problem));
    return on_values(x, y, [&](auto from, auto to) { problem->precondition(from, to); });
  }

  const parallel::Communicator* group_;
  const geometry::Subdomain* subdomain_;
  const PdsOperators* operators_;
  const IsotropicElasticity* elasticity_;
  const ResidualStiffness* residual_stiffness_;
  HeldComponents held_;
  NodeTetrahedra round_node_;
  StiffnessProduct product_;
  CoarseSpace coarse_;
  std::vector<Symmetric> inverse_block_;  // of each owned node
  parallel::NodeField residual_;
  parallel::NodeField correction_;
  parallel::NodeField operand_;
  parallel::MatOwner matrix_;
  parallel::PcOwner preconditioner_;
  parallel::ConjugateGradients gradients_;
  bool coarse_is_current_ = false;
  double final_residual_ = 0;
  int fresh_iterations_ = 0;  // of the first solve with the current coarse matrix; 0 before it
};

StaticSolver::StaticSolver(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const PdsOperators& operators, const IsotropicElasticity& elasticity,
                           const Edges& edges, const ResidualStiffness& residual_stiffness,
                           HeldComponents held)
    : problem_(std::make_unique<Problem>(group, subdomain, operators, elasticity, edges, residual_stiffness,
                                         std::move(held))) {}

StaticSolver::~StaticSolver() = default;

void StaticSolver::release(std::span<const std::int32_t> tetrahedra) {
  problem_->release(tetrahedra);
}

double StaticSolver::residual() const {
  return problem_->residual();
}

int StaticSolver::solve(std::span<const double> force, parallel::NodeField& displacement) {
  return problem_->solve(force, displacement);
}

}  // namespace crackle::mechanics
