// SPDX-License-Identifier: GPL-3.0-or-later
#include "stiffness_product.h"

#include "crackle/common/real.h"
#include "crackle/parallel/collectives.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace crackle::mechanics {

namespace {

// Exponents of integers. Contributions and half differences are converted below 2^50; aiming lower leaves
// room for an operand whose gain is larger than that of the last one. Displacements are kept below 2^60: what
// the conversion makes of a difference that is too large for it is then still a number, and above 2^50.
constexpr int converted_exponent = 50;
constexpr int displacement_exponent = 60;
constexpr int safe_exponent = 48;
constexpr int aimed_exponent = 49;
constexpr int poor_exponent = 40;
constexpr int retreat = 4;
constexpr int least_exponent = 32;

double stiffest_entry(const parallel::Communicator& group, const PdsOperators& operators,
                      const IsotropicElasticity& elasticity, const Edges& edges,
                      const ResidualStiffness& residual_stiffness) {
  double stiffest = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto k =
        edge_coupling(operators, elasticity, edges, residual_stiffness, static_cast<std::int32_t>(e));
    for (const double s : k.s) stiffest = std::max(stiffest, std::abs(s));
    for (const double w : k.w) stiffest = std::max(stiffest, std::abs(w));
  }
  parallel::agree(group);
  stiffest = parallel::largest_of_all(group, stiffest);
  return stiffest > 0 ? stiffest : 1;
}

}  // namespace

StiffnessProduct::StiffnessProduct(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                   const PdsOperators& operators, const IsotropicElasticity& elasticity,
                                   const Edges& edges, const ResidualStiffness& residual_stiffness)
    : group_(&group),
      unit_(std::ldexp(
          1.0, std::ilogb(stiffest_entry(group, operators, elasticity, edges, residual_stiffness)) + 3)) {
  const std::vector<double> no_mass(static_cast<std::size_t>(subdomain.layout.n_owned), 1.0);
  force_ = std::make_unique<FixedPointForce<double>>(subdomain, operators, elasticity, edges,
                                                     residual_stiffness, no_mass,
                                                     FixedPointScale{1, 1, unit_}, best_instruction_set());
}

void StiffnessProduct::apply(const parallel::NodeField& displacement, std::span<double> force) {
  double size = 0;
  for (const double u : displacement.owned())
    if (!(std::abs(u) <= size)) size = std::isnan(u) ? infinity : std::abs(u);
  size = parallel::largest_of_all(*group_, size);
  if (!std::isfinite(size)) throw std::runtime_error("stiffness product: the operand is not finite");
  if (size == 0) {
    std::ranges::fill(force, 0.0);
    return;
  }
  const int size_exponent = std::ilogb(size) + 1;
  const auto nodes = force_->nodes();
  const auto u = displacement.local();
  // Exponent of the displacements' integers.
  int top =
      gain_exponent_ ? std::min(aimed_exponent - *gain_exponent_, displacement_exponent) : safe_exponent;
  for (bool is_first = true;; is_first = false) {
    const int exponent = top - size_exponent;
    const double scale = std::ldexp(1.0, exponent);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (std::size_t i = 0; i < 3; ++i) nodes[n].displacement[i] = std::llrint(u[3 * n + i] * scale);
      std::ranges::fill(nodes[n].force, 0);
    }
    for (std::int32_t b = 0; b < force_->n_blocks(); ++b) force_->add_block(b);
    // Where all contributions fit, the largest is that of an edge of the body, with the same bits on every
    // rank that has it, for either direction of the edge. Where one does not, the number is rubbish that
    // depends on the direction, and so on the partition: then nothing but the fact is used.
    const double contribution = parallel::largest_of_all(*group_, force_->take_largest_contribution());
    if (!(contribution < std::ldexp(1.0, converted_exponent))) {
      gain_exponent_.reset();
      // The safe scale is so for the coefficients that the body had at first.
      top = top > safe_exponent ? safe_exponent : top - retreat;
      if (top < least_exponent)
        throw std::runtime_error("stiffness product: a coefficient is not finite, or has grown out of range");
      continue;
    }
    gain_exponent_.reset();
    if (contribution > 0) gain_exponent_ = std::ilogb(contribution) + 1 - top;
    if (is_first && contribution > 0 && contribution < std::ldexp(1.0, poor_exponent)) {
      top = std::min(aimed_exponent - *gain_exponent_, displacement_exponent);
      continue;
    }
    const double quantum = unit_ / scale;
    for (std::size_t i = 0; i < force.size(); ++i)
      force[i] = quantum * static_cast<double>(nodes[i / 3].force[i % 3]);
    return;
  }
}

}  // namespace crackle::mechanics
