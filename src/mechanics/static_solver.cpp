// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/static_solver.h"

#include "common/failure.h"
#include "common/index.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/ghost_exchange.h"
#include "parallel/reproducible.h"

#include "coarse_space.h"
#include "conjugate_gradients.h"
#include "stiffness_product.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::mechanics {

namespace {

/// Conjugate gradients multiply in single precision, so the recurrence residual drifts from the true one. It
/// is recomputed in double precision whenever it has decreased by this factor.
constexpr double reduction_per_run = 1e-2;
/// Accepted drift of the residual at the end.
constexpr double drift_allowance = 3;
/// After this many runs the residual is compared with rounding_allowance.
constexpr int max_runs = 20;
constexpr int max_iterations = 4000;
/// A component's limit where a run ends out of range, in units of the largest residual's.
constexpr float largest_correction = 1e30F;
/// The coarse matrix is rebuilt when a run needs this many times the iterations of the first run with it.
constexpr double wear_limit = 1.5;

/// The inverse of a symmetric positive definite 3 x 3 matrix on its free components; zero if the node has no
/// stiffness.
Symmetric inverse_on_free(const Symmetric& k, const std::uint8_t* constrained) {
  Symmetric m = k;
  if (constrained[0] != 0) m[4] = m[5] = 0;
  if (constrained[1] != 0) m[3] = m[5] = 0;
  if (constrained[2] != 0) m[3] = m[4] = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (constrained[i] != 0) m[i] = 1;
  const double c0 = m[1] * m[2] - m[3] * m[3], c1 = m[0] * m[2] - m[4] * m[4], c2 = m[0] * m[1] - m[5] * m[5];
  const double c3 = m[4] * m[5] - m[0] * m[3], c4 = m[5] * m[3] - m[1] * m[4], c5 = m[4] * m[3] - m[2] * m[5];
  const double determinant = m[0] * c0 + m[5] * c5 + m[4] * c4;
  Symmetric inverse{};
  if (!(determinant > 1e-12 * m[0] * m[1] * m[2])) {
    // A node constrained by one or two bars only: any positive block will do.
    const double trace = k[0] + k[1] + k[2];
    for (std::size_t i = 0; i < 3; ++i)
      if (constrained[i] == 0 && trace > 0) inverse[i] = 1 / trace;
    return inverse;
  }
  inverse = {c0 / determinant, c1 / determinant, c2 / determinant,
             c3 / determinant, c4 / determinant, c5 / determinant};
  for (std::size_t i = 0; i < 3; ++i)
    if (constrained[i] != 0) inverse[i] = 0;
  return inverse;
}

}  // namespace

class StaticSolver::Problem {
public:
  Problem(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
          const PdsOperators& operators, const ElasticityField& elasticity, const Edges& edges,
          const ResidualStiffness& residual_stiffness, HeldComponents constrained)
      : group_(&group),
        subdomain_(&subdomain),
        operators_(&operators),
        elasticity_(&elasticity),
        residual_stiffness_(&residual_stiffness),
        constrained_(std::move(constrained)),
        node_to_cell_(node_tetrahedra(subdomain)),
        product_(group, subdomain, operators, elasticity, edges, residual_stiffness),
        fast_product_(group, subdomain, operators, elasticity, edges, residual_stiffness),
        coarse_(group, subdomain, edges, constrained_),
        inverse_block_(static_cast<std::size_t>(subdomain.layout.n_owned)),
        product_result_(3 * inverse_block_.size()),
        residual_(product_result_.size()),
        correction_(product_result_.size()),
        last_(product_result_.size()),
        unmoved_(group, subdomain.layout),
        direction_(subdomain.nodes.size()),
        ghosts_(group, subdomain.layout),
        gradients_(group, *this) {
    for (std::int32_t node = 0; node < subdomain.layout.n_owned; ++node) update_block(node);
    for (std::size_t i = 0; i < 3 * inverse_block_.size(); ++i)
      if (constrained_[i] != 0) constrained_components_.push_back(i);
  }

