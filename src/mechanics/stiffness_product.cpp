// SPDX-License-Identifier: GPL-3.0-or-later
#include "stiffness_product.h"

#include "parallel/collectives.h"
#include "parallel/exact_sum.h"
#include "parallel/reproducible.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace crackle::mechanics {

namespace {

/// Exponents of a format's integers.
template <class Real>
struct Exponents;

/// Contributions and half differences are converted below 2^50; aiming lower leaves room for an operand with
/// a larger gain than the last one. Displacements are kept below 2^60, so that even differences too large for
/// the conversion give a number, above 2^50.
template <>
struct Exponents<double> {
  static constexpr int unit = 4;  // force quantum per displacement quantum, relative to the stiffness
  static constexpr int converted = 50;
  static constexpr int displacement = 60;
  static constexpr int safe = 48;
  static constexpr int aimed = 49;
  static constexpr int poor = 40;
  static constexpr int least = 32;
  static constexpr bool is_known_when_too_large = false;
};

/// Contributions stay below 2^28, so that neither their sum at a node nor a difference of displacements wraps
/// around.
template <>
struct Exponents<float> {
  static constexpr int unit = 0;
  static constexpr int converted = 28;
  static constexpr int displacement = 29;
  static constexpr int safe = 26;
  static constexpr int aimed = 26;
  static constexpr int poor = 21;
  static constexpr int least = 10;
  static constexpr bool is_known_when_too_large = true;
};
constexpr int retreat = 4;

/// Approximate upper bound on the stiffness of an edge: about ten tetrahedra meet at one.
double stiffest(const parallel::Communicator& group, const PdsOperators& operators,
                const ElasticityField& elasticity) {
  parallel::check_peers(group);
  const double stiffest = parallel::largest_of_all(group, stiffness_bound(operators, elasticity));
  return stiffest > 0 ? stiffest : 1;
}

}  // namespace

template <class Real>
StiffnessProduct<Real>::StiffnessProduct(const parallel::Communicator& group,
                                         const geometry::Subdomain& subdomain, const PdsOperators& operators,
                                         const ElasticityField& elasticity, const Edges& edges,
                                         const ResidualStiffness& residual_stiffness)
    : group_(&group),
      subdomain_(&subdomain),
      operators_(&operators),
      elasticity_(&elasticity),
      edges_(&edges),
      residual_stiffness_(&residual_stiffness),
      unit_(std::ldexp(1.0, std::ilogb(stiffest(group, operators, elasticity)) + Exponents<Real>::unit)),
      cell_kernels_(&kernels::cell_kernels(best_instruction_set())) {
  resume();
}

template <class Real>
void StiffnessProduct<Real>::resume() {
  if (force_) return;
  force_.emplace(*subdomain_, *operators_, *elasticity_, *edges_, *residual_stiffness_,
                 std::vector<double>(static_cast<std::size_t>(subdomain_->layout.n_owned), 1.0),
                 FixedPointScale{1, 1, unit_}, best_instruction_set(), true);
}

template <class Real>
double StiffnessProduct<Real>::apply(std::span<const Real> displacement, std::span<Real> force) {
  using Exponents = Exponents<Real>;
  const double size = parallel::largest_magnitude(*group_, displacement.first(force.size()));
  if (!std::isfinite(size)) throw std::runtime_error("stiffness product: the operand is not finite");
  if (size == 0) {
    std::ranges::fill(force, Real(0));
    return 0;
  }
  const int size_exponent = std::ilogb(size) + 1;
  // Exponent of the displacements' integers.
  int top = gain_exponent_ ? std::min(Exponents::aimed - *gain_exponent_, Exponents::displacement)
                           : Exponents::safe;
  for (bool is_first = true;; is_first = false) {
    const int exponent = top - size_exponent;
    const double scale = std::ldexp(1.0, exponent);
    set_displacements(displacement, scale);
    for (std::int32_t b = 0; b < force_->n_blocks(); ++b) force_->add_block(b);
    // If all contributions fit, the largest is that of an edge of the body, bitwise equal on every rank that
    // has the edge, in either direction. If one does not fit, the resulting number depends on the direction
    // and hence on the partition: then only the overflow itself is used.
    const double contribution = parallel::largest_of_all(*group_, force_->take_largest_contribution());
    if (!(contribution < std::ldexp(1.0, Exponents::converted))) {
      gain_exponent_.reset();
      if (Exponents::is_known_when_too_large && std::isfinite(contribution))
        top = Exponents::aimed - (std::ilogb(contribution) + 1 - top);
      else  // The safe scale refers to the body's initial coefficients.
        top = top > Exponents::safe ? Exponents::safe : top - retreat;
      if (top < Exponents::least)
        throw std::runtime_error("stiffness product: a coefficient is not finite or is out of range");
      continue;
    }
    gain_exponent_.reset();
    if (contribution > 0) gain_exponent_ = std::ilogb(contribution) + 1 - top;
    if (is_first && contribution > 0 && contribution < std::ldexp(1.0, Exponents::poor)) {
      top = std::min(Exponents::aimed - *gain_exponent_, Exponents::displacement);
      continue;
    }
    const double quantum = unit_ / scale;
    return quantum / scale * parallel::integer_sum(*group_, get_forces(quantum, force));
  }
}

template <class Real>
void StiffnessProduct<Real>::set_displacements(std::span<const Real> displacement, double scale) {
  const auto nodes = force_->nodes();
  if constexpr (sizeof(Real) == 4) {
    cell_kernels_->set_displacements(nodes.data(), nodes.size(), displacement.data(), scale);
  } else {
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (std::size_t i = 0; i < 3; ++i)
        nodes[n].displacement[i] = std::llrint(displacement[3 * n + i] * scale);
      std::ranges::fill(nodes[n].force, 0);
    }
  }
}

template <class Real>
__int128 StiffnessProduct<Real>::get_forces(double quantum, std::span<Real> force) {
  const auto nodes = force_->nodes().first(force.size() / 3);
  if constexpr (sizeof(Real) == 4) {
    return cell_kernels_->get_forces(nodes.data(), nodes.size(), quantum, force.data());
  } else {
    __int128 work = 0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (std::size_t i = 0; i < 3; ++i) {
        work += static_cast<__int128>(nodes[n].displacement[i]) * nodes[n].force[i];
        force[3 * n + i] = quantum * static_cast<double>(nodes[n].force[i]);
      }
    }
    return work;
  }
}

template class StiffnessProduct<float>;
template class StiffnessProduct<double>;

}  // namespace crackle::mechanics
