// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "fracture/breakable_body.h"
#include "mechanics/operators.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// The nodal forces of the initial strain of a body in motion, during which that is constant: by these the
/// internal force is less than stiffness times displacement. Bitwise independent of the partition: each is
/// the sum over the tetrahedra around the node, in ascending order.
/// @tparam Number double [N], or an integer number of quanta
template <class Number>
class InitialForce {
public:
  using OfNode = std::array<Number, 3>;
  /// Turns the forces of a tetrahedron at its corners [N] into numbers.
  using Convert = std::function<std::array<OfNode, 4>(const std::array<Vector, 4>& forces)>;

  /// @param body must outlive the object
  InitialForce(const fracture::BreakableBody& body, Convert convert)
      : body_(&body), convert_(std::move(convert)) {
    if (body.initial_strain().is_none()) return;
    around_ = mechanics::node_tetrahedra(body.subdomain());
    for (std::int32_t node = 0; node < body.subdomain().layout.n_owned; ++node)
      force_.push_back(sum_at(node));
  }

  bool is_none() const { return force_.empty(); }
  std::span<const OfNode> values() const { return force_; }  ///< of the owned nodes, unless there is none

  /// Follows the stiffness of these tetrahedra.
  /// @param change is called with each owned node whose force may have changed, and the force before
  template <class Change>
  void update(std::span<const std::int32_t> tetrahedra, const Change& change) {
    if (is_none()) return;
    std::vector<std::int32_t> nodes;
    for (const auto t : tetrahedra)
      for (const auto node : body_->subdomain().tetrahedra[index(t)])
        if (node < body_->subdomain().layout.n_owned) nodes.push_back(node);
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    for (const auto node : nodes) change(index(node), std::exchange(force_[index(node)], sum_at(node)));
  }

private:
  OfNode sum_at(std::int32_t node) const {
    OfNode sum{};
    for (const auto number : around_[node]) {
      if (!body_->residual_stiffness().carries(number)) continue;
      const auto& t = body_->operators().tetrahedra[index(number)];
      const auto sigma = body_->residual_stiffness().own_stress(number, body_->initial_strain()[number]);
      std::array<Vector, 4> forces{};
      for (std::size_t a = 0; a < 4; ++a) forces[a] = t.volume * mechanics::apply(sigma, t.gradient[a]);
      const auto corner = static_cast<std::size_t>(std::ranges::find(t.nodes, node) - t.nodes.begin());
      const OfNode own = convert_(forces)[corner];
      for (std::size_t i = 0; i < 3; ++i) sum[i] += own[i];
    }
    return sum;
  }

  const fracture::BreakableBody* body_;
  Convert convert_;
  mechanics::NodeTetrahedra around_;
  std::vector<OfNode> force_;
};

}  // namespace crackle::dynamics
