// SPDX-License-Identifier: GPL-3.0-or-later
#include "stiffness_product.h"

#include "crackle/parallel/collectives.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace crackle::mechanics {

namespace {

// Exponents of integers: displacements are kept below 2^61, contributions and differences are converted below
// 2^50; aiming lower leaves room for an operand whose gain is larger than that of the last one.
constexpr int displacement_exponent = 61;
constexpr int safe_exponent = 48;
constexpr int aimed_exponent = 49;
constexpr int poor_exponent = 40;

double stiffest_entry(const parallel::Communicator& group, const PdsOperators& operators,
                      const IsotropicElasticity& elasticity, const Edges& edges, const Integrity& integrity) {
  double stiffest = 0;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto k = edge_coupling(operators, elasticity, edges, integrity, static_cast<std::int32_t>(e));
    for (const double s : k.s) stiffest = std::max(stiffest, std::abs(s));
  }
  parallel::agree(group);
  stiffest = parallel::largest_of_all(group, stiffest);
  return stiffest > 0 ? stiffest : 1;
}

}  // namespace

StiffnessProduct::StiffnessProduct(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                   const PdsOperators& operators, const IsotropicElasticity& elasticity,
                                   const Edges& edges, const Integrity& integrity)
    : group_(&group),
      unit_(std::ldexp(1.0, std::ilogb(stiffest_entry(group, operators, elasticity, edges, integrity)) + 3)) {
  const std::vector<double> no_mass(static_cast<std::size_t>(subdomain.n_owned), 1.0);
  force_ =
      std::make_unique<FixedPointForce<double>>(subdomain, operators, elasticity, edges, integrity, no_mass,
                                                FixedPointScale{1, 1, unit_}, best_instruction_set());
}

void StiffnessProduct::apply(const parallel::NodeField& displacement, std::span<double> force) {
  double size = 0;
  for (const double u : displacement.owned()) size = std::max(size, std::abs(u));
  size = parallel::largest_of_all(*group_, size);
  if (size == 0) {
    std::ranges::fill(force, 0.0);
    return;
  }
  const int size_exponent = std::ilogb(size) + 1;
  const auto nodes = force_->nodes();
  const auto u = displacement.local();
  for (bool is_first = true;; is_first = false) {
    const int exponent =
        (has_gain_ ? std::min(aimed_exponent - gain_exponent_, displacement_exponent) : safe_exponent) -
        size_exponent;
    const double scale = std::ldexp(1.0, exponent);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (std::size_t i = 0; i < 3; ++i) nodes[n].displacement[i] = std::llrint(u[3 * n + i] * scale);
      std::ranges::fill(nodes[n].force, 0);
    }
    for (std::int32_t b = 0; b < force_->n_blocks(); ++b) force_->add_block(b);
    const double contribution = parallel::largest_of_all(*group_, force_->take_largest_contribution());
    if (!std::isfinite(contribution))
      throw std::runtime_error("stiffness product: the operand is not finite");
    const bool fits = contribution < std::ldexp(1.0, 50);
    gain_exponent_ =
        contribution > 0 ? std::ilogb(contribution) + 1 - exponent - size_exponent : gain_exponent_;
    has_gain_ = contribution > 0;
    if (!fits && exponent + size_exponent > safe_exponent) {
      // Too large a gain for the conversion to be trusted: once more from the scale that is always safe.
      has_gain_ = false;
      continue;
    }
    if (is_first && contribution > 0 && contribution < std::ldexp(1.0, poor_exponent)) continue;
    const double quantum = unit_ / scale;
    for (std::size_t i = 0; i < force.size(); ++i)
      force[i] = quantum * static_cast<double>(nodes[i / 3].force[i % 3]);
    return;
  }
}

}  // namespace crackle::mechanics