  void release(std::span<const std::int32_t> tetrahedra) {
    product_.update(tetrahedra);
    fast_product_.update(tetrahedra);
    if (node_to_cell_.offset.empty()) node_to_cell_ = node_tetrahedra(*subdomain_);
    for (const auto t : tetrahedra)
      for (const auto node : subdomain_->tetrahedra[index(t)])
        if (node < subdomain_->layout.n_owned) update_block(node);
  }

  void set_node_stiffness(std::span<const NodeStiffness> nodes) {
    parallel::check_peers(*group_);
    if (!parallel::any_of_all(*group_, !std::ranges::equal(nodes, springs_))) return;
    const auto before = std::exchange(springs_, {nodes.begin(), nodes.end()});
    has_springs_ = parallel::any_of_all(*group_, !springs_.empty());
    stretch_.resize(3 * springs_.size());
    spring_force_.resize(stretch_.size());
    if (node_to_cell_.offset.empty()) node_to_cell_ = node_tetrahedra(*subdomain_);
    for (const auto* list : {&before, &std::as_const(springs_)})
      for (const NodeStiffness& one : *list) update_block(one.node);
    coarse_is_current_ = false;
  }

  double residual() const { return final_residual_; }

  void rest() {
    product_.rest();
    fast_product_.rest();
    node_to_cell_ = {};
  }

  int solve(std::span<const double> force, parallel::NodeField& displacement, const Accuracy& accuracy) {
    product_.resume();
    fast_product_.resume();
    refresh_coarse();
    // From here on ranks wait for each other's messages, so none may allocate.
    parallel::check_peers(*group_);
    // The reference is the residual with no free component displaced.
    for (std::size_t i = 0; i < constrained_.size(); ++i)
      unmoved_.local()[i] = constrained_[i] != 0 ? displacement.local()[i] : 0;
    const double reference = find_residual(force, unmoved_);
    final_residual_ = 0;
    if (reference == 0) {  // in equilibrium, whatever the initial guess
      displacement.assign(unmoved_);
      return 0;
    }
    int iterations = 0;
    double residual = find_residual(force, displacement);
    for (int run = 0;; ++run) {
      final_residual_ = residual / reference;
      // Equal on every rank. With an infinite reference any residual would be accepted.
      if (!std::isfinite(residual) || !std::isfinite(reference))
        fail<NoEquilibrium>(
            "static equilibrium: the residual is {:.1e} and that of the load {:.1e} after {} "
            "iterations; both must be finite numbers",
            residual, reference, iterations);
      const double tolerance =
          std::min(accuracy.of_loads * reference, accuracy.of_displacement * energy_norm_);
      if (residual <= (run == 0 ? 1 : drift_allowance) * tolerance) break;
      if (run == max_runs) {
        if (residual <= rounding_allowance * reference) break;
        fail<NoEquilibrium>(
            "static equilibrium: the residual is still {:.1e} of the load after {} "
            "iterations",
            residual / reference, iterations);
      }
      using Start = ConjugateGradients<Problem>::Start;
      const auto result = displacement.owned();
      std::ranges::copy(result, last_.begin());
      const auto correct = [&] {
        for (std::size_t i = 0; i < result.size(); ++i)
          result[i] += unit_ * static_cast<double>(correction_[i]);
        displacement.update_ghosts();
      };
      bool has_converged = false;
      try {
        const auto outcome = gradients_.solve(
            residual_, correction_, std::max(tolerance, reduction_per_run * residual) / unit_, max_iterations,
            run == 0 ? Start::afresh : Start::beside_the_last);
        has_converged = outcome.has_converged;
        iterations += outcome.n_iterations;
      } catch (const std::runtime_error& error) {  // thrown on every rank
        // A mechanism moves until the numbers end, which the displacement is to show.
        for (float& one : correction_)
          one = std::isnan(one) ? 0 : std::clamp(one, -largest_correction, largest_correction);
        correct();
        fail<NoEquilibrium>("static equilibrium: {}", error.what());
      }
      correct();
      const double last_residual = std::exchange(residual, find_residual(force, displacement));
      if (!has_converged) {
        // A run with too tight a tolerance may end in rounding errors; its initial state is then the better
        // equilibrium.
        if (!(residual <= last_residual) && last_residual <= rounding_allowance * reference) {
          std::ranges::copy(last_, result.begin());
          residual = find_residual(force, displacement);
        }
        if (residual <= rounding_allowance * reference) {
          final_residual_ = residual / reference;
          break;
        }
        if (iterations >= max_iterations)
          fail<NoEquilibrium>("static equilibrium: no convergence in {} iterations", iterations);
        // Otherwise restart the next run.
      }
    }
    if (fresh_iterations_ == 0)
      fresh_iterations_ = std::max(iterations, 1);
    else if (iterations > wear_limit * fresh_iterations_ + 10)
      coarse_is_current_ = false;
    return iterations;
  }

private:
  /// Computes residual_: f - K u on the free components, scaled for single precision; and energy_norm_, that
  /// of the displacement.
  /// @return norm of the residual in the preconditioner's scalar product
  double find_residual(std::span<const double> force, parallel::NodeField& displacement) {
    displacement.update_ghosts();
    try {
      product_.apply(displacement.local(), product_result_);
    } catch (const std::runtime_error& error) {  // thrown on every rank
      fail<NoEquilibrium>("static equilibrium: {}", error.what());
    }
    add_forces(springs_, displacement.local(), product_result_);
    const double twice_energy =
        parallel::reproducible_dot(group_->get(), std::as_const(displacement).owned(), product_result_);
    energy_norm_ = std::sqrt(std::max(0.0, twice_energy));
    for (std::size_t i = 0; i < residual_.size(); ++i)
      product_result_[i] = constrained_[i] != 0 ? 0 : force[i] - product_result_[i];
    const double largest = parallel::largest_magnitude(*group_, product_result_);
    if (largest == 0 || !std::isfinite(largest)) return largest;
    unit_ = std::ldexp(1.0, std::ilogb(largest));
    for (std::size_t i = 0; i < residual_.size(); ++i)
      residual_[i] = static_cast<float>(product_result_[i] / unit_);
    return unit_ * std::sqrt(precondition(residual_, correction_));
  }

  void refresh_coarse() {
    if (coarse_is_current_) return;
    coarse_.factorize(*operators_, *elasticity_, *residual_stiffness_, springs_);
    coarse_is_current_ = true;
    fresh_iterations_ = 0;
  }

  /// Sums the diagonal block of a node over its tetrahedra's residual stiffness, in ascending order, and its
  /// own stiffness.
  void update_block(std::int32_t node) {
    Symmetric k{};
    for (const auto number : node_to_cell_[node]) {
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
      const auto& [lambda, mu] = (*elasticity_)[number];
      const double shear = t.volume * mu * dot(g, g);
      const double mean = t.volume * (lambda + mu);
      k[0] += mean * (g[0] * g[0]) + shear;
      k[1] += mean * (g[1] * g[1]) + shear;
      k[2] += mean * (g[2] * g[2]) + shear;
      k[3] += mean * (g[1] * g[2]);
      k[4] += mean * (g[0] * g[2]);
      k[5] += mean * (g[0] * g[1]);
    }
    if (const auto own = std::ranges::lower_bound(springs_, node, {}, &NodeStiffness::node);
        own != springs_.end() && own->node == node)
      for (std::size_t i = 0; i < k.size(); ++i) k[i] += own->stiffness[i];
    const Symmetric inverse = inverse_on_free(k, &constrained_[3 * index(node)]);
    std::ranges::transform(inverse, inverse_block_[coarse_.position(node)].begin(),
                           [](double x) { return static_cast<float>(x); });
  }

  // Interface for conjugate gradients: the operator and the preconditioner on the free components.
  friend ConjugateGradients<Problem>;

  std::span<float> direction() { return {direction_.data()->data(), 3 * inverse_block_.size()}; }

  double multiply(std::span<float> image) {
    ghosts_.update(direction_);
    double curvature = fast_product_.apply({direction_.data()->data(), 3 * direction_.size()}, image);
    if (has_springs_) curvature += add_spring_forces(image);
    for (const auto i : constrained_components_) image[i] = 0;
    return curvature;
  }

  /// @return direction . force of all ranks
  double add_spring_forces(std::span<float> image) {
    for (std::size_t n = 0; n < springs_.size(); ++n) {
      const auto first = index(springs_[n].node, 0);
      const Vector force = springs_[n].force(std::span<const float>(direction()));
      for (std::size_t i = 0; i < 3; ++i) {
        stretch_[3 * n + i] = direction()[first + i];
        spring_force_[3 * n + i] = static_cast<float>(force[i]);
        image[first + i] += spring_force_[3 * n + i];
      }
    }
    return parallel::reproducible_dot(group_->get(), std::span<const float>(stretch_),
                                      std::span<const float>(spring_force_));
  }

  double precondition(std::span<const float> residual, std::span<float> result) {
    const double bound = coarse_.precondition(residual, inverse_block_, result);
    for (const auto i : constrained_components_) result[i] = 0;
    return parallel::reproducible_dot(group_->get(), residual, result, bound);
  }

  const parallel::Communicator* group_;
  const geometry::Subdomain* subdomain_;
  const PdsOperators* operators_;
  const ElasticityField* elasticity_;
  const ResidualStiffness* residual_stiffness_;
  HeldComponents constrained_;
  NodeTetrahedra node_to_cell_;
  StiffnessProduct<double> product_;
  StiffnessProduct<float> fast_product_;
  CoarseSpace coarse_;
  std::vector<std::array<float, 6>> inverse_block_;  // of the owned nodes, in the order of the coarse space
  std::vector<std::size_t> constrained_components_;  // of owned nodes
  std::vector<NodeStiffness> springs_;
  bool has_springs_ = false;                   // on any rank
  std::vector<float> stretch_, spring_force_;  // of their nodes, in a direction
  std::vector<double> product_result_;
  double energy_norm_ = 0;  // of the displacement to which the residual belongs
  double unit_ = 1;         // of residual and correction
  std::vector<float> residual_;
  std::vector<float> correction_;
  std::vector<double> last_;     // owned displacement at the start of a run
  parallel::NodeField unmoved_;  // the displacement with no free component displaced
  using Numbers = std::array<float, 3>;
  std::vector<Numbers> direction_;  // of each local node
  parallel::GhostExchange<Numbers> ghosts_;
  ConjugateGradients<Problem> gradients_;
  bool coarse_is_current_ = false;
  double final_residual_ = 0;
  int fresh_iterations_ = 0;  // of the first solve with the current coarse matrix; 0 before it
};

StaticSolver::StaticSolver(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const PdsOperators& operators, const ElasticityField& elasticity,
                           const Edges& edges, const ResidualStiffness& residual_stiffness,
                           HeldComponents constrained)
    : problem_(std::make_unique<Problem>(group, subdomain, operators, elasticity, edges, residual_stiffness,
                                         std::move(constrained))) {}

StaticSolver::~StaticSolver() = default;

void StaticSolver::release(std::span<const std::int32_t> tetrahedra) {
  problem_->release(tetrahedra);
}

void StaticSolver::set_node_stiffness(std::span<const NodeStiffness> nodes) {
  problem_->set_node_stiffness(nodes);
}

void StaticSolver::rest() {
  problem_->rest();
}

double StaticSolver::residual() const {
  return problem_->residual();
}

int StaticSolver::solve(std::span<const double> force, parallel::NodeField& displacement,
                        const Accuracy& accuracy) {
  return problem_->solve(force, displacement, accuracy);
}

}  // namespace crackle::mechanics
